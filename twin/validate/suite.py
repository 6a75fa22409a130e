"""All checks by layer."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from joblib import delayed

from twin.compute.parallel import many
from twin.validate import (
    analytic,
    catalogue,
    downhill,
    field,
    fuel,
    handling,
    instruments,
    numerical,
    roll,
    slides,
    small_wheel,
    terrain,
    traction,
)
from twin.validate.check import Check

LAYERS = {
    "analytic": "Analytic: the whole tractor against mechanics",
    "table": "Laws against print, and against one test of a wheel and one of an engine",
    "laws": "Law against law",
    "field": "Whole machine against measurements in fields and on hard roads",
    "numerical": "Numerical: step, order, rest, seeds, a wheel's power balance, uneven ground",
    "prediction": "Prediction: one part left out of the fit",
    "sensors": "Sensors against data sheets and one real receiver",
}
"""Layer -> its title, in the order of the page."""
TASKS: tuple[tuple[str, Callable[[], list[Check]]], ...] = (
    ("analytic", analytic.static_loads),
    ("analytic", analytic.coast_down),
    ("analytic", analytic.drawbar_pull),
    ("analytic", analytic.crab_angle),
    ("analytic", analytic.parking),
    ("analytic", downhill.downhill),
    ("analytic", handling.yaw_response),
    ("analytic", roll.roll_mode),
    ("table", traction.brixius_table),
    ("table", traction.top_efficiency),
    ("table", traction.towed_wheel),
    ("table", traction.bekker_arc),
    ("table", small_wheel.small_wheel),
    ("table", fuel.half_load),
    ("laws", traction.law_against_law),
    ("field", field.drawbar_power),
    ("field", catalogue.deere),
    ("field", catalogue.large),
    ("field", catalogue.yemen),
    ("field", catalogue.korea),
    ("field", catalogue.ballast),
    ("field", slides.slides_set),
    ("prediction", slides.slide_left_out),
    ("numerical", numerical.halved_step),
    ("numerical", numerical.order_of_accuracy),
    ("numerical", numerical.settling),
    ("numerical", numerical.seeds),
    ("numerical", numerical.dissipation),
    ("numerical", terrain.spectrum),
    ("numerical", terrain.tilted_map),
    ("sensors", instruments.inertial),
    ("sensors", instruments.receiver),
    ("sensors", instruments.stopped),
)


def of_machine(machine: str, *, jobs: int = 1) -> dict[str, list[Check]]:
    """What mechanics asks of any machine; by layer. Its loads, pull, crab angle and parking."""
    tasks = (analytic.static_loads, analytic.drawbar_pull, analytic.crab_angle, analytic.parking)
    found = many([delayed(task)(machine) for task in tasks], jobs)
    return {"analytic": [check for of_task in found for check in of_task]}


def checks(*, jobs: int = 1, quick: bool = False) -> dict[str, list[Check]]:
    """Run every check; by layer, in the order of the page.

    Args:
        jobs: processes; -1 for one a core.
        quick: one seed of each field run instead of many; the same rows, with more scatter.
    """
    if quick:  # few seeds: beside the other tasks, not split among the processes
        whole = [delayed(field.ploughing)(1, True), delayed(field.structure)(1, True)]
        ploughed, slips, *measured = many([*whole, *_tasks()], jobs)
    else:
        measured = many(_tasks(), jobs)
        ploughed, slips = field.ploughing(jobs, False), field.structure(jobs, False)
    out: dict[str, list[Check]] = {layer: [] for layer in LAYERS}
    for (layer, _), found in zip(TASKS, measured, strict=True):
        out[layer] += found
    for layer, found in ploughed.items():
        out[layer] += found
    out["prediction"] += slips
    return out


def _tasks() -> list[Any]:
    return [delayed(task)() for _, task in TASKS]
