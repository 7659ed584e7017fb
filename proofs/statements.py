"""Print what has to be read of the proofs: every theorem as it is stated, every definition and what stands around them.

Left out are comments, proofs, lemmas (steps of proofs) and tactics.  Each sentence of Coq is one line, spaces made alike, so that
only a change of meaning changes a line.  `make` compares the lines with statements.golden, `make golden` accepts them.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from pathlib import Path

HERE = Path(__file__).parent
STEPS = ("Lemma", "Fact", "Remark", "Ltac")
PROVED = (*STEPS[:3], "Theorem", "Corollary", "Proposition", "Example")
PART = re.compile(r'\(\*|\*\)|"[^"]*"|(?P<stop>(?<!\.)\.(?=\s|$))|.', re.DOTALL)


def sentences(text: str) -> Iterator[str]:
    """List the sentences of a Coq file, each without the full stop that ends it, comments and doubled spaces."""
    depth, sentence = 0, ""
    for match in PART.finditer(text):
        part = match[0]
        depth += (part == "(*") - (part == "*)")
        if depth or part == "*)":
            continue
        if match["stop"]:
            yield " ".join(sentence.split())
            sentence = ""
        else:
            sentence += part
    if depth or sentence.strip():
        raise ValueError(f"the file ends within a comment or sentence: {sentence.strip()[:80]!r}")


def stated(text: str) -> Iterator[str]:
    """List the sentences of a Coq file without proofs and their steps; a proof that is itself used (Defined) is kept."""
    told = ""
    proof: list[str] | None = None
    for sentence in sentences(text):
        word = sentence.split(maxsplit=1)[0]
        if proof is not None:
            proof.append(sentence)
            if word in (*PROVED, "Definition", "Section", "End"):
                raise ValueError(f"a proof has to end with Qed: {told}")
            if end := re.search(r"\b(Qed|Defined|Abort)$", sentence):
                if end[1] == "Defined":
                    yield from (told, *proof) if told.startswith(STEPS) else proof
                proof = None
                told = ""
        elif re.fullmatch("Proof( using.*| with.*)?", sentence):
            proof = [sentence]
        elif re.search(r"\b(Qed|Defined|Abort)$", sentence) or told.startswith(PROVED):
            raise ValueError(f"a proof has to begin with Proof: {told or sentence}")
        else:
            told = sentence
            if word not in STEPS:
                yield sentence
    if proof is not None:
        raise ValueError(f"a proof has to end with Qed: {told}")


def golden() -> Iterator[str]:
    """List the lines of statements.golden."""
    for path in sorted(HERE.glob("*/*.v")):
        if path.parent.name != "build":
            yield f"==== {path.relative_to(HERE).as_posix()}"
            yield from (f"{sentence}." for sentence in stated(path.read_text("utf-8")))


if __name__ == "__main__":
    sys.stdout.buffer.write("".join(f"{line}\n" for line in golden()).encode())
