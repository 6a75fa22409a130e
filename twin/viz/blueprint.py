"""What is on the screen when a recording opens: a view for each kind of run."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from twin.plugins.lookup import Thing
from twin.streams import Setup, Streams, Table
from twin.viz.events import FIXED
from twin.viz.paths import (
    ACCELERATION,
    ACTIONS,
    CAMERA,
    DARK,
    DEPTH,
    DRAFT,
    EVENTS,
    FIX,
    FOLLOW,
    FURROW,
    GNSS,
    GYRO,
    LAND,
    LOADS,
    PATH,
    POWER,
    REWARD,
    SENSED_DEPTH,
    SENSED_SPEED,
    SIDESLIP,
    SIM_TIME,
    SKY,
    SLIP,
    SPEED,
    STEP,
    WHEELS,
    WORLD,
)

Panel = tuple[str, str, int]
"""Entity, title, share of the height."""

SLIP_PANEL: Panel = (SLIP, "Slip of the driven axle, ±2 sd", 4)
SIDESLIP_PANEL: Panel = (SIDESLIP, "Sideslip at the centre of gravity [m], ±2 sd", 3)
SPEED_PANEL: Panel = (SPEED, "Speed [m/s]", 3)
FIX_PANEL: Panel = (FIX, "GNSS: quality and satellites", 2)
CONTROL: tuple[Panel, ...] = ((ACTIONS, "Actions", 1), (REWARD, "Terms of the reward", 1))
KINDS: dict[str, tuple[Panel, ...]] = {
    "ploughing": (SLIP_PANEL, SPEED_PANEL, (DRAFT, "Draft [kN]", 2), (DEPTH, "Depth [m]", 2)),
    "ploughing a slope": (SLIP_PANEL, SIDESLIP_PANEL, SPEED_PANEL, (DRAFT, "Draft [kN]", 2)),
    "slope": (SIDESLIP_PANEL, SLIP_PANEL, SPEED_PANEL),
    "masked": (FIX_PANEL, SLIP_PANEL, SIDESLIP_PANEL, SPEED_PANEL),
    "road": (SLIP_PANEL, SPEED_PANEL, SIDESLIP_PANEL),
    "log": (SLIP_PANEL, SPEED_PANEL, FIX_PANEL),
}


def kind(truth: Table, streams: Streams, scenario: Thing) -> str:
    """Which view suits a run: masked before ploughing before slope before road."""
    if _lost_fix(truth, streams):
        return "masked"
    steep = abs(getattr(getattr(scenario, "field", None), "cross_slope_deg", 0.0)) > 1.0
    if np.any(truth.get("depth_m", np.zeros(1)) > 0.0):
        return "ploughing a slope" if steep else "ploughing"
    return "slope" if steep else "road"


def simulated(
    truth: Table,
    streams: Streams,
    setup: Setup,
    scenario: Thing,
    *,
    frames: bool,
    control: bool = False,
) -> rrb.Blueprint:
    """3D view left, riding with the tractor; what matters for this kind of run right.

    With control, actions and reward are plotted in place of what the sensors gave.
    """
    which = kind(truth, streams, scenario)
    scale = setup.wheelbase_m / 2.55
    behind = which == "slope"
    eye = rrb.EyeControls3D(
        kind=rrb.Eye3DKind.Orbital,
        position=tuple(scale * c for c in ((-8.0, 1.5, 3.2) if behind else (-7.2, 6.0, 3.6))),
        look_target=tuple(scale * c for c in ((1.2, 0.0, 0.0) if behind else (-0.6, 0.0, 0.0))),
        eye_up=(0.0, 0.0, 1.0),
    )
    past, to_come = _seen("past"), _seen("to come")
    scene: rrb.View = rrb.Spatial3DView(
        origin=FOLLOW,
        contents=f"{WORLD}/**",
        name="Field",
        eye_controls=eye,
        background=SKY,
        line_grid=False,
        overrides={PATH: past, FURROW: past, LAND: to_come, GNSS: past},
    )
    left: list[Any] = [scene, rrb.TextLogView(origin=EVENTS, name="Events")]
    if frames:
        left[1] = rrb.Horizontal(rrb.Spatial2DView(origin=CAMERA, name="Camera"), left[1])
    sensed = (
        (SENSED_SPEED, "Speeds as sensed [m/s]", 3),
        FIX_PANEL,
        (GYRO, "Rates [rad/s]", 2),
        (ACCELERATION, "Accelerations [m/s²]", 2),
        *(((SENSED_DEPTH, "Depth as sensed [m]", 2),) if setup.depth else ()),
    )
    tabs = rrb.Tabs(
        _plots(KINDS[which], truth, "Estimates"),
        _plots(
            CONTROL if control else sensed, truth, "Control" if control else "Sensors", legends=True
        ),
        _plots(
            (
                (WHEELS, "Slip of each wheel", 1),
                (LOADS, "Wheel loads [kN]", 1),
                (POWER, "Power [kW]", 1),
            ),
            truth,
            "Machine",
            legends=True,
        ),
        active_tab=0,
    )
    shares = [3, 1] if frames else [5, 1]
    return _blueprint(rrb.Vertical(*left, row_shares=shares), tabs)


def logged(span: Table, setup: Setup, geodetic: bool) -> rrb.Blueprint:
    """Map (or plan) left, plots right."""
    place: rrb.View = (
        rrb.MapView(origin="map", name="Map")
        if geodetic
        else rrb.Spatial3DView(origin=WORLD, name="Path", background=SKY)
    )
    sensed = ((SENSED_SPEED, "Speeds as sensed [m/s]", 3), FIX_PANEL)
    panels = KINDS["log"] if setup.gnss is None else (SLIP_PANEL, SPEED_PANEL, sensed[0])
    tabs = rrb.Tabs(
        _plots(panels, span, "Estimates"),
        _plots(sensed, span, "Sensors", legends=True),
        active_tab=0,
    )
    left = rrb.Vertical(place, rrb.TextLogView(origin=EVENTS, name="Events"), row_shares=[5, 1])
    return _blueprint(left, tabs)


def _seen(what: str) -> rrb.VisibleTimeRanges:
    """All that was logged before now, or all that is logged after; on both timelines."""
    now, end = rrb.TimeRangeBoundary.cursor_relative(), rrb.TimeRangeBoundary.infinite()
    start, stop = (end, now) if what == "past" else (now, end)
    ranges = [rrb.VisibleTimeRange(timeline=t, start=start, end=stop) for t in (SIM_TIME, STEP)]
    return rrb.VisibleTimeRanges(ranges)


def _lost_fix(truth: Table, streams: Streams) -> bool:
    """Whether the receiver had no fix at some time in the run."""
    if "gnss" not in streams or "quality" not in streams["gnss"]:
        return False
    gnss = streams["gnss"]
    return bool(np.any(gnss["quality"][gnss["epoch_ns"] >= truth["epoch_ns"][0]] != FIXED))


def _blueprint(left: Any, right: Any) -> rrb.Blueprint:
    """It opens at the end, where all that happened can be seen; playing begins at the start."""
    return rrb.Blueprint(
        rrb.Horizontal(left, right, column_shares=[3, 2]),
        rrb.TimePanel(timeline=SIM_TIME, state="collapsed", play_state="following"),
        rrb.SelectionPanel(state="hidden"),
        rrb.BlueprintPanel(state="hidden"),
        auto_views=False,
    )


def _plots(
    panels: tuple[Panel, ...], span: Mapping[str, Any], name: str, *, legends: bool = False
) -> rrb.Vertical:
    """Time series over the whole span of a table's epochs; without a legend where colours do."""
    first_s, last_s = (float(span["epoch_ns"][i]) * 1e-9 for i in (0, -1))
    axis = rrb.TimeAxis(
        view_range=rr.TimeRange(
            start=rr.TimeRangeBoundary.absolute(seconds=first_s),
            end=rr.TimeRangeBoundary.absolute(seconds=last_s),
        )
    )
    background = rrb.archetypes.PlotBackground(color=DARK)
    views = [
        rrb.TimeSeriesView(
            origin=entity,
            name=title,
            axis_x=axis,
            background=background,
            plot_legend=rrb.PlotLegend(
                corner=rrb.Corner2D.RightTop if entity == FIX else rrb.Corner2D.RightBottom,
                visible=legends or entity in (SLIP, FIX),
            ),
        )
        for entity, title, _ in panels
    ]
    return rrb.Vertical(*views, row_shares=[share for _, _, share in panels], name=name)
