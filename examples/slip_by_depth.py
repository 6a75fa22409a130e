"""Slip against draft at four depths on your own soil: `python slip_by_depth.py`.

Writes slip_by_depth.png.
"""

from dataclasses import replace

import numpy as np
from matplotlib.figure import Figure

import twin

FIELD = twin.Scenario(
    name="stiff-clay",
    about="30 m of firm ground that is heavier to turn in some places than in others",
    soil=twin.Soil(preset="firm", draft_cv=0.15),
    course=twin.Course(length_m=30.0),
)


def main() -> None:
    figure = Figure(figsize=(6.0, 3.6), layout="constrained")
    axes = figure.subplots()
    for depth_m in (0.10, 0.15, 0.20, 0.25):
        plough = twin.Plough(depth_m=depth_m)
        truth = twin.run(replace(FIELD, plough=plough), estimators=[]).truth
        deep = truth["ploughing"]
        draft_kn, slip = 1e-3 * truth["draft_n"][deep], 100 * truth["slip"][deep]
        axes.plot(draft_kn, slip, ".", ms=3, label=f"{100 * depth_m:.0f} cm")
        print(f"{100 * depth_m:.0f} cm: {np.mean(draft_kn):.1f} kN, slip {np.mean(slip):.1f} %")
    axes.set(xlabel="draft [kN]", ylabel="slip [%]")
    axes.legend(frameon=False)
    figure.savefig("slip_by_depth.png", dpi=150)


if __name__ == "__main__":
    main()
