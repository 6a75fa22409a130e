"""Plough-v1: throttle, gear and hitch on a field that changes, for area and fuel within limits."""

from __future__ import annotations

from gymnasium.utils import EzPickle

from twin.env.fieldwork import FieldWork
from twin.env.rendering import Look
from twin.env.schedule import Grounds
from twin.env.single import RENDER_MODES, SingleEnv
from twin.scenario import Scenario


class PloughFieldEnv(SingleEnv):
    """A tractor works a field of two soils; a controller sets throttle, gear, depth and draft mix.

    The goal is much area in little time with little fuel, while the error of the depth, the slip
    of the driven wheels and the lugging of the engine stay within limits. The best gear and depth
    of light soil are not those of heavy soil, and both lie in every field. A driver holds the
    line, and brakes when a slope pushes the engine above the speed that the throttle sets. A
    control step is 20 ms, ten physics steps.

    ```
    env = gymnasium.make("twin.env:Plough-v1", observation="estimate", law="brixius")
    observation, info = env.reset(seed=1, options={"soil.preset": "soft"})
    many = gymnasium.make_vec(
        "twin.env:Plough-v1", num_envs=256, vectorization_mode="vector_entry_point"
    )
    ```

    The second is `twin.env.vector.PloughFieldVectorEnv`: many tractors in one batch.

    ## Arguments

    | name | default | meaning |
    |---|---|---|
    | `observation` | "estimate" | "estimate": an estimator's output and the instruments a cab has; "sensors": the latest raw samples; "truth": what is true, for ablation |
    | `estimator` | "slip-ekf" | for "estimate": a registered name, or `module:Name` |
    | `depth_m` | 0.25 | depth to plough at, for which the depth wheel is set [m], 0.05 to 0.35 |
    | `law` | "brixius" | law by which the soil carries and pulls: "brixius" or "bekker". Train on one, test on the other |
    | `render_mode` | None | "rgb_array": `render()` gives a picture; "human": a window, no faster than real time |
    | `width`, `height` | 640, 480 | of the picture or the window [px], 16 to 4096 |
    | `machine` | "taishan_1404a" | the tractor: a name of `twin list`, or a file |
    | `implement` | None | its implement: a name of `twin list`, or a file; None for its usual one |
    | `grounds` | None | what of the ground is fixed or scheduled: a dict of `reset`'s options for every episode; a function (episode, generator) -> dict, where `episode` counts from 0; in a vector environment also a list with one of these for each tractor. Autoreset keeps it, and `reset`'s own options come before it |
    | `camera` | "follow" | viewpoint: "follow" (behind, to the left), "side", "behind", "front" or "top"; it stays with the tractor |

    ## Actions: `Box(-1, 1, (4,), float32)`, values outside are taken as the bound

    | # | name | -1 | +1 | meaning |
    |---|---|---|---|---|
    | 0 | throttle | 900 rpm | 2376 rpm | no-load engine speed that the governor holds; linear. The set point moves over its whole range in 1 s at the fastest (assumed) |
    | 1 | gear | 3 km/h | 15 km/h | speed without slip at the rated engine speed; linear in its logarithm. A transmission without steps changes the logarithm of its ratio by 0.5/s at most (assumed); one with gears takes the nearest, 1 s after its last shift at the earliest (assumed). The engine keeps its speed in a shift, and the clutch slips until the axle's fits |
    | 2 | hitch | -0.10 m | 0.35 m | depth set point of the lever; linear. Its draft set point is in proportion |
    | 3 | mix | position | draft | what the hitch's valve follows: the lever's position, the draft, or a mix of both; see `twin.simulation.driver.valve_radps` |

    The speeds of the throttle are the usual machine's; another has 1.125 of its idle speed and 0.99
    of its greatest.

    ## Observations: `Box(float32)`, finite, clipped to the bounds

    The entries of "estimate", "sensors" and "truth" are those of `twin.env.plough.PloughEnv`.
    Entries common to all modes follow the mode's own:

    | name | low | high | unit | meaning |
    |---|---|---|---|---|
    | throttle | -1 | 1 | - | where the governor's set point is, as a throttle action |
    | gear_kmh | 0 | 30 | km/h | speed without slip at the rated engine speed in the ratio in force |
    | lift_set_rad | -0.45 | 1 | rad | lower-link angle of the lift |
    | mix | 0 | 1 | - | what the valve follows: 0 position, 1 draft |
    | depth_target_m | 0 | 0.35 | m | argument `depth_m` |

    ## Costs and limits

    Each in [0, 1], from the truth at the end of the control step, in `info` as `cost_<name>`:

    | cost | limit | value |
    |---|---|---|
    | depth | error of 0.02 m | clip((abs(depth - target) - 0.02 m) / 0.05 m, 0, 1) |
    | slip | 0.15 | clip((slip - 0.15) / 0.10, 0, 1), of the driven axle |
    | lugging | speed of the greatest torque | clip((1 - n / n_peak) / 0.10, 0, 1) clip(T / T_full(n), 0, 1), of the engine at n with the torque T |

    The limits are assumed; 0.15 is where D497's best slips of tractive efficiency end on firm soil.

    ## Reward: the sum of five terms

    Area and fuel are objectives of their own, and a comparison shows both (`work_rate_haph`,
    `fuel_lph` in `info`). For learning there is one number:

    | term | value |
    |---|---|
    | work | v min(1, depth / target) / (7 km/h), v counted up to 10 km/h: the area rate over what 7 km/h make |
    | fuel | -(0.02 ha/L) fuel rate / (area rate at 7 km/h): 1.3 EUR/L over 65 EUR/h of machine and driver in about a hectare (assumed) |
    | depth, slip, lugging | 0.5 (1 - cost) of each |

    7 and 10 km/h are the typical speed and the end of the range of ASABE D497 for mould-board
    ploughs. Each term is in `info` as `reward_<term>`, beside the costs, `slip`, `depth_m`,
    `speed_mps`, `draft_n`, `engine_radps`, `work_rate_haph`, `fuel_lph`, and after a reset the ground
    by the names of the options below. A stall ends the episode, and with it all that would still
    have been earned: 1.5 within the limits, beside the work, and about 0 with spinning wheels.

    ## Start

    As in `PloughEnv`: rolling straight in the machine's usual gear, the plough carried 0.10 m above
    the ground at the edge of the field. The ground is drawn from the seed:

    | quantity | drawn | option of `reset` |
    |---|---|---|
    | preset | firm, tilled or soft, of both soils | `soil.preset`, any of `twin list` |
    | friction | preset x U(0.85, 1.10) | `soil.friction` |
    | cone index | preset x U(0.80, 1.25) | `soil.cone_index_kpa` [kPa] |
    | draft scale | preset x U(0.60, 0.85) | `soil.draft_scale`, F of ASABE D497 |
    | the heavier soil, on half the field in areas of about 12 m | friction and cone index as above, draft scale preset x U(1.15, 1.40) | `field.other_soil.preset`, `field.other_soil.friction`, `field.other_soil.cone_index_kpa`, `field.other_soil.draft_scale` |
    | soil law | argument `law` | `soil.law` |
    | slope, last furrow | one of 16 keyframes, as in `PloughEnv` | `field.cross_slope_deg`, `field.grade_deg`, `field.furrow_depth_m` |
    | patches of weaker soil | as in `PloughEnv` | `field.patches` |
    | place in the field, which decides where the areas lie | within 1000 m | `field.origin_m` [m] |
    | pattern of draft and strength in the field, sensor errors | seeds | cannot be set |

    D497 gives the draft of mould-board ploughs with 40 % either way.

    ## End

    Terminated by a stall: slower than 0.05 m/s for 1 s. Truncated after 1500 control steps (30 s)
    by the registration's limit.

    ## Errors

    A wrong shape or a NaN in the action, an unknown option or a value out of range raise
    `twin.errors.TwinError`. The environment stays as it was, and you can go on.

    ## Version history

    v1: gear and draft mix, actuator lags, two soils in every field, costs against limits, either
    soil law. v0 is `twin.env.plough.PloughEnv`.
    """  # noqa: E501

    episodes: FieldWork

    def __init__(
        self,
        observation: str = "estimate",
        estimator: str = "slip-ekf",
        depth_m: float = 0.25,
        law: str = "brixius",
        render_mode: str | None = None,
        width: int = 640,
        height: int = 480,
        camera: str = "follow",
        machine: str = Scenario.machine,
        implement: str | None = None,
        grounds: Grounds = None,
    ) -> None:
        EzPickle.__init__(
            self, observation, estimator, depth_m, law, render_mode, width, height, camera,
            machine, implement, grounds,
        )  # fmt: skip
        look = Look(render_mode, width, height, camera).check(RENDER_MODES)
        episodes = FieldWork(
            observation, estimator, depth_m, law, machine=machine, implement=implement
        )
        self._hold(episodes, look, grounds)
