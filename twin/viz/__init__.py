"""Recordings for the rerun viewer: entity paths, logging, and the layout of the screen.

Each body of the tractor is an entity with its pose, `world/truth/tractor/<body>`; what does not
move is static. `world/truth` and `world/estimates` have the same parent. The timelines are
`sim_time` [s] and `step`, the number of the physics step. Time series are sent by `send_columns`.
"""

from twin.viz.ground import Ground
from twin.viz.recording import log, record, view

__all__ = ["Ground", "log", "record", "view"]
