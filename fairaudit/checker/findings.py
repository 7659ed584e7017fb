"""What is found of each statement, and of the certificate."""

from __future__ import annotations

from dataclasses import dataclass

from .text import printable, shown


@dataclass(frozen=True)
class Finding:
    """One statement of a certificate, and whether it is true."""

    statement: str
    true: bool
    detail: str


@dataclass(frozen=True)
class Report:
    """What was found out about every statement, and the verdict that the certificate states."""

    findings: tuple[Finding, ...]
    verdict: str

    @property
    def ok(self) -> bool:
        """Whether every statement is true."""
        return all(finding.true for finding in self.findings)


def finding_of(statement: str, true: bool, detail: str = "") -> Finding:
    return Finding(printable(statement), true, printable(detail))


def compared(name: str, stated: object, actual: object) -> Finding:
    true = stated == actual
    return finding_of(f"{name} is {shown(stated)}", true, "" if true else f"the table gives {shown(actual)}")
