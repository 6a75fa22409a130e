"""Defaults of the rigs; light to import, because the command line reads them."""

from __future__ import annotations

SPEED_MPS = 1.5
"""A wheel's speed over the ground, about that of ploughing [m/s]."""
HITCH_M = 0.45
"""Height of the pull above the ground [m]: that of a drawbar; assumed."""
STEP_N = 500.0
"""Pull from one point to the next [N]."""
SPEEDS_KMH = (4.0, 5.0, 6.0, 7.0, 8.5, 10.0, 12.0, 15.0)
"""Gears by what they run at rated engine speed without slip [km/h]."""
PARKED_S = 60.0
"""How long the tractor is parked [s]."""
