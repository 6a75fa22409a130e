"""Plough-v0: throttle and hitch against slip and depth."""

from __future__ import annotations

from gymnasium.utils import EzPickle

from twin.env.ploughing import Ploughing
from twin.env.rendering import Look
from twin.env.schedule import Grounds
from twin.env.single import RENDER_MODES, SingleEnv
from twin.scenario import Scenario


class PloughEnv(SingleEnv):
    """A tractor works the soil with its implement; a controller sets throttle and hitch.

    The goal is a high work rate at a high traction efficiency, with the slip of the driven wheels
    near a target (more slip tears the soil, less slip leaves a larger share to rolling resistance)
    and the plough at its depth. A driver holds the line, and brakes when a slope pushes the engine
    above the speed that the throttle sets. A control step is 20 ms, ten physics steps.

    ```
    env = gymnasium.make("twin.env:Plough-v0", observation="estimate")
    observation, info = env.reset(seed=1, options={"soil.preset": "soft"})
    many = gymnasium.make_vec(
        "twin.env:Plough-v0", num_envs=256, vectorization_mode="vector_entry_point"
    )
    ```

    The second is `twin.env.vector.PloughVectorEnv`: many tractors in one batch.

    ## Arguments

    | name | default | meaning |
    |---|---|---|
    | `observation` | "estimate" | "estimate": an estimator's output and the instruments a cab has; "sensors": the latest raw samples; "truth": what is true, for ablation |
    | `estimator` | "slip-ekf" | for "estimate": a registered name, or `module:Name` |
    | `depth_m` | 0.25 | depth to plough at, for which the depth wheel is set [m], 0.05 to 0.35 |
    | `slip_target` | 0.12 | slip to work at [-], 0.02 to 0.4 |
    | `render_mode` | None | "rgb_array": `render()` gives a picture; "human": a window, no faster than real time |
    | `width`, `height` | 640, 480 | of the picture or the window [px], 16 to 4096 |
    | `machine` | "taishan_1404a" | the tractor: a name of `twin list`, or a file |
    | `implement` | None | its implement: a name of `twin list`, or a file; None for its usual one |
    | `grounds` | None | what of the ground is fixed or scheduled: a dict of `reset`'s options for every episode; a function (episode, generator) -> dict, where `episode` counts from 0; in a vector environment also a list with one of these for each tractor. Autoreset keeps it, and `reset`'s own options come before it |
    | `camera` | "follow" | viewpoint: "follow" (behind, to the left), "side", "behind", "front" or "top"; it stays with the tractor |

    ## Actions: `Box(-1, 1, (2,), float32)`, values outside are taken as the bound

    | # | name | -1 | +1 | meaning |
    |---|---|---|---|---|
    | 0 | throttle | 900 rpm | 2376 rpm | no-load speed the governor is set to; linear in the action, without delay; of another machine 1.125 of its idle and .99 of its no-load speed |
    | 1 | hitch | -0.10 m | 0.35 m | depth set point of the hitch, negative above the ground, up to the implement's greatest depth; linear in the action. It becomes an angle of the lower links, which move at up to 0.35 rad/s. The real depth differs, because the tractor sinks, squats and pitches |

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
    | speed_mps | -5 | 10 | m/s | forward speed of the rear-axle centre, estimated |
    | wheel_speed_mps | -5 | 10 | m/s | theoretical speed w R of the driven axle, nominal radius, estimated |
    | depth_m | -1 | 1 | m | working depth from laser and inclinometer, positive in the ground |
    | engine_radps | 0 | 400 | rad/s | engine speed on the bus |
    | engine_load | 0 | 1.25 | - | engine torque over its reference torque, on the bus |
    | draft_pin_n | -200000 | 200000 | N | draft, by the pin in the hitch, positive backward |
    | hitch_m | -1 | 1 | m | height of the hitch points over their pivots, on the bus |

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
    | depth.laser_m | -2 | 4 | m | range of the laser on the plough to the ground |
    | depth.inclination_rad | -1.6 | 1.6 | rad | pitch of the plough's frame |
    | machine.steer_rad | -1 | 1 | rad | mean steering angle, positive to the left |
    | machine.hitch_m | -1 | 1 | m | height of the hitch points over their pivots |
    | machine.draft_pin_n | -200000 | 200000 | N | draft, positive backward |
    | machine.axle_torque_nm | -200000 | 200000 | N m | torque at the driven axle |
    | machine.engine_radps | 0 | 400 | rad/s | engine speed |
    | machine.engine_load | 0 | 1.25 | - | engine torque over its reference torque |
    | machine.fuel_lph | 0 | 100 | L/h | fuel rate |

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
    | depth_m | 0 | 1 | m | mean depth of the shares |
    | draft_n | -200000 | 200000 | N | soil force on the plough against the motion |
    | axle_torque_nm | -200000 | 200000 | N m | torque at the driven axle |
    | engine_radps | -100 | 400 | rad/s | engine speed |
    | engine_torque_nm | -500 | 1000 | N m | engine torque |
    | load_fl_n | 0 | 200000 | N | normal load, front left |
    | load_fr_n | 0 | 200000 | N | normal load, front right |
    | load_rl_n | 0 | 200000 | N | normal load, rear left |
    | load_rr_n | 0 | 200000 | N | normal load, rear right |

    Entries common to all modes, after the mode's own:

    | name | low | high | unit | meaning |
    |---|---|---|---|---|
    | throttle | -1 | 1 | - | the throttle action in force |
    | lift_set_rad | -0.45 | 1 | rad | lower-link angle the hitch is set to, after the limit of its rate |
    | slip_target | 0 | 0.5 | - | argument `slip_target` |
    | depth_target_m | 0 | 0.35 | m | argument `depth_m` |

    ## Reward: the sum of four terms from the truth at the end of the control step

    | term | value | range |
    |---|---|---|
    | work | 0.30 b v min(1, depth / target) / (1 ha/h), with the working width b = 1.4 m | [0, about 0.5] |
    | efficiency | 0.20 draft v / (axle torque × axle speed), the ratio within [0, 1] | [0, 0.20] |
    | slip | 0.25 / (1 + ((slip - target) / 0.05)^2) | (0, 0.25] |
    | depth | 0.25 / (1 + ((depth - target) / 0.03 m)^2) | (0, 0.25] |

    None is negative, so stalling never pays. Each is in `info` as `reward_<term>` (0 after a reset), beside `slip`,
    `depth_m`, `speed_mps`, `draft_n`, `work_rate_haph`, `traction_efficiency`, `fuel_lph` (ASABE
    D497.7's fuel at the engine's power and speed, see `twin.machine.fuel`), and after a reset the
    ground by the names of the options below. No term of the reward uses the fuel.

    ## Start

    A stored state, one of MuJoCo's keyframes: rolling straight at 2.1 m/s with the governor at
    1665 rpm, settled for 6 s on its slope, the right wheels in the last furrow, the plough carried with its shares
    0.10 m above the ground (hitch action -1). Sensors and estimator have seen the last 2 s. The
    ground is drawn from the seed:

    | quantity | drawn | option of `reset` |
    |---|---|---|
    | preset | firm, tilled, soft or grass | `soil.preset`, any of `twin list` |
    | friction | preset x U(0.85, 1.10) | `soil.friction` |
    | cone index | preset x U(0.80, 1.25) | `soil.cone_index_kpa` [kPa] |
    | draft scale | preset x U(0.80, 1.20) | `soil.draft_scale`, F of ASABE D497 |
    | slope, last furrow | one of 16 keyframes: cross slope within 6 deg, grade within 3 deg, furrow 0.9 to 1.1 of the depth; the first is level | `field.cross_slope_deg` (rises to the left), `field.grade_deg` (rises ahead), `field.furrow_depth_m` [m]; another combination is settled at its first use, which takes about 0.2 s of computing |
    | patches of weaker soil | 0 to 2; start 3 to 40 m ahead, length 2 to 10 m, friction x U(0.7, 1), cone index x U(0.6, 1) | `field.patches`, up to four of (start_m, length_m, friction factor, cone index factor) |
    | place in the field | within 1000 m, along and to the left | `field.origin_m` [m] |
    | pattern of draft and strength in the field, sensor errors | seeds | cannot be set |

    ## End

    Terminated by a stall: slower than 0.05 m/s for 1 s. Truncated after 1500 control steps (30 s)
    by the registration's limit.

    ## Errors

    A wrong shape or a NaN in the action, an unknown option or a value out of range raise
    `twin.errors.TwinError`. The environment stays as it was, and you can go on.

    ## Version history

    v0: first. Since then, before any release: slopes, furrow depth, patches and place are drawn too,
    fuel is in `info`, the vector environment came, and the estimate became that of "slip-ekf" and
    not of "four-state", which moves the wrong way when the slip changes quickly.
    """  # noqa: E501

    episodes: Ploughing

    def __init__(
        self,
        observation: str = "estimate",
        estimator: str = "slip-ekf",
        depth_m: float = 0.25,
        slip_target: float = 0.12,
        render_mode: str | None = None,
        width: int = 640,
        height: int = 480,
        camera: str = "follow",
        machine: str = Scenario.machine,
        implement: str | None = None,
        grounds: Grounds = None,
    ) -> None:
        EzPickle.__init__(
            self, observation, estimator, depth_m, slip_target, render_mode, width, height, camera,
            machine, implement, grounds,
        )  # fmt: skip
        look = Look(render_mode, width, height, camera).check(RENDER_MODES)
        episodes = Ploughing(
            observation, estimator, depth_m, slip_target, machine=machine, implement=implement
        )
        self._hold(episodes, look, grounds)
