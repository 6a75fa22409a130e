"""Sensors: from a part of the true trajectory to the samples that real sensors would give.

`camera`, `depth`, `gnss`, `imu`, `machine` and `wheels` each define one sensor: a frozen
configuration, `init(config, seed, start_ns) -> state` and
`sample(config, state, chunk) -> (state, Table)`. A chunk is a part of the true trajectory. `suite`
runs all sensors, and `nominal` makes the `Setup` that estimators receive. A user's sensor is a
subclass of `Sensor` (`docs/your-own-sensor.md`). It can use the functions that the twin's sensors
use: `reader`, `read`, `arrivals` and `generator`.
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
