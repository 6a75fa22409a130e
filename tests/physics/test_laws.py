"""The choice among the laws, a user's own one in a file, and where the laws hold."""

import math
import re
import sys
from pathlib import Path

import numpy as np
import pytest

from tests.physics.arcs import SOILS, rigid_wheel, sinking
from tests.physics.blocks import soil, wheel
from twin.errors import BadInput, OutOfRange, UnknownName
from twin.machine.parameters import soil_part
from twin.physics.bekker import bekker
from twin.physics.block import Soil, Wheel
from twin.physics.brixius import brixius
from twin.physics.laws import law_number, soil_forces
from twin.physics.validity import outside_validity
from twin.rig.tyre import Tyre
from twin.rig.wheel import wheel as rig_wheel
from twin.scenario import Soil as Ground
from twin.scenario.soils import MEASURED, PRESETS

GUIDE = Path(__file__).parents[2] / "docs" / "writing-a-soil-law.md"
POINTS = [(21.7e3, s, a) for s in (-0.3, 0.0, 0.1, 0.6) for a in (-0.2, 0.0)]
TINY = """
def pushes(soil, wheel, load_n, slip, side_slip):
    return {gain} * load_n * slip, load_n * side_slip, 1.0, 2.0, soil[1]
"""


@pytest.fixture
def module(tmp_path, monkeypatch):
    """Writes a module where the user stands; its name, not imported yet."""
    monkeypatch.chdir(tmp_path)
    written = []

    def write(name, text):
        (tmp_path / f"{name}.py").write_text(text)
        sys.modules.pop(name, None)
        written.append(name)
        return name

    yield write
    for name in written:
        sys.modules.pop(name, None)
    sys.path[:] = [p for p in sys.path if p != str(tmp_path)]


@pytest.mark.parametrize(("number", "law"), [(0.0, brixius), (1.0, bekker)])
def test_the_number_in_the_block_chooses_the_law(number, law):
    assert law_number(law.__name__) == number
    ground = sinking(*SOILS["C"], law=number, cone_index_kpa=1000.0, slip_rate=7.5)
    ground[Soil.MOBILITY_RESISTANCE] = 1.0
    for load, slip, side in POINTS:
        chosen = soil_forces(ground, wheel(), load, slip, side)
        assert chosen == law(ground, wheel(), load, slip, side)


def test_the_guides_law_is_a_file_of_twenty_lines_and_runs(module):
    """Wismer & Luth 1974 by hand: Cn = 1000 0.467 1.755 / 21.7."""
    text = re.search(r"```python\n(.*?)```", GUIDE.read_text(), re.DOTALL)[1]
    assert len(text.splitlines()) <= 25
    ground = soil(law=law_number(module("wismer_luth", text) + ":wismer_luth"))
    cn = 1000.0 * 0.467 * 1.755 / 21.7
    x, y, resistance, rolling, _ = soil_forces(ground, wheel(), 21.7e3, 0.15, 0.0)
    assert x / 21.7e3 == pytest.approx(0.75 * (1.0 - math.exp(-0.3 * cn * 0.15)))
    assert resistance / 21.7e3 == pytest.approx(1.2 / cn + 0.04)
    assert (y, rolling) == (0.0, 0.0)
    assert soil_forces(ground, wheel(), 21.7e3, 0.0, 0.0)[:2] == (0.0, 0.0)


def test_a_law_that_writes_to_the_models_soil_is_refused(module):
    text = TINY.format(gain=1.0).replace("    return", "    soil[1] = 0.0\n    return")
    with pytest.raises(BadInput, match=r"'writes:pushes' cannot be.*writes to the soil.*copy\(\)"):
        law_number(module("writes", text) + ":pushes")


