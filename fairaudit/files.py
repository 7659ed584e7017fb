"""Files that appear whole or not at all."""

from __future__ import annotations

import contextlib
import os
import tempfile
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

from fairaudit.errors import InputError

__all__ = ["write_atomically", "write_together"]


def write_atomically(path: Path, lines: Any) -> None:
    """Write a file so that it appears whole or not at all.

    Raises
    ------
    InputError
        If it cannot be written.
    """
    write_together([(path, lines)])


def write_together(files: Iterable[tuple[Path, Any]]) -> None:
    """Write files so that each appears whole, and none of them where one cannot be written.

    Parameters
    ----------
    files : iterable of (path, iterable of bytes)
        In the order in which they are to appear.

    Raises
    ------
    InputError
        If one cannot be written.
    """
    ready: list[tuple[str, Path, Path]] = []
    try:
        for path, lines in files:
            with _naming(path):
                target = Path(os.path.realpath(path))
                if target.is_dir():
                    raise InputError(f"{path} is a directory; name a file to write")
                handle, temporary = tempfile.mkstemp(prefix=".fairaudit-", suffix=".part", dir=target.parent)
                ready.append((temporary, target, path))
                with os.fdopen(handle, "wb") as file:
                    file.writelines(lines)
                    file.flush()
                    os.fsync(file.fileno())
                mask = os.umask(0)
                os.umask(mask)
                os.chmod(temporary, 0o666 & ~mask)
        while ready:
            temporary, target, path = ready[0]
            with _naming(path):
                os.replace(temporary, target)
            del ready[0]
    finally:
        for temporary, _, _ in ready:
            with contextlib.suppress(OSError):
                os.unlink(temporary)


@contextlib.contextmanager
def _naming(path: Path) -> Iterator[None]:
    """Say in one sentence why a file cannot be written."""
    try:
        yield
    except InputError:
        raise
    except OSError as error:
        raise InputError(f"{path} cannot be written: {error.strerror or error}") from None
    except ValueError as error:
        raise InputError(f"{str(path)!r} is not a file name: {error}") from None
