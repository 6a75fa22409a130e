"""The baselines of Plough-v0 with their gains, all tuned with one budget."""

from __future__ import annotations

from twin.control.controllers import PI, Constant, Controller, ScheduledPI, SlidingMode
from twin.control.draft_mix import DraftMix
from twin.control.extremum import ExtremumSeeking
from twin.control.predictive import PredictiveSlip

BASELINES: dict[str, Controller] = {
    "constant": Constant(throttle=0.987, trim_m=-0.0785),
    "pi": PI(throttle=0.99, trim_m=-0.0401, kp_m=2.77, ki_mps=0.0578),
    "scheduled-pi": ScheduledPI(
        throttle=0.949, trim_m=-0.0179, kp_m=3.52, ki_mps=0.215, rate=0.667
    ),
    "sliding-mode": SlidingMode(
        throttle=0.77, trim_m=-0.00532, reach_m=0.119, surface_radps=0.188, layer=0.023
    ),
    "draft-mix": DraftMix(
        throttle=0.718, trim_m=-0.0592, mix=0.232, held_n=2.39e4, sensitivity_m=0.0441
    ),
    "extremum": ExtremumSeeking(
        throttle=0.959, trim_m=-0.0724, dither_m=0.0192, dither_radps=5.8, seek_mps=1.51
    ),
    "mpc": PredictiveSlip(
        throttle=0.869, trim_m=-0.0459, slip_weight=3.03, move_weight=2.32, learn_s=0.35
    ),
}
"""Gains found by `python -m twin.control.tune Plough-v0`; their mean rewards on its grounds are
0.7846, 0.7942, 0.7923, 0.7839, 0.7764, 0.7806, 0.7849 in this order."""
