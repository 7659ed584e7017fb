"""Files that appear whole or not at all, such as are not long, and such as people write in sections (TOML)."""

from __future__ import annotations

import contextlib
import io
import os
import shutil
import stat
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar, cast

from fairaudit.errors import InputError, nearest, shown

__all__ = [
    "check_keys",
    "csv_text",
    "read_bounded",
    "read_bytes",
    "read_one_of",
    "read_section",
    "read_text",
    "read_toml",
    "write_atomically",
    "write_folder",
    "write_together",
]

Known = TypeVar("Known", bound=str)


def read_bounded(
    path: str | os.PathLike[str], most: int, what: str, accept: Callable[[os.stat_result, bytes], object] | None = None
) -> bytes:
    """Read a file that is not long.

    Parameters
    ----------
    path : path
        The file.
    most : int
        How many bytes it may have.
    what : str
        What it is, for messages.
    accept : callable, optional
        Is given the rights of the file that was opened and what was read, and refuses it by an `InputError`.

    Raises
    ------
    InputError
        If it cannot be read, or is longer.
    """
    try:
        with Path(path).open("rb") as file:
            found, raw = os.fstat(file.fileno()), file.read(most + 1)
            if accept is not None:
                accept(found, raw)
    except InputError:
        raise
    except OSError as error:
        raise InputError(f"{path} cannot be read: {error.strerror or error}") from None
    except ValueError as error:
        raise InputError(f"{str(path)!r} is not a file name: {error}") from None
    if len(raw) > most:
        raise InputError(f"{path} is longer than {most} bytes, which no {what} is")
    return raw


def read_bytes(path: Path) -> bytes:
    """Read a whole file.

    Raises
    ------
    InputError
        If it is not there, or cannot be read.
    """
    try:
        return path.read_bytes()
    except (FileNotFoundError, IsADirectoryError):
        raise InputError(f"{path}: there is no such file") from None
    except OSError as error:
        raise InputError(f"{path}: the file cannot be read: {error.strerror}") from None


def read_toml(path: Path) -> tuple[dict[str, Any], bytes]:
    """Read a file, with its bytes; numbers with a point stay the text that they are.

    Raises
    ------
    InputError
        If it cannot be read, or is not TOML.
    """
    import tomllib

    data = read_bytes(path)
    try:
        return tomllib.loads(data.decode("utf-8"), parse_float=str), data
    except (UnicodeDecodeError, tomllib.TOMLDecodeError, RecursionError) as error:
        raise InputError(f"{path}: this is not a TOML file: {error}") from None


def read_section(document: Mapping[str, Any], name: str) -> dict[str, Any]:
    """Find a section of a file; one that is not there is empty.

    Raises
    ------
    InputError
        If the name stands for something else.

    Examples
    --------
    >>> read_section({"targets": {"max_local_log": "0.2"}}, "targets"), read_section({}, "targets")
    ({'max_local_log': '0.2'}, {})
    """
    found = document.get(name, {})
    if not isinstance(found, dict):
        raise InputError(f"{name} must be a section [{name}], not {shown(found)}")
    return found


def read_text(section: Mapping[str, Any], key: str, where: str, default: str | None = None) -> str:
    """Find a text in a section.

    Raises
    ------
    InputError
        If it is not there and there is no default, or is no text.

    Examples
    --------
    >>> read_text({"table": "loans.csv"}, "table", "[policy]"), read_text({}, "weight", "[policy]", "n")
    ('loans.csv', 'n')
    """
    value = section.get(key, default)
    if not isinstance(value, str):
        raise InputError(f'{where} needs {key} = "…", a text' + ("" if value is None else f", not {shown(value)}"))
    return value


def read_one_of(section: Mapping[str, Any], key: str, known: Sequence[Known], where: str, default: str | None = None) -> Known:
    """Find one of the known words in a section.

    Raises
    ------
    InputError
        If it is another word, or not there and there is no default.

    Examples
    --------
    >>> read_one_of({"order": "bth"}, "order", ("both", "fixed"), "[sampling]")
    Traceback (most recent call last):
    fairaudit.errors.InputError: [sampling] order is 'bth'; known: 'both', 'fixed'; did you mean 'both'?
    """
    value = section.get(key, default)
    if value not in known:
        raise InputError(f"{where} {key} is {shown(value)}; {nearest(str(value), known)}")
    return cast("Known", value)


def csv_text(rows: Iterable[Iterable[object]]) -> str:
    r"""Rows as the text of a CSV file.

    Examples
    --------
    >>> csv_text([["name", "share"], ["Doe, J.", "1/2"]])
    'name,share\n"Doe, J.",1/2\n'
    """
    import csv

    text = io.StringIO(newline="")
    csv.writer(text, lineterminator="\n").writerows(rows)
    return text.getvalue()


