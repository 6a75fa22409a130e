"""`twin machine`: its help, and what it says of a file."""

from pathlib import Path

import pytest

from tests.vehicle.wrong_files import IMPLEMENT, MACHINE
from twin import cli

HELPED = {"show": "NAME|FILE", "check": "FILE", "export": "NAME|FILE OUT.xml"}


@pytest.fixture
def own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    Path("mine.toml").write_text(MACHINE)
    Path("tool.toml").write_text(IMPLEMENT)
    return tmp_path


@pytest.mark.parametrize("given", [[], ["a"], ["a", "b"], ["a", "b", "--implement", "c"]])
@pytest.mark.parametrize("action", HELPED)
@pytest.mark.parametrize("asked", ["-h", "--help"])
def test_help_names_the_files_wherever_it_is_asked_for(action, given, asked, capsys):
    assert cli.main(["machine", action, *given, asked]) == 0
    assert f"twin machine {action} {HELPED[action]} [" in capsys.readouterr().out
