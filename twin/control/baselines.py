"""The baselines of Plough-v0 with their gains, all tuned with one budget."""

from __future__ import annotations

from twin.control.controllers import PI, Constant, Controller, ScheduledPI, SlidingMode
from twin.control.draft_mix import DraftMix
from twin.control.extremum import ExtremumSeeking
from twin.control.predictive import PredictiveSlip

BASELINES: dict[str, Controller] = {
    "constant": Constant(throttle=0.997, trim_m=-0.0645),
    "pi": PI(throttle=0.958, trim_m=-0.0288, kp_m=3.78, ki_mps=0.0612),
    "scheduled-pi": ScheduledPI(throttle=0.998, trim_m=-0.0252, kp_m=3.95, ki_mps=0.137, rate=12.4),
    "sliding-mode": SlidingMode(
        throttle=0.971, trim_m=-0.0557, reach_m=0.113, surface_radps=0.0575, layer=0.236
    ),
    "draft-mix": DraftMix(throttle=0.9, trim_m=-0.05, mix=0.3, held_n=30000.0, sensitivity_m=0.1),
    "extremum": ExtremumSeeking(
        throttle=0.9, trim_m=-0.05, dither_m=0.01, dither_radps=2.0, seek_mps=0.2
    ),
    "mpc": PredictiveSlip(
        throttle=0.9, trim_m=-0.05, slip_weight=1.0, move_weight=1.0, learn_s=0.5
    ),
}
"""Gains found by `python -m twin.control.tune Plough-v0` with an earlier contact law; their mean
rewards on the training grounds are now 0.7864, 0.7971, 0.7945, 0.7879 in this order."""
