"""A made-up drive whose sensors are noisier or better than its data sheet says."""

import dataclasses

import numpy as np

from twin.logs import Log
from twin.pipeline.tuned import scaled_setup, scaled_streams
from twin.testing import drives

SETUP = drives.setup()


def accelerating(t):
    """Speed with the white jerk of four-state, about: sines with 1 / f^2, 1.6 m/s on average."""
    phases = np.random.default_rng(5).uniform(0.0, 2.0 * np.pi, 60)
    hz = 0.02 + 0.05 * np.arange(60)
    sines = np.sin(2.0 * np.pi * np.multiply.outer(np.asarray(t), hz) + phases)
    return 1.6 + sines @ (0.05 / (1.0 + (hz / 0.3) ** 2))


DRIVE = drives.Drive(duration_s=100.0, speed=accelerating, slip=lambda t: 0.12 + 0.0 * t)


def log(told=1.0, seed=1, drive=DRIVE):
    """The log, with an sd of GNSS velocity told that is so many times the true one."""
    streams = drives.streams(drive, SETUP, seed)
    factors = {"gnss_velocity": told}
    return Log(setup=scaled_setup(SETUP, factors), streams=scaled_streams(streams, factors))


def slip_rmse(estimator, of, drive=DRIVE):
    """Error of slip on the second half."""
    _, table = estimator.run(estimator.init(of.setup), of.streams)
    t = drives.seconds(table["epoch_ns"])
    error = (table["slip"] - drive.slip(t))[t > 0.5 * drive.duration_s]
    return float(np.sqrt(np.nanmean(error**2)))


def reference(drive=DRIVE):
    """The true slip as a log's reference."""
    epoch_ns = drives.stamps(drives.times(drive, 10.0))["epoch_ns"]
    return {"epoch_ns": epoch_ns, "slip": drive.slip(drives.seconds(epoch_ns))}


def without(of, *sensors):
    rest = {s: t for s, t in of.streams.tables.items() if s not in sensors}
    return dataclasses.replace(of, streams=dataclasses.replace(of.streams, tables=rest))
