"""Ctrl-C ends every command that takes its time."""

from pathlib import Path

from tests.test_output import INTERRUPTED, ends_at_ctrl_c


def test_ctrl_c_ends_every_command_with_a_line_and_leaves_nothing(tmp_path: Path) -> None:
    ends_at_ctrl_c(INTERRUPTED, tmp_path)
