"""Settled starts on disk: read again to the bit, made anew where the file is broken."""

import gymnasium
import pytest

from twin.compute import compiled
from twin.env import kept_starts
from twin.env.fleet import Fleet
from twin.env.grounds import GroundShape
from twin.env.kept_starts import kept
from twin.env.starts import settle
from twin.env.torque_fleet import TorqueFleet

SHAPES = (GroundShape(), GroundShape(cross_slope_deg=3.0))


@pytest.fixture
def machine(environments):
    return environments["truth"].episodes.fleet.machine


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setattr(compiled, "folder", lambda file: tmp_path)
    monkeypatch.setattr(compiled, "is_edited", lambda file: False)
    return tmp_path


def fails():
    raise AssertionError("settled anew")


def bits(starts):
    return [
        (
            start.state.tobytes(),
            start.frame.quaternion.tobytes(),
            start.driver.item(),  # between its fields there may be anything
            start.pedal.item(),
            start.along_m,
            start.action,
            start.approach and {n: v.tobytes() for n, v in start.approach.columns.items()},
        )
        for start in starts
    ]


@pytest.mark.parametrize("seen", [False, True])
def test_starts_are_read_again_to_the_bit(machine, folder, seen):
    settled = kept(machine, SHAPES, seen, Fleet, lambda: settle(machine, SHAPES, seen))
    assert bits(kept(machine, SHAPES, seen, Fleet, fails)) == bits(settled)


@pytest.mark.parametrize("broken", [b"", b"\0" * 100, None])
def test_a_broken_file_is_made_anew(machine, folder, broken):
    settled = kept(machine, SHAPES, False, Fleet, lambda: settle(machine, SHAPES, False))
    (file,) = folder.iterdir()
    whole = file.read_bytes()
    flipped = whole[:200] + bytes([whole[200] ^ 1]) + whole[201:]
    file.write_bytes(flipped if broken is None else broken)
    again = kept(machine, SHAPES, False, Fleet, lambda: settle(machine, SHAPES, False))
    assert bits(again) == bits(settled)
    assert bits(kept(machine, SHAPES, False, Fleet, fails)) == bits(settled)


def test_the_key_names_what_starts_depend_on(machine, folder):
    other = gymnasium.make("twin.env:Plough-v0", observation="truth", depth_m=0.2).unwrapped
    asked = [
        (machine, SHAPES, False, Fleet),
        (machine, SHAPES[:1], False, Fleet),
        (machine, SHAPES, True, Fleet),
        (machine, SHAPES, False, TorqueFleet),
        (other.episodes.fleet.machine, SHAPES, False, Fleet),
    ]
    for count, (*what, kind) in enumerate(asked):
        assert kept(*what, kind, list) == []
        assert len([f for f in folder.iterdir() if f.suffix == ".starts"]) >= count + 1
    other.close()


def test_without_a_folder_they_are_settled(machine, monkeypatch):
    monkeypatch.setattr(compiled, "folder", lambda file: None)
    assert kept(machine, SHAPES, False, Fleet, list) == []
    monkeypatch.setattr(kept_starts, "_read", lambda path: pytest.fail("read"))
    assert kept(machine, SHAPES, False, Fleet, list) == []
