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
import mujoco
import numpy as np
from matplotlib.figure import Figure
from scipy.spatial.transform import Rotation

from twin.pipeline.named import load
from twin.pipeline.result import Result
from twin.pipeline.run import run
from twin.report.palette import FIGURE, TRUTH_COLOUR, colours
from twin.scores.scores import seconds
from twin.simulation.build import build
from twin.viz.ground import Ground, slices
from twin.viz.shapes import joint_states
from twin.viz.tools import every

HERE = Path(__file__).parent / "pictures"
ESTIMATORS = ("ratio", "four-state")
WIDTH, HEIGHT = 1280, 640
AT_M = 40.0
"""Where along the course the picture of the tractor is taken."""
SOIL_RGBA, LAND_RGB = (0.36, 0.26, 0.18, 1.0), (0.66, 0.57, 0.44)
SKY_RGB = ((120, 170, 220), (232, 240, 246))
FAR_M, PLOUGHED_M = 300.0, 6.0
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
    machine = build(result.scenario, looks=True, settle=False)  # type: ignore[arg-type]
    model = machine.model
    truth = result.truth
    row = int(np.argmax(truth["east_m"] > AT_M))
    model.vis.global_.offwidth, model.vis.global_.offheight = WIDTH, HEIGHT
    model.vis.quality.offsamples, model.vis.quality.shadowsize = 8, 8192
    model.vis.headlight.ambient[:], model.vis.headlight.diffuse[:] = 0.42, 0.3
    for ground_geom in ("ground", "terrain"):
        model.geom(ground_geom).rgba[:3] = LAND_RGB
    data = mujoco.MjData(model)
    data.qpos[:] = joint_states(model, {k: v[row : row + 1] for k, v in truth.items()})[0]
    mujoco.mj_forward(model, data)
    view = mujoco.MjvCamera()
    view.lookat[:] = data.body("tractor").xpos + np.array([-1.3, -0.2, -0.1])
    view.distance, view.azimuth, view.elevation = 8.8, -36.0, -17.0
    with mujoco.Renderer(model, HEIGHT, WIDTH) as renderer:
        renderer.update_scene(data, camera=view)
        ground = Ground(world_from_ground=machine.world_from_ground, maps=machine.maps)
        past = every({name: column[: row + 1] for name, column in truth.items()}, 2.0)
        _, centre, half_m, xyzw = slices(past, result.scenario, ground)
        turn = Rotation.from_quat(xyzw.reshape(-1, 4)).as_matrix()
        for box in zip(centre.reshape(-1, 3), half_m.reshape(-1, 3), turn, strict=True):
            _add_box(renderer.scene, *box)
        ploughed_m = np.array([AT_M, -0.85 - PLOUGHED_M, 0.0])
        _add_box(renderer.scene, ploughed_m, np.array([80.0, PLOUGHED_M, 0.05]), np.eye(3))
        _add_sun(renderer.scene)
        image: np.ndarray[Any, Any] = renderer.render()
        renderer.enable_depth_rendering()
        far = renderer.render() > FAR_M
    up = np.linspace(1.0, 0.0, HEIGHT)[:, None, None]
    sky = (up * np.array(SKY_RGB[0]) + (1.0 - up) * np.array(SKY_RGB[1])).astype(np.uint8)
    return np.where(far[..., None], sky, image)


def _add_sun(scene: Any) -> None:
    light = scene.lights[scene.nlight]
    light.type = mujoco.mjtLightType.mjLIGHT_DIRECTIONAL
    light.pos[:], light.dir[:] = (AT_M - 10.0, 12.0, 25.0), (0.35, -0.5, -0.8)
    light.ambient[:], light.diffuse[:], light.specular[:] = 0.0, 0.75, 0.2
    light.castshadow = 1
    scene.nlight += 1


def _add_box(scene: Any, centre: Any, half_m: Any, rotation: Any) -> None:
    geom = scene.geoms[scene.ngeom]
    box = mujoco.mjtGeom.mjGEOM_BOX
    mujoco.mjv_initGeom(geom, box, half_m, centre, rotation.ravel(), np.float32(SOIL_RGBA))
    scene.ngeom += 1


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
