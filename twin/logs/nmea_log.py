"""An NMEA 0183 file as a Log."""

from __future__ import annotations

import math
from pathlib import Path

from twin.errors import BadInput
from twin.logs.build import assemble
from twin.logs.column_map import ColumnMap
from twin.logs.log import Log
from twin.logs.nmea import read_nmea
from twin.logs.plausible import check_plausible
from twin.logs.quantities import GNSS

_COMPASS = ("course_rad", "heading_rad")


def read_nmea_log(path: Path, columns_of: ColumnMap) -> Log:
    """The Log of an NMEA 0183 file; of the map only [setup] can apply. Raises BadInput."""
    if columns_of.time or columns_of.columns or columns_of.labels or columns_of.rules:
        raise BadInput("NMEA 0183 names its own quantities; only [setup] can be in its column map")
    epoch_ns, values, notes = read_nmea(path)
    for quantity in GNSS.values():
        if quantity.column in values:
            check_plausible(quantity, quantity.column, "SI", 1.0, values[quantity.column])
    for name in _COMPASS:
        if name in values:
            values[name] = math.pi / 2 - values[name]
    if "speed_mps" in values and not set(_COMPASS) & set(values):
        del values["speed_mps"]
        notes.append("gnss: speed without any course left out")
    return assemble(epoch_ns, {"gnss": values}, {}, columns_of, notes)
