"""What commands print with `--format json`, read and checked against the schema that ships with the package."""

from __future__ import annotations

import json
from importlib.resources import files
from typing import Any

from jsonschema import Draft202012Validator
from referencing import Registry, Resource

from fairaudit.certificates.certificate import schema

ENVELOPE = json.loads(files("fairaudit.cli").joinpath("envelope.schema.json").read_text("utf-8"))
PROXIES = json.loads(files("fairaudit.certificates").joinpath("proxies.schema.json").read_text("utf-8"))
SUBGROUPS = json.loads(files("fairaudit.certificates").joinpath("subgroups.schema.json").read_text("utf-8"))
SCHEMA = Draft202012Validator(
    ENVELOPE,
    registry=Registry().with_resources(
        [
            ("fairaudit-certificate/1", Resource.from_contents(schema())),
            ("fairaudit-proxies/1", Resource.from_contents(PROXIES)),
            ("fairaudit-subgroups/1", Resource.from_contents(SUBGROUPS)),
        ]
    ),
)


def envelope(text: str) -> dict[str, Any]:
    """The one envelope that was printed."""
    found: dict[str, Any] = json.loads(text, parse_constant=_no_number)
    SCHEMA.validate(found)
    return found


def envelopes(text: str) -> list[dict[str, Any]]:
    """One envelope for each line."""
    return [envelope(line) for line in text.splitlines()]


def result_of(text: str) -> Any:
    """The result of the one envelope that was printed."""
    return envelope(text)["result"]


def _no_number(name: str) -> None:
    raise ValueError(f"{name} is not JSON")
