"""An NMEA 0183 file as a Log."""

from __future__ import annotations

import math
from pathlib import Path

from twin.errors import BadInput
from twin.logs.build import assemble
from twin.logs.column_map import ColumnMap
from twin.logs.gaps import gap_notes
from twin.logs.log import Log
from twin.logs.nmea import read_nmea
from twin.logs.plausible import check_plausible
from twin.logs.quantities import GNSS
from twin.logs.reader import Reader

_COMPASS = ("course_rad", "heading_rad")


class Nmea(Reader):
    """Reads NMEA 0183. The format says what each value is, so a map needs only `[setup]`."""

    name = "NMEA"

    def fits(self, path: Path, head: bytes) -> bool:
        """By how its first sentence begins, or its suffix."""
        named = path.suffix.lower() in (".nmea", ".nme")
        return not path.is_dir() and (named or head.lstrip().startswith((b"$", b"!")))

    def read(self, path: Path, column_map: ColumnMap | None) -> Log:
        """Its Log; of the map only [setup] can apply. Raises BadInput."""
        columns_of = column_map or ColumnMap()
        if columns_of.time or columns_of.columns or columns_of.labels or columns_of.rules:
            raise BadInput(
                "NMEA 0183 names its own quantities; only [setup] can be in its column map"
            )
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
        notes += gap_notes("log", epoch_ns)
        return assemble({"gnss": {"epoch_ns": epoch_ns, **values}}, {}, columns_of, notes)
