"""What the driver is doing: the phase of a drive, a column of the truth."""

from __future__ import annotations

from enum import IntEnum


class Phase(IntEnum):
    """A phase of a drive, as `truth` has it in its column `phase`."""

    STOP = 0
    """Brought to a stand on purpose, and standing until the driver sets off again."""
    ROAD = 1
    """Driven along a line with the implement raised, or without one."""
    TURN = 2
    """On a headland between two passes, backing up there too."""
    WORK = 3
    """Along a line with the implement lowered, from the moment the driver lowers it."""
