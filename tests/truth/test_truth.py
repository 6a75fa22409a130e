"""The truth's definitions against closed forms: slip, frames on a slope, sideslip, integrals."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from tests.simulation.rigs import BARE, EVEN, driven, field, replace
from twin.compute.quaternion import from_matrix
from twin.simulation.build import build
from twin.simulation.simulate import simulate
from twin.streams import WHEELS
from twin.trajectory.trajectory import Trajectory
from twin.truth import truth
from twin.truth.motion import slip_ratio

STEP_NS = 2_000_000
speeds = st.floats(-5.0, 5.0)


def trajectory(n=501, **columns):
    """A trajectory of `n` steps; what is not given is zero, the body level and heading east."""
    shapes = {
        "position_w": (3,), "velocity_w": (3,), "cg_velocity_w": (3,), "gyro_b": (3,),
        "spin_radps": (4,), "rolling_radius_m": (4,), "wheel_speed_x_mps": (4,), "slip": (4,),
        "load_n": (4,), "shear_x_n": (4,), "wheel_angle_rad": (4,), "draft_n": (), "depth_m": (),
        "depth_wheel_n": (), "plough_side_n": (), "power_engine_w": (), "power_lift_w": (),
        "kinetic_j": (), "potential_j": (),
        "engine_radps": (), "engine_torque_nm": (), "fuel_lph": (), "axle_torque_nm": (),
        "fl_steer_rad": (), "fr_steer_rad": (), "front_swing_rad": (), "hitch_rad": (),
        "plough_pitch_rad": (),
    }  # fmt: skip
    full = {name: np.zeros((n, *shape)) for name, shape in shapes.items()}
    full["world_from_body"] = np.tile([1.0, 0.0, 0.0, 0.0], (n, 1))
    full["ground_normal_w"] = np.tile([0.0, 0.0, 1.0], (n, 1))
    for name, value in columns.items():
        full[name] = np.broadcast_to(np.asarray(value, float), full[name].shape)
    return Trajectory(np.arange(n, dtype=np.int64) * STEP_NS, full)


@given(speeds, speeds)
def test_slip_is_bounded_odd_and_antisymmetric(rim, v):
    s = slip_ratio(np.array(rim), np.array(v))
    assert abs(s) <= 2.0
    assert slip_ratio(np.array(-rim), np.array(-v)) == -s
    assert slip_ratio(np.array(v), np.array(rim)) == -s


@pytest.mark.parametrize(
    ("rim", "v", "slip"),
    [(2.0, 1.5, 0.25), (1.5, 2.0, -0.25), (1.0, 0.0, 1.0), (0.0, 1.0, -1.0), (-2.0, -1.5, -0.25),
     (-1.5, -2.0, 0.25), (0.0, -1.0, 1.0), (1.0, -1.0, 2.0), (1.0, -0.5, 1.5), (-0.5, 1.0, -1.5),
     (0.02, 0.01, 0.2), (0.0, 0.0, 0.0)],
)  # fmt: skip
def test_slip_by_hand(rim, v, slip):
    assert slip_ratio(np.array(rim), np.array(v)) == pytest.approx(slip)


@pytest.mark.parametrize(
    ("rim", "v"), [(1.6, 1.4), (-1.6, -1.4), (-1.4, -1.6), (0.5, -0.5), (0.0, -1.0)]
)
def test_the_truth_of_reverse_braking_and_sliding_back_has_the_sign_of_the_definition(rim, v):
    radius = np.array([0.6, 0.6, 0.8, 0.8])
    table = truth.sample(
        trajectory(
            velocity_w=[v, 0.0, 0.0],
            cg_velocity_w=[v, 0.0, 0.0],
            rolling_radius_m=radius,
            spin_radps=rim / radius,
            wheel_speed_x_mps=v,
            slip=slip_ratio(rim, v),
        ),
        ("rl", "rr"),
    )
    due = (rim - v) / max(abs(rim), abs(v))
    assert table["slip"] == pytest.approx(due)
    assert table["speed_mps"] == pytest.approx(v)
    assert table["wheel_speed_mps"] == pytest.approx(rim)


@pytest.mark.parametrize("slope_deg", [0.0, 18.0, -18.0])
@pytest.mark.parametrize("crab_deg", [3.0, -5.0, 0.0])
def test_sideslip_on_a_slope_is_the_angle_in_the_slope(slope_deg, crab_deg):
    """Heading 17 deg up or down the slope, leaning and nodding on its tyres, and crabbing."""
    ground = Rotation.from_euler("zx", [40.0, slope_deg], degrees=True)
    yaw = math.radians(17.0)
    body = ground * Rotation.from_euler("ZYX", [17.0, 2.0, -4.0], degrees=True)
    course = yaw + math.radians(crab_deg)
    velocity = ground.apply([1.4 * math.cos(course), 1.4 * math.sin(course), 0.0])
    table = truth.sample(
        trajectory(
            world_from_body=body.as_quat(scalar_first=True),
            ground_normal_w=ground.apply([0.0, 0.0, 1.0]),
            velocity_w=velocity,
            cg_velocity_w=velocity,
        ),
        ("rl", "rr"),
    )
    for suffix in ("", "_rear"):
        angle = np.degrees(table[f"sideslip{suffix}_rad"])
        assert angle == pytest.approx(crab_deg, abs=1e-9)  # positive to the left
        assert table[f"v_y{suffix}_mps"] == pytest.approx(1.4 * math.sin(math.radians(crab_deg)))
        assert table[f"v_x{suffix}_mps"] == pytest.approx(1.4 * math.cos(math.radians(crab_deg)))


def test_a_horizontal_course_less_heading_is_not_the_sideslip():
    """Straight down an 18 deg slope's side, a sideslip of 2.00 deg reads 1.90 deg on the map."""
    ground = Rotation.from_euler("x", 18.0, degrees=True)
    velocity = ground.apply([math.cos(math.radians(-2.0)), math.sin(math.radians(-2.0)), 0.0])
    table = truth.sample(
        trajectory(
            world_from_body=ground.as_quat(scalar_first=True),
            ground_normal_w=ground.apply([0.0, 0.0, 1.0]),
            cg_velocity_w=velocity,
        ),
        ("rl", "rr"),
    )
    assert np.degrees(table["sideslip_rad"][0]) == pytest.approx(-2.0)
    assert math.degrees(math.atan2(velocity[1], velocity[0])) == pytest.approx(-1.90, abs=0.005)


