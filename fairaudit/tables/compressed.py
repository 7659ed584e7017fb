"""Files that may be compressed, opened as what is inside."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import IO, cast

from fairaudit.errors import InputError

__all__ = ["ZSTANDARD", "is_compressed", "opened", "opened_stream"]

GZIP, BZIP2, XZ, ZSTANDARD = b"\x1f\x8b", b"BZh", b"\xfd7zXZ\x00", b"\x28\xb5\x2f\xfd"


@contextmanager
def opened(path: Path, unfit: Mapping[bytes, str], name: str = "") -> Iterator[IO[bytes]]:
    """Open a file, or what is inside if it is compressed by gzip, bzip2 or xz; whatever goes wrong while it is read is a sentence.

    Parameters
    ----------
    path : Path
        The file.
    unfit : mapping of bytes to str
        Beginnings of files that are not read, and what is said of them.
    name : str
        What messages begin with.

    Raises
    ------
    InputError
        If it cannot be read.

    Examples
    --------
    >>> import bz2, tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = Path(folder) / "a.csv.bz2"
    ...     _ = path.write_bytes(bz2.compress(b"a,b"))
    ...     with opened(path, {}) as file:
    ...         file.read()
    b'a,b'
    """
    try:
        with path.open("rb") as file:
            magic = file.peek(6)[:6]
            for beginning, said in unfit.items():
                if magic.startswith(beginning):
                    raise InputError(f"{name}{said}")
            with _inside(file, magic) as inside:
                yield inside
    except InputError:
        raise
    except FileNotFoundError:
        raise InputError(f"{name}there is no such file") from None
    except IsADirectoryError:
        raise InputError(f"{name}this is a directory; name a file") from None
    except EOFError:
        raise InputError(f"{name}the compressed file is damaged: it ends too early, and was cut") from None
    except _damaged() as error:
        raise InputError(f"{name}the compressed file is damaged: {error}") from None
    except (OSError, ValueError) as error:
        raise InputError(f"{name}the file cannot be read: {getattr(error, 'strerror', None) or error}") from None


def opened_stream(file: IO[bytes]) -> IO[bytes]:
    """Open what is inside a file that is open, can be sought in, and may be compressed."""
    magic = file.read(6)
    file.seek(0)
    return _inside(file, magic)


def is_compressed(magic: bytes) -> bool:
    """Whether a file begins as one does that is opened as what is inside.

    Examples
    --------
    >>> is_compressed(b"BZh91A"), is_compressed(b"a,b")
    (True, False)
    """
    return magic.startswith((GZIP, BZIP2, XZ))


def _inside(file: IO[bytes], magic: bytes) -> IO[bytes]:
    if magic.startswith(GZIP):
        import gzip

        return cast("IO[bytes]", gzip.open(file))
    if magic.startswith(BZIP2):
        import bz2

        return cast("IO[bytes]", bz2.open(file))
    if magic.startswith(XZ):
        import lzma

        return cast("IO[bytes]", lzma.open(file))
    return file


def _damaged() -> tuple[type[Exception], ...]:
    """What is raised where what is compressed is damaged; looked up only where something is."""
    import gzip
    import lzma
    import zlib

    return zlib.error, lzma.LZMAError, gzip.BadGzipFile