def check_keys(given: Mapping[str, Any], keys: Sequence[str], where: str) -> None:
    """Refuse keys that are not known.

    Raises
    ------
    InputError
        If there is one; the message names the nearest that is known.

    Examples
    --------
    >>> check_keys({"gama": "1"}, ["gamma", "tau"], "[utility]")
    Traceback (most recent call last):
    fairaudit.errors.InputError: [utility] has the unknown key 'gama'; known: 'gamma', 'tau'; did you mean 'gamma'?
    """
    for key in given:
        if key not in keys:
            raise InputError(f"{where} has the unknown key {shown(key)}; {nearest(key, keys)}")


def write_atomically(path: Path, lines: Any) -> None:
    """Write a file so that it appears whole or not at all.

    Raises
    ------
    InputError
        If it cannot be written.
    """
    write_together([(path, lines)])


def write_together(files: Iterable[tuple[Path, Any]]) -> None:
    """Write files so that each appears whole, and none of them where one cannot be written: what was there before is put back then.

    A file that is there keeps its rights. A process that is killed between two files leaves those before, and hidden files
    ``.fairaudit-*.part``, which may be removed.

    Parameters
    ----------
    files : iterable of (path, iterable of bytes)
        In the order in which they are to appear; so what makes no sense without the others comes last.

    Raises
    ------
    InputError
        If one cannot be written.
    """
    ready: list[tuple[str, Path, Path]] = []
    beside: list[str] = []
    replaced: list[tuple[Path, str]] = []
    try:
        for path, lines in files:
            with _naming(path):
                target = Path(os.path.realpath(path))
                if target.is_dir():
                    raise InputError(f"{path} is a directory; name a file to write")
                handle, temporary = tempfile.mkstemp(prefix=".fairaudit-", suffix=".part", dir=target.parent)
                beside.append(temporary)
                ready.append((temporary, target, path))
                with os.fdopen(handle, "wb") as file:
                    file.writelines(lines)
                    file.flush()
                    os.fsync(file.fileno())
                os.chmod(temporary, _rights(target))
        for temporary, target, path in ready[:-1]:
            with _naming(path):
                beside.append(old := _kept(target, temporary))
                os.replace(temporary, target)
                replaced.append((target, old))
        for temporary, target, path in ready[-1:]:  # after which there is nothing to put back
            with _naming(path):
                os.replace(temporary, target)
                replaced.clear()
    except BaseException:
        for target, old in reversed(replaced):
            try:
                if old:
                    os.replace(old, target)
                else:
                    target.unlink(missing_ok=True)
            except OSError:
                beside.remove(old)  # what was there stays beside it
        raise
    finally:
        for name in filter(None, beside):
            with contextlib.suppress(OSError):
                os.unlink(name)


def write_folder(path: Path, files: Mapping[str, bytes]) -> None:
    """Write files into a folder that is not there, or empty, so that it appears whole or not at all; one that is there keeps its rights.

    Raises
    ------
    InputError
        If it cannot be written.
    """
    target = Path(os.path.realpath(path))
    made = ""
    try:
        with _naming(path):
            made = tempfile.mkdtemp(prefix=".fairaudit-", suffix=".part", dir=target.parent)
            for name, content in files.items():
                with (Path(made) / name).open("wb") as file:
                    file.write(content)
                    file.flush()
                    os.fsync(file.fileno())
            if target.is_dir():
                os.chmod(made, stat.S_IMODE(target.stat().st_mode))
                target.rmdir()
            else:
                os.chmod(made, _new(0o777))
            Path(made).rename(target)
            made = ""
    finally:
        if made:
            shutil.rmtree(made, ignore_errors=True)


def _new(rights: int) -> int:
    """The rights of something new."""
    mask = os.umask(0)
    os.umask(mask)
    return rights & ~mask


def _rights(target: Path) -> int:
    """The rights of a file that is there, or those of a new one."""
    try:
        return stat.S_IMODE(target.stat().st_mode) & 0o777
    except FileNotFoundError:
        return _new(0o666)


def _kept(target: Path, temporary: str) -> str:
    """A second name for what a file holds until now, or, where there are none, a copy; empty if there is no such file."""
    if not target.exists():
        return ""
    old = f"{temporary.removesuffix('.part')}-old.part"
    try:
        os.link(target, old)
    except OSError:
        try:
            shutil.copy2(target, old)
        except BaseException:
            with contextlib.suppress(OSError):
                os.unlink(old)
            raise
    return old


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