def test_turning_the_two_points_differ_by_b_yaw_rate_over_v():
    """A circle without tyre slip: nothing at the rear axle, atan(b r / v) at the CG."""
    b, r, v = 1.071, 0.3, 1.5
    table = truth.sample(
        trajectory(velocity_w=[v, 0.0, 0.0], cg_velocity_w=[v, b * r, 0.0], gyro_b=[0.0, 0.0, r]),
        ("rl", "rr"),
    )
    assert np.all(table["sideslip_rear_rad"] == 0.0)
    assert table["sideslip_rad"] == pytest.approx(math.atan(b * r / v))
    assert table["yaw_rate_radps"] == pytest.approx(r)


@pytest.mark.parametrize(("speed", "known"), [(0.049, False), (0.051, True), (0.0, False)])
def test_standing_has_no_sideslip_angle_but_goes_on_counting_the_way(speed, known):
    table = truth.sample(trajectory(cg_velocity_w=[0.0, speed, 0.0]), ("rl", "rr"))
    assert np.all(np.isfinite(table["sideslip_rad"]) == known)
    whole = truth.integrate(table, None)
    assert whole["sideslip_m"][-1] == pytest.approx(speed * 1.0)


def test_the_amount_is_the_integral_of_v_y_and_can_go_back():
    t = np.arange(5001) * 0.002
    v_y = 0.1 * np.cos(0.6 * t)
    velocity = np.stack([np.full_like(t, 1.5), v_y, 0.0 * t], 1)
    table = truth.integrate(
        truth.sample(trajectory(5001, cg_velocity_w=velocity), ("rl", "rr")), None
    )
    seconds = table["epoch_ns"] * 1e-9
    assert table["sideslip_m"] == pytest.approx(0.1 / 0.6 * np.sin(0.6 * seconds), abs=3e-6)
    assert np.all(table["sideslip_rear_m"] == 0.0)
    assert np.all(np.diff(table["epoch_ns"]) == 20_000_000)


def test_axle_slip_is_of_the_mean_speeds_of_the_driven_wheels():
    rim, v = np.array([1.4, 1.4, 1.9, 1.7]), np.array([1.45, 1.45, 1.5, 1.4])
    moving = trajectory(spin_radps=rim / 0.8, rolling_radius_m=0.8, wheel_speed_x_mps=v)
    rear = truth.sample(moving, ("rl", "rr"))
    assert rear["slip"] == pytest.approx((1.8 - 1.45) / 1.8)
    assert rear["wheel_speed_mps"] == pytest.approx(1.8)
    everything = truth.sample(moving, WHEELS)
    assert everything["slip"] == pytest.approx((1.6 - 1.45) / 1.6)


