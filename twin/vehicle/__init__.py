"""Description of a machine and an implement: typed, read from files, completed by stated rules."""

from twin.vehicle.implement import Implement
from twin.vehicle.machine import Machine

__all__ = ["Implement", "Machine"]
