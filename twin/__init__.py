"""A digital twin of a tractor and plough, for those who estimate wheel slip and sideslip.

    import twin

    result = twin.run("plough-25cm", estimators=["ratio", "four-state"])
    print(result.scores["estimators"]["ratio"]["slip"]["rmse"])
    result.save("runs/first")

Names are imported when they are first used, so `import twin` costs nothing.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from twin import errors as errors
    from twin import testing as testing
    from twin.calibration.calibrate import calibrate as calibrate
    from twin.pipeline.estimating import Estimator as Estimator
    from twin.pipeline.public import estimate as estimate
    from twin.pipeline.public import load as load
    from twin.pipeline.public import run as run
    from twin.pipeline.result import Result as Result
    from twin.scenario import Course as Course
    from twin.scenario import Drive as Drive
    from twin.scenario import Driver as Driver
    from twin.scenario import Event as Event
    from twin.scenario import Field as Field
    from twin.scenario import Plough as Plough
    from twin.scenario import Scenario as Scenario
    from twin.scenario import Soil as Soil
    from twin.sensors import Sensors as Sensors
    from twin.studies.study import study as study
    from twin.tuning.tune import tune as tune
    from twin.vehicle import Implement as Implement
    from twin.vehicle import Machine as Machine

_HOME = {
    "load": "twin.pipeline.public",
    "run": "twin.pipeline.public",
    "estimate": "twin.pipeline.public",
    "study": "twin.studies.study",
    "tune": "twin.tuning.tune",
    "calibrate": "twin.calibration.calibrate",
    "Result": "twin.pipeline.result",
    "Estimator": "twin.pipeline.estimating",
    "Scenario": "twin.scenario",
    "Soil": "twin.scenario",
    "Field": "twin.scenario",
    "Plough": "twin.scenario",
    "Drive": "twin.scenario",
    "Driver": "twin.scenario",
    "Event": "twin.scenario",
    "Course": "twin.scenario",
    "Sensors": "twin.sensors",
    "Machine": "twin.vehicle",
    "Implement": "twin.vehicle",
}
"""Public name -> the module that defines it."""
_MODULES = ("errors", "testing")

__all__ = [
    "Course", "Drive", "Driver", "Estimator", "Event", "Field", "Implement", "Machine", "Plough",
    "Result", "Scenario", "Sensors", "Soil", "calibrate", "errors", "estimate", "load",
    "run", "study", "testing", "tune",
]  # fmt: skip


def __getattr__(name: str) -> object:
    if name in _MODULES:
        return import_module(f"twin.{name}")
    if name in _HOME:
        return getattr(import_module(_HOME[name]), name)
    raise AttributeError(f"module 'twin' has no attribute '{name}'; it has: {', '.join(__all__)}")


def __dir__() -> list[str]:
    return __all__
