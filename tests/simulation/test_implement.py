"""A plough with other numbers than the one that is shipped, from its own file."""

import shutil
from pathlib import Path

import numpy as np
import pytest
from twin.machine.files import model_path

from tests.simulation.rigs import EVEN_PLOUGHING, driven, replace
from twin.errors import BadInput, OutOfRange
from twin.machine.plough_setting import expected_draft_n
from twin.scenario import Course, Plough
from twin.simulation.build import build
from twin.simulation.simulate import simulate

SHORT = replace(
    EVEN_PLOUGHING, plough=Plough(depth_m=0.15), course=Course(approach_m=3.0, length_m=12.0)
)


def changed(tmp_path: Path, monkeypatch, bodies: float, sites: int, width_m: float = 0.35):
    """The shipped models with another plough, which the loader then finds."""
    models = tmp_path / "models"
    shutil.copytree(model_path("taishan_1404a").parent.parent, models)
    file = models / "plough_1lf435" / "plough_1lf435.xml"
    text = file.read_text()
    text = text.replace('"bodies" data="4"', f'"bodies" data="{bodies:g}"')
    text = text.replace('"body_width_m" data="0.35"', f'"body_width_m" data="{width_m:g}"')
    places = text.index('      <frame name="aside.1"'), text.index('      <site name="depth_laser"')
    own = [
        f'<site name="share_{i + 1}" pos="{-0.65 - 0.85 * i:g} '
        f'{(0.5 * (sites - 1) - i) * width_m:g} -0.78"/>'
        for i in range(sites)
    ]
    file.write_text(text[: places[0]] + "\n".join(own) + text[places[1] :])
    monkeypatch.setattr("twin.machine.build.model_path", lambda name: models / name / f"{name}.xml")


def test_the_file_as_it_is_changes_nothing(tmp_path, monkeypatch):
    shipped = driven(SHORT)["draft_n"]
    changed(tmp_path, monkeypatch, 4, 4)
    chunks = list(simulate(build(SHORT)))
    assert np.array_equal(np.concatenate([c["draft_n"] for c in chunks]), shipped)


@pytest.mark.parametrize(("bodies", "width_m"), [(2, 0.35), (3, 0.45), (5, 0.30), (6, 0.30)])
def test_another_plough_pulls_by_its_own_bodies_and_width(tmp_path, monkeypatch, bodies, width_m):
    changed(tmp_path, monkeypatch, bodies, bodies, width_m)
    machine = build(SHORT)
    chunks = list(simulate(machine))
    assert chunks[-1].end.as_planned
    late = slice(-1000, None)
    draft, depth, speed = (
        np.concatenate([c[n] for c in chunks])[late] for n in ("draft_n", "depth_m", "velocity_w")
    )
    specific = 652.0 + 5.1 * (3.6 * speed[:, 0]) ** 2
    scale = SHORT.soil.resolved.draft_scale
    wanted = scale * specific * bodies * width_m * 100.0 * depth
    assert draft.mean() == pytest.approx(wanted.mean(), rel=0.02)
    assert expected_draft_n(machine.numbers, 0.15, scale) == pytest.approx(
        scale * (652.0 + 5.1 * 5.5**2) * bodies * width_m * 15.0
    )


@pytest.mark.parametrize("bodies", [7, 12, 0, 2.5])
def test_more_bodies_than_fit_are_refused_by_name(tmp_path, monkeypatch, bodies):
    changed(tmp_path, monkeypatch, bodies, int(bodies))
    with pytest.raises(OutOfRange, match=rf"plough\.bodies = {bodies:g} .*1 to 6"):
        build(SHORT, settle=False)


@pytest.mark.parametrize("sites", [3, 5])
def test_a_body_without_its_share_in_the_model_is_refused(tmp_path, monkeypatch, sites):
    changed(tmp_path, monkeypatch, 4, sites)
    with pytest.raises(BadInput, match=rf"plough\.bodies = 4, but the model has {sites} sites"):
        build(SHORT, settle=False)
