"""Work: counted before it is done, so that a short document cannot keep its reader busy for long."""

from __future__ import annotations

from contextvars import ContextVar

from .text import TooMuch

MAX_STEPS = 50_000_000  # of a document with its table, which take seconds; a step is an operation on numbers of at most 256 bits
MAX_BLOCKS = 8_000_000  # that are kept, in less than a gigabyte; a block is a number of at most 256 bits
FREE_BYTES = 1_000_000  # of the document and its table; each further byte adds to the steps and blocks
STEPS_PER_BYTE = 250
BLOCKS_PER_BYTE = 8


class Work:
    """What is left of the steps and blocks of a document, and the part of it that is being checked."""

    def __init__(self, steps: int = MAX_STEPS, blocks: int = MAX_BLOCKS) -> None:
        self.steps, self.blocks, self.bytes = steps, blocks, 0
        self.part = "the certificate"

    def grant(self, count: int) -> None:
        """Take note of bytes that were read."""
        before, self.bytes = self.bytes, self.bytes + count
        beyond = max(0, self.bytes - FREE_BYTES) - max(0, before - FREE_BYTES)
        self.steps += STEPS_PER_BYTE * beyond
        self.blocks += BLOCKS_PER_BYTE * beyond

    def refusal(self, limit: str) -> TooMuch:
        """Say which limit was hit, and where."""
        size = "1 MB" if self.bytes <= FREE_BYTES else f"{self.bytes} bytes"
        return TooMuch(f"{self.part} takes more than {limit} of a document of {size}")


CURRENT_WORK: ContextVar[Work | None] = ContextVar("CURRENT_WORK", default=None)


def spend(times: int, left: int = 0, right: int = 0) -> None:
    """Count operations that are about to be made on numbers of so many bits: products, quotients, greatest common divisors."""
    work = CURRENT_WORK.get()
    if work is not None:
        work.steps -= times * (1 + (left >> 8)) * (1 + (right >> 8))
        if work.steps < 0:
            raise work.refusal("the steps")


def keep(count: int, bits: int = 0) -> None:
    """Count numbers of so many bits that are about to be kept."""
    work = CURRENT_WORK.get()
    if work is not None:
        work.blocks -= count * (1 + (bits >> 8))
        if work.blocks < 0:
            raise work.refusal("the memory")


def working_on(part: str) -> None:
    """Name the part of the document that is checked next, for what is said if it takes too much work."""
    work = CURRENT_WORK.get()
    if work is not None:
        work.part = part


def grant_bytes(count: int) -> None:
    """Take note of bytes of the document or its table that were read."""
    work = CURRENT_WORK.get()
    if work is not None:
        work.grant(count)