def test_a_users_law_runs_inside_the_step(module):
    """On the wheel stand, through MuJoCo's callback: Wismer & Luth's net traction again."""
    text = re.search(r"```python\n(.*?)```", GUIDE.read_text(), re.DOTALL)[1]
    spec = module("wismer_luth", text) + ":wismer_luth"
    curve = rig_wheel(Tyre(), Ground(law=spec, cone_index_kpa=1000.0), slip=0.15, load_n=21.7e3)
    cn = 1000.0 * 0.467 * 1.755 / 21.7
    gross = 0.75 * (1.0 - math.exp(-0.3 * cn * 0.15))
    assert curve.net_pull_n[0] / 21.7e3 == pytest.approx(gross - 1.2 / cn - 0.04, rel=1e-3)


def test_several_laws_act_in_one_process(module):
    one = law_number(module("one_law", TINY.format(gain=1.0)) + ":pushes")
    two = law_number(module("two_law", TINY.format(gain=2.0)) + ":pushes")
    assert len({0.0, 1.0, one, two}) == 4
    for number, gain in ((one, 1.0), (two, 2.0), (one, 1.0)):
        expected = (gain * 1e3 * 0.1, 1e3 * -0.2, 1.0, 2.0, 0.88)
        assert soil_forces(soil(law=number), wheel(), 1e3, 0.1, -0.2) == pytest.approx(expected)
    assert soil_forces(soil(law=0.0), wheel(), 1e3, 0.1, 0.0) == brixius(
        soil(), wheel(), 1e3, 0.1, 0.0
    )


def test_the_same_source_has_the_same_number_and_an_edited_one_another(module):
    spec = module("edited_law", TINY.format(gain=1.0)) + ":pushes"
    first = law_number(spec)
    assert law_number(spec) == first
    module("edited_law", TINY.format(gain=3.0) + "# another length\n")
    edited = law_number(spec)
    assert edited != first
    assert soil_forces(soil(law=edited), wheel(), 1e3, 0.1, 0.0)[0] == pytest.approx(300.0)
    assert soil_forces(soil(law=first), wheel(), 1e3, 0.1, 0.0)[0] == pytest.approx(100.0)


def test_a_number_no_law_has_gives_nan():
    assert np.all(np.isnan(soil_forces(soil(law=123456.0), wheel(), 1e3, 0.1, 0.0)))


@pytest.mark.parametrize(
    ("text", "name", "says"),
    [
        ("x = 1\n", "law", "attribute"),
        ("law = 3\n", "law", "no function"),
        ("def law(a, b, c, d, e):\n    return 1.0, 2.0\n", "law", "cannot be compiled"),
        ("def law(a, b, c, d, e):\n    return misspelt, 1.0, 1.0, 1.0, 1.0\n", "law", "misspelt"),
        ("raise RuntimeError('half way')\n", "law", "half way"),
    ],
)
def test_what_is_no_law_is_refused_in_words(module, text, name, says):
    with pytest.raises(BadInput, match=says) as caught:
        law_number(module("bad_law", text) + ":" + name)
    assert "\x1b" not in str(caught.value)


def test_a_module_that_is_not_there_is_named():
    with pytest.raises(BadInput, match="there is no module 'no_such_module'"):
        law_number("no_such_module:law")


@pytest.mark.parametrize("name", MEASURED)
def test_a_measured_soil_is_in_the_block_in_si(name):
    numbers = PRESETS[name].deformable
    part = soil_part(Ground(preset=name, law="bekker"))
    assert part[Soil.LAW] == 1.0
    assert part[Soil.K_C] == 1e3 * numbers.k_c_kn_per_m_n1
    assert part[Soil.K_PHI] == 1e3 * numbers.k_phi_kn_per_m_n2
    assert part[Soil.COHESION_PA] == 1e3 * numbers.cohesion_kpa
    assert part[Soil.TAN_PHI] == math.tan(math.radians(numbers.friction_angle_deg))
    assert part[Soil.FRICTION] == part[Soil.TAN_PHI]
    assert part[Soil.SHEAR_LONG_M] == part[Soil.SHEAR_LAT_M] == numbers.shear_modulus_m
    assert np.all(np.isfinite(list(part.values())))


