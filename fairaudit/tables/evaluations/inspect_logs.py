"""Logs of Inspect: ``.eval``, an archive with a member for each sample, and ``.json``."""

from __future__ import annotations

import re
import struct
import sys
import zipfile
import zlib
from collections.abc import Collection, Iterable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from fairaudit.errors import InputError, shown
from fairaudit.tables.evaluations.json_text import Document, document, leading, opened, part, text
from fairaudit.tables.evaluations.samples import Format, Outcome, Run, Sample, ended, fixed

__all__ = ["INSPECT", "is_archive", "is_zip"]

HEADER, START = "header.json", "_journal/start.json"

NAMED = 30
"""Where in an archive the name of its first member stands; a log of Inspect begins with that of its start."""

MEMBER = re.compile(r"samples/(?:(?P<folder>.+_epoch_[0-9]+)/sample|.+_epoch_[0-9]+)\.json", re.DOTALL)

ENCRYPTED = 1

STORED, DEFLATED, ZSTD = 0, 8, 93

LONG = ("events", "events_data", "timelines", "attachments", "store")
"""What makes up most of a sample; left out unless a path goes into it."""

ABOVE = ("status", "eval", "plan")

DECIDING = ("id", "epoch", "error", "invalidation", "output", "limit")

ATTACHMENT = "attachment://"


def is_archive(path: str) -> bool:
    """Say whether an archive is a log of Inspect; one that was cut off is known by what it begins with."""
    try:
        with zipfile.ZipFile(path) as archive:
            return not {HEADER, START}.isdisjoint(archive.namelist())
    except (zipfile.BadZipFile, OSError, ValueError, NotImplementedError):
        with opened(path) as file:
            return file.read(NAMED + len(START))[NAMED:] == START.encode()


def _run(path: str) -> Run:
    header = _header(path)
    asked = part(header, "eval")
    epochs = part(asked, "config").get("epochs")
    epochs = epochs if isinstance(epochs, int) and epochs > 0 else 1
    ids = part(asked, "dataset").get("sample_ids")
    version = part(asked, "packages").get("inspect_ai")
    return Run(
        format=INSPECT.name,
        producer=f"inspect_ai {version}" if isinstance(version, str) else "inspect_ai",
        model=text(asked, "model"),
        task=text(asked, "task"),
        status=text(header, "status"),
        expected=len(ids) * epochs if isinstance(ids, list) else None,
        epochs=epochs,
        fixed=fixed(_settings(asked, part(header, "plan"))),
    )


def _settings(asked: Mapping[str, Any], plan: Mapping[str, Any]) -> Mapping[str, Any]:
    """Settings of the model, over which go those of the run, and over these those of the last step that asks it."""
    settings = {**part(asked, "model_generate_config"), **part(plan, "config")}
    steps = plan.get("steps")
    for step in steps if isinstance(steps, list) else ():
        if isinstance(step, dict) and step.get("solver") == "generate":
            settings.update(part(step, "params"))
    return settings


def _samples(path: str, wanted: Collection[str]) -> Iterator[Sample]:
    asked = part(_header(path), "eval")
    for sample in (_members if is_zip(path) else _elements)(path, wanted):
        outcome = _outcome(sample)
        yield Sample({**sample, "eval": asked}, outcome, "sample {}, epoch {}", (sample.get("id"), sample.get("epoch")))


def _members(path: str, wanted: Collection[str]) -> Iterator[dict[str, Any]]:
    """Read the samples of an archive: each a member, or a folder with the long parts in members of their own."""
    with _archive(path) as archive:
        for member in archive.infolist():
            named = MEMBER.fullmatch(member.filename)
            if named is None:
                continue
            with _opened(path, archive, member) as read:
                sample = _sample(read, wanted)
                read.end()
            metadata = f"samples/{named['folder']}/metadata.json"
            if named["folder"] and metadata in archive.NameToInfo and (not wanted or "metadata" in wanted):
                with _opened(path, archive, archive.getinfo(metadata)) as read:
                    sample["metadata"] = read.value()
            if not {"id", "epoch"} <= sample.keys():
                raise InputError(f"{path}: the member {shown(member.filename)} is no sample; it has no id or no epoch")
            yield sample


def _elements(path: str, wanted: Collection[str]) -> Iterator[dict[str, Any]]:
    """Read the samples of a document of JSON."""
    with document(path) as read:
        for key in read.members():
            if key == "samples" and read.peek() == "[":
                for number in read.elements():
                    sample = _sample(read, wanted)
                    if not {"id", "epoch"} <= sample.keys():
                        raise InputError(f"{path}: sample {number + 1} has no id or no epoch")
                    yield sample
            else:
                read.skip()
        read.end()


def _sample(read: Document, wanted: Collection[str]) -> dict[str, Any]:
    """Take a sample, without what is long and not asked for."""
    sample: dict[str, Any] = {}
    whole = read.whole() if read.peek() == "{" else None
    if whole is not None:
        sample = {key: value for key, value in whole.items() if _kept(key, wanted)}
        apart = part(whole, "attachments")
        return _with_texts(sample, apart.items()) if apart else sample
    for key in read.members():
        if key == "attachments" and key not in wanted:
            sample = _with_texts(sample, _pairs(read))
        elif _kept(key, wanted):
            sample[key] = read.value()
        else:
            read.skip()
    return sample


