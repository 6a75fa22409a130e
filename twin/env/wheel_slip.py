"""WheelSlip-v0: the torque of each rear wheel against its slip."""

from __future__ import annotations

from gymnasium.utils import EzPickle

from twin.env.pulling import USUAL_MACHINE, Pulling
from twin.env.rendering import Look
from twin.env.schedule import Grounds
from twin.env.single import RENDER_MODES, SingleEnv
from twin.env.torque_fleet import USUAL_IMPLEMENT


class WheelSlipEnv(SingleEnv):
    """A 115 kg electric tractor tows a cultivator; a controller sets the torque of each rear wheel.

    The goal is to hold each rear wheel's slip near a target while friction, cone index and pull
    change with place, and to keep the sideslip of the rear axle down on cross slopes. A driver holds
    the line with the front wheels. A control step is 20 ms, ten physics steps.

    ```
    env = gymnasium.make("twin.env:WheelSlip-v0", observation="estimate")
    observation, info = env.reset(seed=1, options={"field.cross_slope_deg": 8.0})
    many = gymnasium.make_vec(
        "twin.env:WheelSlip-v0", num_envs=256, vectorization_mode="vector_entry_point"
    )
    ```

    The second is `twin.env.vector.WheelSlipVectorEnv`: many tractors in one batch.

    ## Arguments

    | name | default | meaning |
    |---|---|---|
    | `observation` | "estimate" | "estimate": an estimator's output and a gyroscope; "sensors": the latest raw samples; "truth": what is true, for ablation |
    | `estimator` | "four-state" | for "estimate": a registered name, or `module:Name` |
    | `slip_target` | 0.15 | slip to hold at each rear wheel [-], 0.02 to 0.4 |
    | `render_mode` | None | "rgb_array": `render()` gives a picture; "human": a window, no faster than real time |
    | `width`, `height` | 640, 480 | of the picture or the window [px], 16 to 4096 |
    | `machine` | "electric_tractor" | a machine with a motor on each rear wheel: a name of `twin list`, or a file |
    | `implement` | "cultivator_light" | what it pulls, by its draft alone: a name of `twin list`, or a file |
    | `grounds` | None | what of the ground is fixed or scheduled: a dict of `reset`'s options for every episode; a function (episode, generator) -> dict, where `episode` counts from 0; in a vector environment also a list with one of these for each tractor. Autoreset keeps it, and `reset`'s own options come before it |
    | `camera` | "follow" | viewpoint: "follow" (behind, to the left), "side", "behind", "front" or "top"; it stays with the tractor |

    ## Actions: `Box(-1, 1, (2,), float32)`, values outside are taken as the bound

    | # | name | -1 | +1 | meaning |
    |---|---|---|---|---|
    | 0 | torque_left | -80 N m | 80 N m | torque of the left rear wheel's motor at zero speed; linear in the action, without delay. It falls by 2 N m for each rad/s, so that an unloaded wheel reaches 40 rad/s (assumed) |
    | 1 | torque_right | -80 N m | 80 N m | the right one's |

    ## Observations: `Box(float32)`, finite, clipped to the bounds

    SI units; body frame x forward, y left, z up. Slip is (w R - v) / max(|w R|, |v|, 0.05 m/s).
    Each control step shows what arrived by its end; a value not known (yet) is the last known one,
    or 0. Estimates and sensors are late by their own filters and latencies. Truth is of the
    instant of the observation.

    Entries of "estimate". The entries common to all modes follow them:

    | name | low | high | unit | meaning |
    |---|---|---|---|---|
    | slip | -1 | 1 | - | slip of the driven axle, estimated |
    | slip_sd | 0 | 1 | - | its standard deviation, as the estimator believes |
    | slip_rl | -1 | 1 | - | slip of the left rear wheel, estimated |
    | slip_rr | -1 | 1 | - | slip of the right one, estimated |
    | speed_mps | -5 | 10 | m/s | forward speed of the rear-axle centre, estimated |
    | wheel_speed_mps | -5 | 10 | m/s | theoretical speed w R of the driven axle, nominal radius, estimated |
    | sideslip_rear_rad | -1.6 | 1.6 | rad | sideslip angle of the rear-axle centre, estimated |
    | imu.gyro_z_radps | -5 | 5 | rad/s | angular velocity, body z, measured |

    Entries of "sensors", columns of `twin.streams`. The entries common to all modes follow them:

    | name | low | high | unit | meaning |
    |---|---|---|---|---|
    | gnss.v_east_mps | -10 | 10 | m/s | velocity of the main antenna, world east |
    | gnss.v_north_mps | -10 | 10 | m/s | world north |
    | gnss.v_up_mps | -10 | 10 | m/s | world up |
    | gnss.heading_rad | -4 | 7 | rad | heading of the antenna baseline, counter-clockwise from east |
    | gnss.age_s | 0 | 10 | s | time since the epoch of the GNSS sample |
    | imu.gyro_x_radps | -5 | 5 | rad/s | angular velocity, body x |
    | imu.gyro_y_radps | -5 | 5 | rad/s | body y |
    | imu.gyro_z_radps | -5 | 5 | rad/s | body z |
    | imu.accel_x_mps2 | -100 | 100 | m/s2 | specific force, body x |
    | imu.accel_y_mps2 | -100 | 100 | m/s2 | body y |
    | imu.accel_z_mps2 | -100 | 100 | m/s2 | body z |
    | wheels.ticks_fl | -2000 | 2000 | counts | encoder counts arrived in this control step, front left |
    | wheels.ticks_fr | -2000 | 2000 | counts | front right |
    | wheels.ticks_rl | -2000 | 2000 | counts | rear left |
    | wheels.ticks_rr | -2000 | 2000 | counts | rear right |

    Entries of "truth". The entries common to all modes follow them:

    | name | low | high | unit | meaning |
    |---|---|---|---|---|
    | slip | -1 | 1 | - | slip of the driven axle |
    | slip_fl | -1 | 1 | - | slip, front left |
    | slip_fr | -1 | 1 | - | slip, front right |
    | slip_rl | -1 | 1 | - | slip, rear left |
    | slip_rr | -1 | 1 | - | slip, rear right |
    | speed_mps | -5 | 10 | m/s | velocity of the rear-axle centre along x of the body in the ground plane |
    | v_y_rear_mps | -5 | 5 | m/s | velocity of the rear-axle centre along y in the ground plane |
    | wheel_speed_mps | -5 | 10 | m/s | w R of the driven axle, true radius |
    | draft_n | -200000 | 200000 | N | draft of the cultivator, against the motion |
    | axle_torque_nm | -200000 | 200000 | N m | torque of both motors |
    | load_fl_n | 0 | 200000 | N | normal load, front left |
    | load_fr_n | 0 | 200000 | N | normal load, front right |
    | load_rl_n | 0 | 200000 | N | normal load, rear left |
    | load_rr_n | 0 | 200000 | N | normal load, rear right |

    Entries common to all modes, after the mode's own:

    | name | low | high | unit | meaning |
    |---|---|---|---|---|
    | torque_left | -1 | 1 | - | the left action in force |
    | torque_right | -1 | 1 | - | the right action in force |
    | slip_target | 0 | 0.5 | - | argument `slip_target` |

    ## Reward: the sum of three terms from the truth at the end of the control step

    | term | value | range |
    |---|---|---|
    | slip_left | 0.35 / (1 + ((slip_rl - target) / 0.05)^2) | (0, 0.35] |
    | slip_right | 0.35 / (1 + ((slip_rr - target) / 0.05)^2) | (0, 0.35] |
    | sideslip | 0.30 / (1 + (v_y / 0.05 m/s)^2), of the rear axle | (0, 0.30] |

    None is negative, so stalling never pays. Each is in `info` as `reward_<term>` (0 after a reset), beside `slip`,
    `slip_rl`, `slip_rr`, `speed_mps`, `v_y_rear_mps`, `draft_n`, `traction_efficiency`, and after a
    reset the ground by the names of the options below.

    ## Start

    A stored state, one of MuJoCo's keyframes: rolling straight at 1 m/s, settled for 6 s on its
    slope, the cultivator in the ground with the draft of a soil of F = 0.7. Sensors and estimator have seen the last 2 s. The cultivator's draft is
    F (80 N + 130 N (v / 1 m/s)^2), after ASABE D497's form, pulled 0.12 m behind the rear axle and
    0.05 m above it; its size is assumed. The ground is drawn from the seed:

    | quantity | drawn | option of `reset` |
    |---|---|---|
    | preset | dry, wet, firm or grass | `soil.preset`, any of `twin list` |
    | friction | preset x U(0.85, 1.10) | `soil.friction` |
    | cone index | preset x U(0.80, 1.25) | `soil.cone_index_kpa` [kPa] |
    | draft scale | preset x U(0.80, 1.20) | `soil.draft_scale`, F of ASABE D497 |
    | slope | one of 16 keyframes: cross slope within 10 deg, grade within 2 deg; the first is level | `field.cross_slope_deg` (rises to the left), `field.grade_deg` (rises ahead); another combination is settled at its first use, which takes about 0.2 s of computing |
    | patches of weaker soil | 0 to 4; start 1 to 40 m ahead, length 2 to 8 m, friction x U(0.5, 1), cone index x U(0.6, 1) | `field.patches`, up to four of (start_m, length_m, friction factor, cone index factor) |
    | place in the field | within 1000 m, along and to the left | `field.origin_m` [m] |
    | pattern of strength in the field, sensor errors | seeds | cannot be set |

    ## End

    Terminated by a stall: slower than 0.05 m/s for 1 s. Truncated after 1000 control steps (20 s)
    by the registration's limit.

    ## Errors

    A wrong shape or a NaN in the action, an unknown option or a value out of range raise
    `twin.errors.TwinError`. The environment stays as it was, and you can go on.

    ## Version history

    v0: first.
    """  # noqa: E501

    episodes: Pulling

    def __init__(
        self,
        observation: str = "estimate",
        estimator: str = "four-state",
        slip_target: float = 0.15,
        render_mode: str | None = None,
        width: int = 640,
        height: int = 480,
        camera: str = "follow",
        machine: str = USUAL_MACHINE,
        implement: str = USUAL_IMPLEMENT,
        grounds: Grounds = None,
    ) -> None:
        EzPickle.__init__(
            self, observation, estimator, slip_target, render_mode, width, height, camera, machine,
            implement, grounds,
        )  # fmt: skip
        look = Look(render_mode, width, height, camera).check(RENDER_MODES)
        episodes = Pulling(
            observation, estimator, slip_target, machine=machine, implement=implement
        )
        self._hold(episodes, look, grounds)
