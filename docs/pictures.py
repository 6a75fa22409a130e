"""Makes the README's pictures from real runs: `MUJOCO_GL=egl python docs/pictures.py`.

Writes docs/pictures/ploughing.jpg and estimates.svg. Needs an OpenGL driver for the first.
"""

from __future__ import annotations

import io
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from twin.camera.opengl import OffScreen
from twin.pipeline.named import load
from twin.pipeline.result import Result
from twin.pipeline.run import run
from twin.report.palette import FIGURE, TRUTH_COLOUR, colours
from twin.scores.scores import seconds
from twin.viz.field import Seen
from twin.viz.ground import Ground, worked
from twin.viz.shapes import joint_states
from twin.viz.stage import Stage
from twin.viz.tools import position_w

HERE = Path(__file__).parent / "pictures"
ESTIMATORS = ("ratio", "four-state")
WIDTH, HEIGHT = 2560, 1280
"""Twice what a page shows it at."""
FINER = 2
"""It is drawn so many times larger, and made smaller, so that edges are smooth."""
AT_M = 40.0
"""Where along the course the picture of the tractor is taken."""
VIEW, LOOK_AT_M = (-38.0, -17.0, 8.8), (-1.2, -0.1, -0.25)
"""Azimuth and elevation [deg] and distance [m] of the eye; what it looks at, from the tractor."""
LINE: Any = FIGURE | {
    "svg.fonttype": "none", "svg.hashsalt": "", "font.family": "sans-serif", "font.size": 10.0,
}  # fmt: skip


def main() -> None:
    """Run plough-25cm and write both pictures."""
    scenario = load("scenario", "plough-25cm")
    scenario = replace(scenario, course=replace(scenario.course, length_m=60.0))
    result = run(scenario, estimators={name: load("estimator", name) for name in ESTIMATORS})
    picture = ploughing(result)
    cv2.imwrite(str(HERE / "ploughing.jpg"), picture[:, :, ::-1], [cv2.IMWRITE_JPEG_QUALITY, 88])
    (HERE / "estimates.svg").write_text(slip(result), encoding="utf-8")


def ploughing(result: Result) -> np.ndarray[Any, Any]:
    """The tractor at its work. Shape (HEIGHT, WIDTH, 3)."""
    scenario: Any = result.scenario
    stage = Stage(scenario, camera="follow", detail=2.5)
    model = stage.model
    model.vis.quality.offsamples, model.vis.quality.shadowsize = 8, 8192
    row = int(np.argmax(result.truth["east_m"] > AT_M))
    past = {name: column[: row + 1] for name, column in result.truth.items()}
    ground = Ground(world_from_ground=stage.machine.world_from_ground, bodies=stage.bodies)
    passes = worked(past, scenario, ground)
    s_m, t_m, _ = position_w(past)[-1] @ ground.world_from_ground
    seen = Seen(
        s_m=s_m,
        t_m=t_m,
        world_from_ground=ground.world_from_ground,
        heights=stage.machine.maps.get("heights"),
        bodies=stage.bodies,
        furrow_depth_m=scenario.plough.depth_m,
        depth_m=scenario.plough.depth_m,
        cuts=[cut for cut, _ in passes],
        done=[way for _, way in passes],
    )
    stage.eye.azimuth, stage.eye.elevation, stage.eye.distance = VIEW
    stage.look_at_m[:] = LOOK_AT_M
    stage.set(joint_states(model, {name: column[-1:] for name, column in past.items()})[0], seen)
    frame = OffScreen(model, FINER * WIDTH, FINER * HEIGHT)
    large = stage.picture(frame)
    frame.close()
    return cv2.resize(large, (WIDTH, HEIGHT), interpolation=cv2.INTER_AREA)


def slip(result: Result) -> str:
    """Truth against estimates, as SVG."""
    window_s = (18.0, 38.0)
    with mpl.rc_context(LINE):
        figure = Figure(figsize=(8.0, 2.9), layout="constrained")
        axes = figure.add_subplot()
        for name, colour in colours(ESTIMATORS).items():
            table = result.estimates[name]
            time, percent, reach = seconds(table), 100.0 * table["slip"], 200.0 * table["slip_sd"]
            shown = (time >= window_s[0]) & (time <= window_s[1])
            time, percent, reach = time[shown][::2], percent[shown][::2], reach[shown][::2]
            band = (percent - reach, percent + reach)
            axes.fill_between(time, *band, color=colour, alpha=0.15, lw=0)
            axes.plot(time, percent, color=colour, lw=1.0, label=f"{name}, ±2 sd")
        time = seconds(result.truth)
        shown = (time >= window_s[0]) & (time <= window_s[1])
        axes.plot(
            time[shown], 100.0 * result.truth["slip"][shown], color=TRUTH_COLOUR, label="truth"
        )
        axes.set(xlabel="time [s]", ylabel="slip [%]", xlim=window_s)
        axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=3, borderaxespad=0.0)
        text = io.StringIO()
        figure.savefig(text, format="svg", metadata={"Date": None}, facecolor="white")
    return text.getvalue()


if __name__ == "__main__":
    main()
