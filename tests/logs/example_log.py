"""A small good CSV log and its column map, for tests to bend."""

from __future__ import annotations

from pathlib import Path

HEADER = "t,lat,lon,v,hdg,wheel,state"

MAP = """
[log]
time = {column = "t", unit = "s"}
[gnss]
latitude = {column = "lat", unit = "deg"}
longitude = {column = "lon", unit = "deg"}
speed = {column = "v", unit = "m/s"}
heading = {column = "hdg", unit = "deg", convention = "compass"}
[wheels]
driven_speed = {column = "wheel", unit = "km/h"}
[rows]
state = {column = "state"}
[zero_slip]
where = {state = ["M"]}
min_speed_kmh = 5.0
[steady]
where = {state = ["W"]}
min_speed_kmh = 2.5
max_speed_change_kmhps = 0.15
[setup]
machine = "test tractor"
wheelbase_m = 2.5
"""


def rows(n: int = 30) -> list[list[str]]:
    """`n` rows at 1 Hz, heading east at 2 m/s, wheels at 7.5 km/h, half of them M and half W."""
    return [
        [str(i), "45.0", f"{11.0 + i * 2.5e-5:.7f}", "2.0", "90.0", "7.5", "MW"[i >= n // 2]]
        for i in range(n)
    ]


def write(folder: Path, cells: list[list[str]] | None = None, header: str = HEADER) -> Path:
    """The log as a file in `folder`."""
    path = folder / "log.csv"
    lines = [header, *(",".join(row) for row in (rows() if cells is None else cells))]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def write_map(folder: Path, text: str = MAP) -> Path:
    """The column map as a file in `folder`."""
    path = folder / "map.toml"
    path.write_text(text, encoding="utf-8")
    return path