def _kept(key: str, wanted: Collection[str]) -> bool:
    return key in wanted or key in DECIDING or not (wanted or key in LONG)


def _with_texts(sample: dict[str, Any], attachments: Iterable[tuple[str, Any]]) -> dict[str, Any]:
    """Put texts that stand apart where they are referred to."""
    referred = set(_referred(sample))
    texts = {name: text for name, text in attachments if name in referred}
    return {name: _resolved(value, texts) for name, value in sample.items()} if texts else sample


def _pairs(read: Document) -> Iterator[tuple[str, Any]]:
    for name in read.members():
        yield name, read.value()


def _referred(value: Any) -> Iterator[str]:
    """Names of the texts that stand apart, among the attachments."""
    if isinstance(value, str):
        if value.startswith(ATTACHMENT):
            yield value.removeprefix(ATTACHMENT)
    elif isinstance(value, (dict, list)):
        for part in value.values() if isinstance(value, dict) else value:
            yield from _referred(part)


def _resolved(value: Any, texts: Mapping[str, Any]) -> Any:
    if isinstance(value, dict):
        return {name: _resolved(part, texts) for name, part in value.items()}
    if isinstance(value, list):
        return [_resolved(part, texts) for part in value]
    return texts.get(value.removeprefix(ATTACHMENT), value) if isinstance(value, str) and value.startswith(ATTACHMENT) else value


def _outcome(sample: Mapping[str, Any]) -> Outcome:
    if sample.get("error") is not None or sample.get("invalidation") is not None:
        return "error"
    output = part(sample, "output")
    outcome = ended((leading(output.get("choices")) or output).get("stop_reason"))
    return "truncated" if outcome == "read" and sample.get("limit") is not None else outcome


def _header(path: str) -> Mapping[str, Any]:
    """Read what stands above the samples; a run that was killed has only what it began with."""
    header: dict[str, Any] = {}
    if is_zip(path):
        with _archive(path) as archive:
            name = next((name for name in (HEADER, START) if name in archive.NameToInfo), None)
            if name is None:
                raise InputError(f"{path}: the archive has neither {HEADER} nor {START}, so it is no log of Inspect")
            with _opened(path, archive, archive.getinfo(name)) as read:
                header = {key: value for key, value in _pairs(read) if key in ABOVE}
            header.setdefault("status", "started")
    else:
        with document(path) as read:
            for key in read.members():
                if key in ABOVE:
                    header[key] = read.value()
                else:
                    read.skip()
                if len(header) == len(ABOVE):
                    break
    if not isinstance(header.get("eval"), dict):
        raise InputError(f'{path}: there is no "eval" in the header, so it is no log of Inspect')
    return header


def is_zip(path: str) -> bool:
    """Say whether a file begins as an archive does."""
    with opened(path) as file:
        return file.read(4) == b"PK\x03\x04"


@contextmanager
def _archive(path: str) -> Iterator[zipfile.ZipFile]:
    with _said(f"{path}: the archive cannot be read"), _library().ZipFile(path) as archive:
        yield archive


@contextmanager
def _opened(path: str, archive: zipfile.ZipFile, member: zipfile.ZipInfo) -> Iterator[Document]:
    place = f"{path}, member {shown(member.filename)}"
    if member.flag_bits & ENCRYPTED:
        raise InputError(f"{place}: the member is encrypted")
    if member.compress_type not in (STORED, DEFLATED, ZSTD):
        raise InputError(f"{place}: the member is compressed by method {member.compress_type}; zstd, deflate and none are read")
    if member.compress_type == ZSTD and not hasattr(_library(), "ZIP_ZSTANDARD"):
        convert = "inspect log convert --to json --output-dir DIR"
        raise InputError(f"{path} needs zstd: pip install 'fairaudit-certify[evals]', or write the log anew by: {convert}")
    with _said(f"{place}: the member cannot be read"), archive.open(member) as file:
        yield Document(place, file.read)


@contextmanager
def _said(what: str) -> Iterator[None]:
    """Say in one sentence what reading an archive fails with."""
    try:
        yield
    except (zipfile.BadZipFile, _library().BadZipFile, zlib.error, EOFError, struct.error, *_damaged_by_zstd()) as error:
        raise InputError(f"{what}: it was cut or damaged ({str(error) or type(error).__name__})") from None
    except (OSError, NotImplementedError, OverflowError) as error:
        raise InputError(f"{what}: {getattr(error, 'strerror', None) or error}") from None


def _library() -> Any:
    """Give a module that reads members compressed by zstd, or else the one that does not."""
    try:
        from backports.zstd import zipfile as with_zstd
    except ImportError:
        return zipfile
    return with_zstd


def _damaged_by_zstd() -> list[type[Exception]]:
    return [library.ZstdError for name in ("backports.zstd", "compression.zstd") if (library := sys.modules.get(name)) is not None]


INSPECT = Format(
    "inspect",
    _run,
    _samples,
    key=("id", "epoch"),
    question="id",
    repetition="epoch",
    answers=("scores.*.answer", "scores.*.value"),
    parts=("id", "epoch", "metadata", "scores.*.answer", "scores.*.value", "eval.model", "eval.task"),
)
