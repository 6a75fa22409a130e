"""The rows of the committed page are those the code produces, in the same order."""

from tests.validate.test_page import PAGE, rows_of
from twin.validate import page, suite


def test_the_committed_pages_rows_are_those_the_code_produces():
    """The figures may differ."""
    made = page.text(suite.checks(quick=True))
    assert rows_of(made) == rows_of(PAGE.read_text(encoding="utf-8"))
