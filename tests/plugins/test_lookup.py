"""Errors of a user's code in one line."""

from twin.plugins.lookup import line


def test_an_error_is_one_line_without_colours():
    assert line(ValueError("\x1b[1mno \x1b[31mslip\x1b[0m\nmore")) == "ValueError: no slip"
    assert line(KeyError()) == "KeyError"
