"""Sensors: from a chunk of trajectory to the samples a real machine's would give.

Each module turns noise-free quantities into one sensor's stream: a frozen configuration, and
`init(config, seed, start_ns) -> state`, `sample(config, state, chunk) -> (state, Table)`.
`suite` runs them together, `nominal` makes the set-up of the estimators. Your own sensor
is a subclass of `Sensor` (`docs/your-own-sensor.md`); `reader`, `read`, `arrivals` and `generator`
are what the others are made of.
"""

from twin.sensors.camera import Camera
from twin.sensors.checks import Range
from twin.sensors.depth import Depth
from twin.sensors.faults import Fault
from twin.sensors.fix import Outage
from twin.sensors.gnss import Gnss
from twin.sensors.imu import Imu
from twin.sensors.machine import Bus
from twin.sensors.noise import generator
from twin.sensors.nominal import Geometry, setup
from twin.sensors.own import Column, Sensor
from twin.sensors.sampling import arrivals, read, reader
from twin.sensors.suite import Sensors, SuiteState, faults_from, ideal, init, sample
from twin.sensors.wheels import Wheels

__all__ = [
    "Bus",
    "Camera",
    "Column",
    "Depth",
    "Fault",
    "Geometry",
    "Gnss",
    "Imu",
    "Outage",
    "Range",
    "Sensor",
    "Sensors",
    "SuiteState",
    "Wheels",
    "arrivals",
    "faults_from",
    "generator",
    "ideal",
    "init",
    "read",
    "reader",
    "sample",
    "setup",
]
