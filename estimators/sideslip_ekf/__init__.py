"""Sideslip from a downward camera, GNSS, gyro and wheels, with mounting errors estimated.

plane    the ground plane against the horizontal
tilt     which way is up in it
model    state, prediction, and what each sensor says
filter   samples in order of their epochs; the estimator
"""

from estimators.sideslip_ekf.filter import SideslipEkf

__all__ = ["SideslipEkf"]
