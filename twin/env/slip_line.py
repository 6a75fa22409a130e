"""WheelSlip-v1: the motors of both rear wheels, for speed, energy and a line across a slope."""

from __future__ import annotations

from gymnasium.utils import EzPickle

from twin.env.pulling import USUAL_MACHINE
from twin.env.rendering import Look
from twin.env.schedule import Grounds
from twin.env.single import RENDER_MODES, SingleEnv
from twin.env.torque_fleet import USUAL_IMPLEMENT
from twin.env.traction import Traction


class SlipLineEnv(SingleEnv):
    """A 115 kg electric tractor tows a cultivator along a line, on cross slopes up to 15 degrees.

    A controller sets the motor of each rear wheel. The goal is speed for little energy, near the
    line, without much slip. A wheel that pulls more holds less sideways, and the draft changes
    with place, so that no slip is the best everywhere. A driver steers the front wheels to the
    line. A control step is 20 ms, ten physics steps.

    ```
    env = gymnasium.make("twin.env:WheelSlip-v1", observation="estimate", actuation="torque")
    observation, info = env.reset(seed=1, options={"field.cross_slope_deg": 15.0})
    many = gymnasium.make_vec(
        "twin.env:WheelSlip-v1", num_envs=256, vectorization_mode="vector_entry_point"
    )
    ```

    The second is `twin.env.vector.SlipLineVectorEnv`: many tractors in one batch.

    ## Arguments

    | name | default | meaning |
    |---|---|---|
    | `observation` | "estimate" | "estimate": an estimator's output and a gyroscope; "sensors": the latest raw samples; "truth": what is true, for ablation |
    | `estimator` | "four-state" | for "estimate": a registered name, or `module:Name` |
    | `actuation` | "torque" | what the actions are: "torque", or "speed" with a speed loop in each motor |
    | `render_mode` | None | "rgb_array": `render()` gives a picture; "human": a window, no faster than real time |
    | `width`, `height` | 640, 480 | of the picture or the window [px], 16 to 4096 |
    | `machine` | "electric_tractor" | a machine with a motor on each rear wheel: a name of `twin list`, or a file |
    | `implement` | "cultivator_light" | what it pulls, by its draft alone: a name of `twin list`, or a file |
    | `grounds` | None | what of the ground is fixed or scheduled: a dict of `reset`'s options for every episode; a function (episode, generator) -> dict, where `episode` counts from 0; in a vector environment also a list with one of these for each tractor. Autoreset keeps it, and `reset`'s own options come before it |
    | `camera` | "follow" | viewpoint: "follow" (behind, to the left), "side", "behind", "front" or "top"; it stays with the tractor |

    ## Actions: `Box(-1, 1, (2,), float32)`, values outside are taken as the bound

    With `actuation="torque"`:

    | # | name | -1 | +1 | meaning |
    |---|---|---|---|---|
    | 0 | torque_left | -80 N m | 80 N m | torque of the left rear wheel's motor at zero speed, which follows with a lag of 0.05 s (assumed). It falls by 2 N m for each rad/s, so that an unloaded wheel reaches 40 rad/s (assumed) |
    | 1 | torque_right | -80 N m | 80 N m | the right one's |

    With `actuation="speed"` they are called speed_left and speed_right, -1 is 0 rad/s and +1 is
    12 rad/s. A controller in each motor, u = 0.15 e + integral of 0.6 e for the error e in rad/s,
    finds the torque action u, and the same lag follows (gains assumed).

    ## Observations: `Box(float32)`, finite, clipped to the bounds

    The entries of "estimate", "sensors" and "truth" are those of `twin.env.wheel_slip.WheelSlipEnv`.
    Entries common to all modes follow the mode's own:

    | name | low | high | unit | meaning |
    |---|---|---|---|---|
    | torque_left | -1 | 1 | - | torque of the left motor after its lag, over the largest |
    | torque_right | -1 | 1 | - | that of the right one |
    | line_left_m | -10 | 10 | m | the rear axle's distance from the line, positive to the left of it: from the last GNSS sample, or true with "truth" |
    | line_heading_rad | -3.2 | 3.2 | rad | heading against the line, positive to the left, from the same |

    ## Costs and limits

    Each in [0, 1], from the truth at the end of the control step, in `info` as `cost_<name>`:

    | cost | limit | value |
    |---|---|---|
    | line | 0.10 m | clip((abs(y) - 0.10 m) / 0.20 m, 0, 1), y the rear axle's distance from the line |
    | slip | 0.20 | mean over both rear wheels of clip((s - 0.20) / 0.20, 0, 1) |

    The limits are assumed.

    ## Reward: the sum of four terms

    | term | value |
    |---|---|
    | work | v / (1.2 m/s) |
    | energy | -P / (1 kW), with the power P of both motors where it is positive |
    | line, slip | 0.5 (1 - cost) of each |

    The prices are assumed; with these the best speed lies between 1.0 m/s with a heavy draft and
    1.6 m/s with a light one. Each term is in `info` as `reward_<term>`, beside the costs, `slip`, `slip_rl`,
    `slip_rr`, `speed_mps`, `v_y_rear_mps`, `draft_n`, `axle_w`, `left_m`, and after a reset the ground
    by the names of the options below. A stall ends the episode, and with it all that would still
    have been earned.

    ## Start

    As in `WheelSlipEnv`: rolling at 1 m/s, settled for 6 s on its slope. The ground is drawn from
    the seed:

    | quantity | drawn | option of `reset` |
    |---|---|---|
    | preset | dry, wet, firm or grass | `soil.preset`, any of `twin list` |
    | friction | preset x U(0.85, 1.10) | `soil.friction` |
    | cone index | preset x U(0.80, 1.25) | `soil.cone_index_kpa` [kPa] |
    | draft scale | preset x U(0.60, 1.40) | `soil.draft_scale`, F of ASABE D497, and varies by 25 % with place, over about 4 m (assumed) |
    | slope | one of 16 keyframes: cross slope within 15 deg, grade within 2 deg; the first is level | `field.cross_slope_deg` (rises to the left), `field.grade_deg` (rises ahead) |
    | patches of weaker soil | 0 to 4; start 1 to 30 m ahead, length 2 to 6 m, friction x U(0.6, 1), cone index x U(0.6, 1) | `field.patches`, up to four of (start_m, length_m, friction factor, cone index factor) |
    | place in the field | within 1000 m, along and to the left | `field.origin_m` [m] |
    | pattern of strength and draft in the field, sensor errors | seeds | cannot be set |

    ## End

    Terminated by a stall: slower than 0.05 m/s for 1 s. Truncated after 1000 control steps (20 s)
    by the registration's limit.

    ## Errors

    A wrong shape or a NaN in the action, an unknown option or a value out of range raise
    `twin.errors.TwinError`. The environment stays as it was, and you can go on.

    ## Version history

    v1: motor lag, a speed loop as an option, a line to hold, steeper cross slopes, a draft that
    varies with place, costs against limits. v0 is `twin.env.wheel_slip.WheelSlipEnv`.
    """  # noqa: E501

    episodes: Traction

    def __init__(
        self,
        observation: str = "estimate",
        estimator: str = "four-state",
        actuation: str = "torque",
        render_mode: str | None = None,
        width: int = 640,
        height: int = 480,
        camera: str = "follow",
        machine: str = USUAL_MACHINE,
        implement: str = USUAL_IMPLEMENT,
        grounds: Grounds = None,
    ) -> None:
        EzPickle.__init__(
            self, observation, estimator, actuation, render_mode, width, height, camera, machine,
            implement, grounds,
        )  # fmt: skip
        look = Look(render_mode, width, height, camera).check(RENDER_MODES)
        episodes = Traction(observation, estimator, actuation, machine=machine, implement=implement)
        self._hold(episodes, look, grounds)
