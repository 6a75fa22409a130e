"""Paths on the ground: the true one, the one without sideslip, and each estimate's."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import rerun as rr

from twin.report.palette import SEA, colours
from twin.streams import Setup, Streams, Table
from twin.viz.paths import ESTIMATES, GNSS, MAP, NO_SIDESLIP, ORANGE, PATH
from twin.viz.tools import Array, axes_w, every, position_w, rgba, times

WHITE = [255, 255, 255]
PATH_HZ = 5.0
METRES_PER_DEGREE = np.pi / 180.0 * 6_371_000.0


def log_path(recording: rr.RecordingStream, truth: Table, lower_m: float, scale: float) -> None:
    """Where the rear axle goes, laid on the ground; what is behind it is drawn stronger."""
    moments = every(truth, PATH_HZ)
    _, _, up = axes_w(moments)
    centre = (position_w(moments) - lower_m * up).astype(np.float32)
    whole = rr.LineStrips3D([centre], colors=[ORANGE], radii=[0.012 * scale])
    recording.log(f"{PATH}/whole", whole, static=True)
    pieces = np.stack([centre[:-1], centre[1:]], axis=1)  # (n - 1, 2, 3)
    recording.send_columns(
        PATH,
        times({"epoch_ns": moments["epoch_ns"][1:]}),
        rr.LineStrips3D.columns(strips=list(pieces)),
    )
    style = rr.LineStrips3D.from_fields(colors=[ORANGE], radii=[0.04 * scale])
    recording.log(PATH, style, static=True)


def log_no_sideslip(
    recording: rr.RecordingStream, truth: Table, lower_m: float, scale: float
) -> None:
    """Where it would have gone had it gone where it pointed: the integral of v_x ahead."""
    if "v_x_rear_mps" not in truth:
        return
    ahead, _, up = axes_w(truth)
    dt_s = np.diff(truth["epoch_ns"], prepend=truth["epoch_ns"][0]) * 1e-9
    way = np.cumsum(dt_s[:, None] * truth["v_x_rear_mps"][:, None] * ahead, axis=0)
    line = position_w(truth)[:1] + way - lower_m * up
    line = line[:: max(1, len(line) // 2000)].astype(np.float32)
    strip = rr.LineStrips3D([line], colors=[WHITE], radii=[0.015 * scale])
    recording.log(NO_SIDESLIP, strip, static=True)


def log_estimated(
    recording: rr.RecordingStream,
    estimates: Mapping[str, Table],
    streams: Streams,
    truth: Table,
    lower_m: float,
    scale: float,
) -> None:
    """Each estimate's path: its speed along GNSS heading plus its sideslip, from the true start.

    Up and down it follows the truth, so that the lines lie on the ground.
    """
    heading = _heading(streams)
    if heading is None:
        return
    _, _, up = axes_w(truth)
    ground = position_w(truth) - lower_m * up
    for name, colour in colours(estimates).items():
        table = every(estimates[name], PATH_HZ * 2)
        speed = table.get("speed_mps")
        if speed is None or len(speed) < 2:
            continue
        time = table["epoch_ns"].astype(float)
        aside = np.nan_to_num(table.get("sideslip_rear_rad", np.zeros(len(speed))))
        course = np.interp(time, *heading) + aside
        step = np.diff(time, prepend=time[0]) * 1e-9 * np.nan_to_num(speed)
        east = ground[0, 0] + np.cumsum(step * np.cos(course))
        north = ground[0, 1] + np.cumsum(step * np.sin(course))
        up_m = np.interp(time, truth["epoch_ns"].astype(float), ground[:, 2])
        line = np.stack([east, north, up_m + 0.01], axis=1).astype(np.float32)
        strip = rr.LineStrips3D([line], colors=[rgba(colour)], radii=[0.02 * scale])
        recording.log(f"{ESTIMATES}/{name}/path", strip, static=True)


def _heading(streams: Streams) -> tuple[Array, Array] | None:
    """Epochs and unwrapped GNSS heading where it is known; None where it never is."""
    if "gnss" not in streams or "heading_rad" not in streams["gnss"]:
        return None
    gnss = streams["gnss"]
    known = np.isfinite(gnss["heading_rad"])
    if not np.any(known):
        return None
    return gnss["epoch_ns"][known].astype(float), np.unwrap(gnss["heading_rad"][known])


def log_gnss(
    recording: rr.RecordingStream, streams: Streams, truth: Table | None = None, scale: float = 1.0
) -> None:
    """Antenna fixes as points, thinned; those before the run are left out."""
    if "gnss" not in streams or "east_m" not in streams["gnss"]:
        return
    fixes = every(streams["gnss"], 2.0)
    up_m = fixes.get("up_m", np.zeros(len(fixes["epoch_ns"])))
    points = np.stack([fixes["east_m"], fixes["north_m"], up_m], axis=1)
    kept = np.isfinite(points).all(axis=1)
    if truth:
        kept &= fixes["epoch_ns"] >= truth["epoch_ns"][0]
    if not np.any(kept):
        return
    shown = rr.Points3D.columns(positions=points[kept].astype(np.float32))
    recording.send_columns(GNSS, times({"epoch_ns": fixes["epoch_ns"][kept]}), shown)
    style = rr.Points3D.from_fields(colors=[rgba(SEA)], radii=[0.04 * scale])
    recording.log(GNSS, style, static=True)


def log_map(recording: rr.RecordingStream, streams: Streams, setup: Setup) -> None:
    """The drive on a map, and where it is now: small angles about the origin, on a sphere."""
    assert setup.origin is not None
    fixes = every(streams["gnss"], 1.0)
    latitude_deg = setup.origin[0] + fixes["north_m"] / METRES_PER_DEGREE
    shrink = np.cos(np.radians(setup.origin[0]))
    longitude_deg = setup.origin[1] + fixes["east_m"] / (METRES_PER_DEGREE * shrink)
    line = np.stack([latitude_deg, longitude_deg], axis=1)
    known = np.isfinite(line).all(axis=1)
    strip = rr.GeoLineStrings(
        lat_lon=[line[known]], colors=[rgba(SEA)], radii=[rr.Radius.ui_points(1.2)]
    )
    recording.log(MAP, strip, static=True)
    here = times({"epoch_ns": fixes["epoch_ns"][known]})
    recording.send_columns(f"{MAP}/now", here, rr.GeoPoints.columns(positions=line[known]))
    style = rr.GeoPoints.from_fields(colors=[ORANGE], radii=[rr.Radius.ui_points(7.0)])
    recording.log(f"{MAP}/now", style, static=True)