def test_own_numbers_take_the_presets_place():
    own = Ground(
        preset="lete-sand", law="bekker", k_phi_kn_per_m_n2=1528.43, shear_modulus_m=0.025,
        lateral_shear_ratio=0.8,
    )  # fmt: skip
    part = soil_part(own)
    assert part[Soil.K_PHI] == 1528430.0
    assert part[Soil.SHEAR_LAT_M] == pytest.approx(0.02)
    assert part[Soil.K_C] == 102e3


@pytest.mark.parametrize(
    ("make", "error", "says"),
    [
        (lambda: Ground(law="bekkerr"), UnknownName, "did you mean 'bekker'"),
        (lambda: Ground(preset="lete-sand"), BadInput, "no cone index"),
        (lambda: Ground(preset="asphalt", law="bekker"), BadInput, "soil.k_phi_kn_per_m_n2"),
        (lambda: Ground(law="bekker", shear_modulus_m=0.0), OutOfRange, "soil.shear_modulus_m = 0"),
        (lambda: Ground(law="bekker", sinkage_exponent=2.0), OutOfRange, "soil.sinkage_exponent"),
        (
            lambda: Ground(law="bekker", k_phi_kn_per_m_n2=50.0),
            OutOfRange,
            "bears 7.92 kPa at 0.1 m",
        ),
        (lambda: Ground(law="bekker", cohesion_kpa=120.0), OutOfRange, "least 360 kPa would do"),
        (lambda: Ground(law="bekker", friction_angle_deg=60.0), OutOfRange, "friction_angle_deg"),
    ],
)
def test_a_soil_that_cannot_be_is_refused_in_words(make, error, says):
    with pytest.raises(error, match=says):
        make()


@pytest.mark.parametrize("preset", ["firm", "tilled", "soft"])
def test_the_fields_pull_alike_under_both_laws(preset):
    """The fitted sets: net and gross traction of an 18.4-38 within 0.08 of the load, rms 0.04."""
    apart = []
    blocks = [soil_part(Ground(preset=preset, law=law)) for law in ("brixius", "bekker")]
    for load in (16e3, 21.7e3, 26e3):
        for slip in (0.03, 0.05, 0.1, 0.15, 0.2, 0.25, 0.3):
            ratios = []
            for part in blocks:
                ground = np.zeros(Soil.SIZE)
                ground[list(part)] = list(part.values())
                x, _, resistance, rolling, _ = soil_forces(ground, wheel(), load, slip, 0.0)
                ratios.append(((x - resistance) / load, (x + rolling) / load))
            apart.append(np.subtract(*ratios))
    assert np.abs(apart).max() < 0.08
    assert np.sqrt(np.mean(np.square(apart))) < 0.04


def test_brixius_range_is_the_published():
    """W / (b d) 15 to 55 kPa: 12.3 to 45.1 kN on an 18.4-38."""
    assert outside_validity(soil(), wheel(), 21.7e3) == ()
    (light,) = outside_validity(soil(), wheel(), 10e3)
    assert "W/(b d) = 12.2 kPa is outside [15, 55] kPa" in light
    assert outside_validity(soil(), wheel(), 13e3) == outside_validity(soil(), wheel(), 45e3) == ()
    assert len(outside_validity(soil(), wheel(), 46e3)) == 1
    hard = wheel()
    hard[Wheel.DEFLECTION_RATIO] = 0.05
    assert "delta/h = 0.05" in outside_validity(soil(), hard, 21.7e3)[0]


def test_a_bogged_wheel_is_reported():
    assert outside_validity(sinking(*SOILS["C"]), rigid_wheel(), 5e3) == ()
    (bogged,) = outside_validity(sinking(2.56, 43.12, 0.2, 1.38, 38.0, 0.02), rigid_wheel(), 9e3)
    assert "does not carry" in bogged
