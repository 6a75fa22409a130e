"""`twin machine`: its help, and what it says of a file."""

import json
from pathlib import Path

import pytest

from tests.vehicle.wrong_files import IMPLEMENT, MACHINE, WRONG_IMPLEMENTS, other
from twin import cli
from twin.errors import BadInput
from twin.io import run_folder

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


@pytest.mark.parametrize("case", WRONG_IMPLEMENTS)
@pytest.mark.parametrize("action", ["show", "check"])
def test_a_wrong_implement_has_the_message_of_an_implement(own, action, case, capsys):
    text, said = WRONG_IMPLEMENTS[case]
    Path("tool.toml").write_text(text)
    assert cli.main(["machine", action, "tool.toml"]) == 2
    err = capsys.readouterr().err
    assert err.count("\n") == 1
    assert "wheelbase_m" not in err
    for part in said:
        assert part in err, err


def test_a_wrong_machine_has_the_message_of_a_machine(own, capsys):
    for text in (other(MACHINE, mass_kg=""), MACHINE.replace("mass_kg", "bodies = 3\nmass_kg", 1)):
        Path("mine.toml").write_text(text)
        assert cli.main(["machine", "check", "mine.toml"]) == 2
        assert "rows" not in capsys.readouterr().err


def test_show_says_that_a_front_axle_must_be_engaged(own, capsys):
    assert cli.main(["machine", "show", "mine.toml"]) == 0
    assert "note:" not in capsys.readouterr().out
    Path("mine.toml").write_text(MACHINE + '[drive]\ndriven = "all"\n')
    assert cli.main(["machine", "show", "mine.toml"]) == 0
    assert "--drive.all-wheel-drive" in " ".join(capsys.readouterr().out.split())
    assert cli.main(["machine", "show", "mine.toml", "--json"]) == 0
    assert len(json.loads(capsys.readouterr().out)["notes"]) == 1


def test_show_names_a_readme_only_where_there_is_one(own, capsys):
    assert cli.main(["machine", "export", "mine.toml", "mine.xml"]) == 0
    capsys.readouterr()
    for name, told in (("mine.xml", False), ("taishan_1404a", True), ("plough_1lf435", True)):
        assert cli.main(["machine", "show", name, "--json"]) == 0
        numbers = json.loads(capsys.readouterr().out)["numbers"]
        assert {"README.md" in n["source"] for n in numbers.values()} == {told}


@pytest.mark.parametrize(
    ("args", "said"),
    [
        (["run", "plough-20cm", "--machine", "mine"], "did you mean the file mine.toml?"),
        (["run", "plough-20cm", "--machine", "made"], "did you mean the file made.xml?"),
        (["run", "plough-20cm", "--implement", "tool"], "did you mean the file tool.toml?"),
        (["machine", "show", "mine"], "did you mean the file mine.toml?"),
        (["rig", "drawbar", "--machine", "mine"], "did you mean the file mine.toml?"),
        (["rig", "wheel", "--machine", "mine.toml"], "--tyre.machine NAME|FILE"),
        (["study", "plough-20cm", "--course.length-m", "20"], "--sweep course.length_m=20 would"),
        (["study", "plough-20cm", "--soil.friction=0.7"], "--sweep soil.friction=0.7 would"),
        (["study", "plough-20cm", "--plough.bouncy", "1"], "Unrecognized"),
        (["compare", "one"], "twin compare needs two folders, not 1: twin compare DIR DIR"),
        (["compare"], "twin compare needs two folders: twin compare DIR DIR"),
        (["compare", "a", "b", "c", "--out", "d"], "two folders, not 3: twin compare DIR DIR"),
    ],
)
def test_a_near_miss_is_told_in_one_line(own, args, said, capsys):
    Path("made.xml").write_text("<mujoco/>")
    assert cli.main(args) == 2
    err = capsys.readouterr().err
    assert said in err, err
    assert err.count("\n") == 1


@pytest.mark.parametrize(
    ("args", "folder"),
    [
        ([], "plough-20cm-seed0"),
        (["--machine", "mine.toml"], "plough-20cm-mine-seed0"),
        (["--machine=farm/mine.toml", "--seed", "3"], "plough-20cm-mine-seed3"),
        (["--machine", "jd_4250", "--implement", "tool.toml"], "plough-20cm-jd_4250-tool-seed0"),
        (["--implement", "chisel_3m"], "plough-20cm-chisel_3m-seed0"),
        (["--implement", "none", "--machine", "./mine.xml"], "plough-20cm-mine-none-seed0"),
        (["--machine", "mine.toml", "--out", "here"], "here"),
    ],
)
def test_the_folder_of_a_run_has_the_machine_and_implement_that_were_given(
    own, args, folder, monkeypatch
):
    Path("farm").mkdir()
    Path("farm/mine.toml").write_text(MACHINE)
    assert cli.main(["machine", "export", "mine.toml", "mine.xml"]) == 0
    asked = []

    def refuse(directory):
        asked.append(directory.name)
        raise BadInput("far enough")

    monkeypatch.setattr(run_folder, "refuse_foreign", refuse)
    assert cli.main(["run", "plough-20cm", "--plough.depth-m", "0.12", *args]) == 2
    assert asked == [folder]
