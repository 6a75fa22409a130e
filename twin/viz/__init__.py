"""The picture: everything about rerun is here, entity paths, logging and blueprint.

Entities mirror the frames: `world/truth/tractor/<body>` moves, what does not move is static, truth
and estimates are siblings. Two timelines, `sim_time` and `step`; bulk by `send_columns`.
"""

from twin.viz.ground import Ground
from twin.viz.recording import log, record, view

__all__ = ["Ground", "log", "record", "view"]
