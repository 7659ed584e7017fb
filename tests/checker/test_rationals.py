"""Rationals as they are read."""

from plain_certificates import checker


def test_long_numbers_are_read() -> None:
    digits = "9" * 99_999 + "7"
    number, one = checker.rationals.read_rational(digits, "here")
    assert number == 10**100_000 - 3 and one == 1
    assert checker.rationals.read_rational(f"-2/{digits}", "here") == (-2, number)
