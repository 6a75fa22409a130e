"""Two estimators while the antennas see no sky for 8 s: `python without_sky.py`.

Writes without_sky.png.
"""

from matplotlib.figure import Figure

import twin
from twin.sensors import Gnss, Outage

START_S, HIDDEN_S = 22.0, 8.0
AVENUE = twin.Scenario(
    name="avenue",
    about="40 m of ploughing past a row of trees",
    plough=twin.Plough(depth_m=0.22),
    course=twin.Course(length_m=40.0),
    sensors=twin.Sensors(
        gnss=Gnss(outages=(Outage(start_s=START_S, duration_s=HIDDEN_S, kind="mask"),))
    ),
)


def main() -> None:
    names = ("four-state", "slip-ekf")
    result = twin.run(AVENUE, estimators=names)
    figure = Figure(figsize=(7.0, 3.2), layout="constrained")
    axes = figure.subplots()
    axes.axvspan(START_S, START_S + HIDDEN_S, color="#dddddd", label="no sky")
    for name, colour in zip(names, ("#0072B2", "#D55E00"), strict=True):
        table = result.estimates[name]
        time_s, slip, reach = 1e-9 * table["epoch_ns"], 100 * table["slip"], 200 * table["slip_sd"]
        axes.fill_between(time_s, slip - reach, slip + reach, color=colour, alpha=0.15, lw=0)
        axes.plot(time_s, slip, color=colour, lw=0.9, label=f"{name}, ±2 sd")
    axes.plot(1e-9 * result.truth["epoch_ns"], 100 * result.truth["slip"], "k", label="truth")
    axes.set(xlabel="time [s]", ylabel="slip [%]", xlim=(10.0, 34.0), ylim=(0.0, 30.0))
    axes.legend(frameon=False, ncols=2)
    figure.savefig("without_sky.png", dpi=150)
    for name, score in result.scores["estimators"].items():
        print(f"{name}: slip RMSE {100 * score['slip']['rmse']:.2f} %")


if __name__ == "__main__":
    main()
