"""What is compressed is read as what is inside, and whatever is wrong with it is a sentence that names the file."""

from __future__ import annotations

import bz2
import gzip
import json
import lzma
import random
from collections import Counter
from pathlib import Path

import pytest

import fairaudit as fa
from fairaudit.errors import InputError

ROWS = [{"custom_id": f"r{i}", "error": None, "response": {"status_code": 200, "body": {"model": "m", "choices": [
    {"message": {"content": "yes" if i % 3 else "no"}}]}}} for i in range(400)]  # fmt: skip
ANSWER = "response.body.choices[0].message.content"
CELLS = "\n".join(["answer", *("yes" if i % 3 else "no" for i in range(400))])


@pytest.mark.parametrize("pack", [gzip.compress, bz2.compress, lzma.compress])
@pytest.mark.parametrize("text", ["\n".join(map(json.dumps, ROWS)), CELLS])
def test_damaged_ones_are_refused(tmp_path: Path, pack: object, text: str) -> None:
    """Bytes changed and ends cut at random; where a check sum does not see it, nothing else is counted."""
    assert callable(pack)
    path, decision = tmp_path / "log", ANSWER if text.startswith("{") else "answer"
    whole, draw = pack(text.encode()), random.Random(len(text))
    refused = 0
    for trial in range(60):
        held = bytearray(whole)
        for _ in range(draw.randint(0 if trial % 9 else 1, 3) if trial else 0):
            held[draw.randrange(4, len(held))] = draw.randrange(256)
        path.write_bytes(bytes(held[: draw.randrange(6, len(held))]) if trial % 9 == 1 else bytes(held))
        try:
            tally = fa.read_log(path, [decision])
        except InputError as error:
            refused += 1
            assert "log" in str(error), trial
        else:
            assert Counter(dict(zip(tally[decision], tally.counts.tolist(), strict=True))) == {"yes": 266, "no": 134}
    assert 30 <= refused < 60
