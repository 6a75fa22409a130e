"""What is on the screen when a recording opens."""

from __future__ import annotations

import rerun as rr
import rerun.blueprint as rrb

from twin.streams import Table
from twin.viz.paths import (
    DARK,
    DEPTH,
    DRAFT,
    FOLLOW,
    FURROW,
    PATH,
    SIDESLIP,
    SIM_TIME,
    SKY,
    SLIP,
    SPEED,
    WORLD,
)  # fmt: skip


def simulated(truth: Table) -> rrb.Blueprint:
    """3D view left, riding with the tractor; plots right."""
    eye = rrb.EyeControls3D(
        kind=rrb.Eye3DKind.Orbital,
        position=(5.0, 8.0, 4.0),
        look_target=(-0.7, 0.0, 0.0),
        eye_up=(0.0, 0.0, 1.0),
    )
    past = rrb.VisibleTimeRanges(
        timeline=SIM_TIME,
        start=rrb.TimeRangeBoundary.infinite(),
        end=rrb.TimeRangeBoundary.cursor_relative(),
    )
    scene = rrb.Spatial3DView(
        origin=FOLLOW,
        contents=f"{WORLD}/**",
        name="Field",
        eye_controls=eye,
        background=SKY,
        line_grid=False,
        overrides={PATH: past, FURROW: past},
    )
    return _blueprint(scene, _plots(truth, draft="draft_n" in truth))


def logged(span: Table, geodetic: bool) -> rrb.Blueprint:
    """Map (or plan) left, plots right."""
    place: rrb.View = (
        rrb.MapView(origin="map", name="Map")
        if geodetic
        else rrb.Spatial3DView(origin=WORLD, name="Path", background=SKY)
    )
    return _blueprint(place, _plots(span, draft=False))


def _blueprint(left: rrb.View, right: rrb.Vertical) -> rrb.Blueprint:
    return rrb.Blueprint(
        rrb.Horizontal(left, right, column_shares=[3, 2]),
        rrb.TimePanel(timeline=SIM_TIME, state="collapsed", play_state="playing"),
        rrb.SelectionPanel(state="hidden"),
        rrb.BlueprintPanel(state="hidden"),
        auto_views=False,
    )


def _plots(span: Table, *, draft: bool) -> rrb.Vertical:
    """Time series over the whole span of a table's epochs."""
    panels = [
        (SLIP, "Slip of the driven axle, with ±2 sd", 3),
        (SPEED, "Speed [m/s]", 2),
        (SIDESLIP, "Sideslip at the centre of gravity [m]", 2),
    ]
    if draft:
        panels += [(DRAFT, "Draft [kN]", 2), (DEPTH, "Depth of ploughing [m]", 2)]
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
            name=name,
            axis_x=axis,
            background=background,
            plot_legend=rrb.PlotLegend(visible=entity not in (DRAFT, DEPTH)),
        )
        for entity, name, _ in panels
    ]
    return rrb.Vertical(*views, row_shares=[share for _, _, share in panels])
