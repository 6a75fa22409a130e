"""Controllers by name: a baseline, your own `module:Name`, or the file of a saved policy."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from twin.control import own, saved
from twin.control.controllers import Controller
from twin.control.own import AnyController, ControllerSetup
from twin.control.trials import ENVIRONMENTS
from twin.errors import BadInput, UnknownName
from twin.plugins.lookup import attribute, instance


def by_name(specs: str, setup: ControllerSetup) -> dict[str, AnyController]:
    """Controllers from `pi,mine:Mine,policy.zip`, by the names that tables give them.

    Args:
        specs: separated by commas.
        setup: of where they drive; see `twin.control.own.setup_of`.

    Raises:
        UnknownName: there is no such baseline.
        BadInput: a module or a file cannot be used, two have one name, or none is named.
    """
    found: dict[str, AnyController] = {}
    for spec in filter(None, (part.strip() for part in specs.split(","))):
        name = Path(spec).stem if spec.endswith(saved.SUFFIX) else spec
        if name in found:
            raise BadInput(f"two controllers are called '{name}'; name each once")
        found[name] = controller(spec, setup)
    if not found:
        raise BadInput("--controllers is empty; " + _known(ENVIRONMENTS[setup.environment][1]))
    return found


def controller(spec: str, setup: ControllerSetup) -> AnyController:
    """One controller by its name; a class is made into an instance. Raises as `by_name` does."""
    if spec.endswith(saved.SUFFIX):
        return saved.load(Path(spec), setup)
    baselines: Mapping[str, Controller] = ENVIRONMENTS[setup.environment][1]
    if ":" in spec:
        mine: AnyController = instance("controller", spec, attribute("controller", spec))
        own.drives_one(mine, spec)
        return mine
    if spec in baselines:
        return baselines[spec]
    if Path(f"{spec}.py").is_file():
        raise BadInput(f"no controller is called '{spec}'; of {spec}.py say what, as {spec}:Name")
    raise UnknownName("controller", spec, baselines)


def _known(baselines: Mapping[str, Controller]) -> str:
    return (
        f"there are {', '.join(baselines)}, module:Name of your own, and saved policies, FILE.zip"
    )
