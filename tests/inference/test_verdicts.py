"""What an interval says of a target."""

from __future__ import annotations

from math import inf

from interval_oracle import (
    F,
    binary,
    one_block,
)

from fairaudit.inference.ratio_intervals import ratio_interval
from fairaudit.inference.verdicts import verdict


def test_verdicts() -> None:
    assert verdict((F(1), inf), max_log=100) == "inconclusive"
    assert verdict((F(1), F(1)), max_log=0) == "within"
    assert verdict((F(3, 2), inf), max_log="0.4") == "exceeds"
    assert verdict((F(5, 4), F(2)), max_ratio="5/4") == "inconclusive"
    # Where the ends cross both would follow, and neither does; limits on one side of both are decided.
    assert verdict((F(4, 3), F(6, 5)), max_ratio="5/4") == verdict((F(4, 3), F(6, 5)), max_log="0.2") == "inconclusive"
    assert verdict((F(4, 3), F(6, 5)), max_ratio="1.1") == "exceeds" and verdict((F(4, 3), F(6, 5)), max_ratio="1.4") == "within"
    assert verdict(ratio_interval(one_block(binary(1, 1), binary(1, 1))), max_ratio="5/4") == "inconclusive"
