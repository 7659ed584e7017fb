"""What is written is what the name of a file ends in, or nothing is written."""

from __future__ import annotations

import pytest

from fairaudit.errors import InputError
from fairaudit.reports.endings import ENDINGS, form_of


@pytest.mark.parametrize("name", ["page", "page.txt", "page.json.gz", ".json", "page.pdf ", "a/b.docx", "page.", "html"])
def test_other_endings_are_refused_with_those_that_are_accepted(name: str) -> None:
    with pytest.raises(InputError, match="which does not say what to write") as caught:
        form_of(name)
    assert all(ending in str(caught.value) for ending in (".json", ".html", ".pdf", ".md", ".svg", ".png"))


def test_case_does_not_matter() -> None:
    assert {form_of(f"a{ending.upper()}") for ending in ENDINGS} == {"json", "html", "pdf", "markdown", "picture"}
