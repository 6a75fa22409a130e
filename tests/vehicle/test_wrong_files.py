"""A wrong file is refused in one line: the field, the value, what would do."""

import dataclasses
import types
import typing
from pathlib import Path

import pytest

from tests.vehicle.wrong_files import IMPLEMENT, MACHINE, cases, other
from twin import cli
from twin.vehicle import Implement, Machine, files
from twin.vehicle.reading import FORMS

CASES = cases()


def test_there_are_at_least_fifty():
    assert len(CASES) >= 50


@pytest.mark.parametrize("case", CASES)
def test_a_wrong_file_is_refused_in_one_line(case, tmp_path: Path, monkeypatch, capsys):
    kind, text, said = CASES[case]
    monkeypatch.chdir(tmp_path)
    Path("wrong.toml").write_text(text)
    status = cli.main(["run", "plough-20cm", f"--{kind}", "wrong.toml", "--plough.depth-m", "0.1"])
    out, err = capsys.readouterr()
    assert status == 2
    assert out == ""
    assert err.startswith("twin: ")
    assert err.count("\n") == 1, err
    for part in said:
        assert part in err, err
    assert [p.name for p in tmp_path.iterdir()] == ["wrong.toml"], "something was left behind"


def test_the_files_they_are_made_from_are_right(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("right.toml").write_text(MACHINE)
    assert files.machine("right.toml").name == "mine"
    Path("tool.toml").write_text(IMPLEMENT)
    assert files.implement("tool.toml").bodies == 11


def test_check_says_every_inconsistency_and_has_a_status(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    text = MACHINE.replace("rated_rpm = 2200", "rated_rpm = 2200\nmax_power_kw = 60")
    text = text.replace("mass_kg", "front_axle_kg = 1700\nrear_axle_kg = 2900\nmass_kg", 1)
    Path("odd.toml").write_text(text + '[drive]\ndriven = "all"\nfront_lead = 0.1\n')
    assert cli.main(["machine", "check", "odd.toml"]) == 1
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 3
    assert {line.split(" ")[0] for line in lines} == {
        "front_axle_kg", "engine.max_power_kw", "drive.front_lead",
    }  # fmt: skip
    assert "odd, but can be driven" in lines[-1]


@pytest.mark.parametrize("name", files.machine_names())
def test_the_catalogue_is_consistent(name, capsys):
    assert cli.main(["machine", "check", name]) == 0
    assert "nothing is inconsistent" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("text", "paths"),
    [
        (other(MACHINE, rear__tyre='"900/60R42"'), ["rear.tyre", "wheelbase_m"]),
        (other(MACHINE, rear__tyre='"900/60R42"', mass_kg="9800", wheelbase_m="2.9"), []),
        (other(MACHINE, rear__tyre='"600/65R38"'), []),
        (other(MACHINE, rear__duals="true"), []),
        (other(MACHINE, engine__max_power_kw="92"), []),
        (other(MACHINE, engine__max_power_kw="150", engine__kind='"electric"'), []),
        (MACHINE.replace("mass_kg", 'implement = "ploughx"\nmass_kg', 1), ["implement"]),
        (MACHINE.replace("mass_kg", 'implement = "away.toml"\nmass_kg', 1), ["implement"]),
        (MACHINE.replace("mass_kg", 'implement = "tool.toml"\nmass_kg', 1), []),
        (MACHINE.replace("mass_kg", 'implement = "none"\nmass_kg', 1), []),
    ],
)
def test_check_tells_what_does_not_go_together(text, paths, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    Path("farm").mkdir()
    Path("farm/tool.toml").write_text(IMPLEMENT)
    Path("farm/mine.toml").write_text(text)
    assert cli.main(["machine", "check", "farm/mine.toml"]) == bool(paths)
    out = capsys.readouterr().out
    assert [line.split(" ")[0] for line in out.splitlines()] == (paths or ["mine:"])


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "latin-1", "cp1252", "utf-16"])
def test_a_file_is_utf8_with_or_without_its_mark(encoding, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    text = MACHINE.replace("schema = 1", 'about = "Schlüter, grün"')
    Path("mine.toml").write_bytes(text.encode(encoding))
    status = cli.main(["machine", "check", "mine.toml"])
    err = capsys.readouterr().err
    assert status == (0 if "utf-8" in encoding else 2), err
    if status:
        assert err.startswith("twin: mine.toml is no UTF-8 text: byte 0x")
        assert "in line 1; save it as UTF-8" in err


def test_no_field_of_a_list_is_without_its_form():
    for kind in (Machine, Implement):
        for table, name, hint in lists(kind):
            assert name in FORMS, (table, name, hint)


def lists(kind):
    """Fields whose value is a list of numbers, of a dataclass and of its tables."""
    for name, hint in typing.get_type_hints(kind).items():
        for each in typing.get_args(hint) if isinstance(hint, types.UnionType) else (hint,):
            if dataclasses.is_dataclass(each):
                yield from lists(each)
            elif typing.get_origin(each) is tuple and not dataclasses.is_dataclass(
                typing.get_args(each)[0]
            ):
                yield kind.__name__, name, each
