"""The strategies that users draw laws and utilities from: what they promise of what they draw."""

from __future__ import annotations

from hypothesis import find, given
from hypothesis import strategies as st

from fairaudit.exact.rationals import rational
from fairaudit.model.law import Law
from fairaudit.testing import laws, utilities, weights


@given(weights())
def test_weights_are_numbers_that_no_audit_refuses(value: object) -> None:
    top, bottom = rational(value)
    assert top >= 0 and bottom > 0


@given(laws(max_contexts=2, max_groups=3, max_decisions=2))
def test_laws_keep_their_greatest_sizes(law: Law) -> None:
    assert len(law.contexts) <= 2 and 2 <= len(law.groups) <= 3 and len(law.decisions) <= 2


def test_laws_have_absent_cells_unless_they_are_complete() -> None:
    find(laws(), lambda law: len(law.cell_context) < len(law.contexts) * len(law.groups))


@given(laws(complete=True))
def test_complete_laws_have_every_cell(law: Law) -> None:
    assert len(law.cell_context) == len(law.contexts) * len(law.groups)


@given(st.data())
def test_utilities_fit_their_law(data: st.DataObject) -> None:
    law = data.draw(laws(max_contexts=2, max_groups=2, max_decisions=3))
    assert data.draw(utilities(law)).on(law) is not None