def test_ploughing_begins_at_full_depth_and_does_not_end():
    depth = np.concatenate([np.linspace(0.0, 0.25, 250), np.full(251, 0.22)])
    table = truth.sample(trajectory(depth_m=depth), ("rl", "rr"))
    ploughing = truth.integrate(dict(table), 0.95 * 0.25)["ploughing"]
    first = int(np.argmax(ploughing))
    assert table["depth_m"][first] >= 0.95 * 0.25 > table["depth_m"][first - 1]
    assert np.all(ploughing[first:])
    assert not np.any(truth.integrate(dict(table), None)["ploughing"])


def test_powers_are_means_so_that_their_sum_is_the_work():
    """Of a power that varies between the samples, no work is lost; stores are read at samples."""
    t = np.arange(501) * 0.002
    power = 1e3 * (1.0 + np.sin(2.0 * np.pi * 40.0 * t) ** 2)
    moving = trajectory(power_engine_w=power, power_lift_w=-t, kinetic_j=t**2, potential_j=7.0)
    table = truth.sample(moving, ("rl", "rr"))
    assert table["power_engine_w"][:-1].sum() * 0.02 == pytest.approx(power[:-1].sum() * 0.002)
    assert table["power_engine_w"][3] == pytest.approx(power[30:40].mean())
    assert table["power_lift_w"][:-1].sum() * 0.02 == pytest.approx(-t[:-1].sum() * 0.002)
    assert table["kinetic_j"] == pytest.approx((np.arange(51) * 0.02) ** 2)
    assert np.all(table["potential_j"] == 7.0)


def test_cutting_the_drive_changes_no_bit_of_its_truth():
    machine = build(BARE)
    whole = [truth.sample(c, ("rl", "rr")) for c in simulate(machine)]
    cut = [truth.sample(c, ("rl", "rr")) for c in simulate(machine, chunk_decisions=3)]
    one = truth.integrate(truth.concatenate(whole), None)
    other = truth.integrate(truth.concatenate(cut), None)
    assert all(np.array_equal(one[n], other[n], equal_nan=True) for n in one)


def test_along_a_slope_the_held_line_is_a_sideslip_downhill():
    """Rising to the left, the tractor slides to its right and steers up to keep its line."""
    scenario = replace(
        field(EVEN, cross_slope_deg=12.0), course=replace(BARE.course, length_m=90.0)
    )
    machine = build(scenario)
    parts = [truth.sample(c, ("rl", "rr")) for c in simulate(machine)]
    table = truth.integrate(truth.concatenate(parts), None)
    late = slice(-200, None)
    assert np.all(table["sideslip_rear_rad"][late] < -0.01)
    rotation = Rotation.from_matrix(machine.world_from_ground)
    quaternions = np.stack([table[q] for q in ("qw", "qx", "qy", "qz")], 1)
    body = Rotation.from_quat(quaternions, scalar_first=True)
    heading = (rotation.inv() * body).apply([1.0, 0.0, 0.0])
    psi = np.arctan2(heading[:, 1], heading[:, 0])
    # on a straight steady line heading and sideslip cancel
    assert table["sideslip_rear_rad"][late] == pytest.approx(-psi[late], abs=2e-3)
    amount = np.diff(table["sideslip_rear_m"])[late] / 0.02
    assert amount == pytest.approx(table["v_y_rear_mps"][late], abs=1e-3)


def test_the_frame_of_the_drive_is_the_frame_of_its_truth():
    """Position differentiates to the tabled ground-plane velocities, on a slope and off east."""
    scenario = replace(
        field(BARE, cross_slope_deg=18.0),
        course=replace(BARE.course, heading_deg=17.0, length_m=60.0),
    )
    columns = driven(scenario)
    n = len(columns["position_w"])
    table = truth.sample(Trajectory(np.arange(n, dtype=np.int64) * STEP_NS, columns), ("rl", "rr"))
    place = np.stack([table[c] for c in ("east_m", "north_m", "up_m")], 1)
    speed = np.linalg.norm(place[2:] - place[:-2], axis=1) / 0.04
    planar = np.hypot(table["v_x_rear_mps"], table["v_y_rear_mps"])[1:-1]
    assert speed[200:] == pytest.approx(planar[200:], abs=2e-3)
    q = from_matrix(build(scenario).world_from_ground)
    assert abs(q @ np.array([table[c][-1] for c in ("qw", "qx", "qy", "qz")])) > 0.999
