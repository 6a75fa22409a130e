"""The packages as a whole: what they export, what they find, and which way their imports point."""

from __future__ import annotations

import importlib
import pkgutil
import re
import shutil
import subprocess
import sys
import tomllib
from importlib import metadata
from pathlib import Path
from typing import Any

import pytest

import estimators
import scenarios
import twin
from scenarios.ima_pkf import Trial
from twin.pipeline import named as registry
from twin.scenario import Scenario
from twin.vehicle import files

ROOT = Path(__file__).parents[1]
PACKAGES = (twin, scenarios, estimators)
MODULES = sorted(
    found.name
    for package in PACKAGES
    for found in pkgutil.walk_packages(package.__path__, package.__name__ + ".")
    if not found.name.endswith("__main__")
)

NEEDED = {"twin.env.sb3": "stable_baselines3"}
"""What a module cannot be imported without, where that comes with an extra."""


@pytest.mark.parametrize("name", MODULES)
def test_every_module_imports_and_has_the_names_it_exports(name: str) -> None:
    if name in NEEDED:
        pytest.importorskip(NEEDED[name])
    module = importlib.import_module(name)
    exported = getattr(module, "__all__", [])
    assert [n for n in exported if not hasattr(module, n)] == []
    assert list(exported) == sorted(set(exported), key=list(exported).index)
    assert module.__doc__, f"{name} does not say what it is"


@pytest.mark.parametrize("package", PACKAGES)
def test_every_package_is_typed(package: Any) -> None:
    assert (Path(package.__file__).parent / "py.typed").exists()


@pytest.mark.parametrize("name", scenarios.REGISTRY)
def test_every_registered_scenario_loads_under_its_name(name: str) -> None:
    scenario = registry.load("scenario", name)
    assert isinstance(scenario, (Scenario, Trial))
    assert scenario.name == name


def test_every_file_of_the_models_is_found_by_its_name() -> None:
    assert files.models_folder().samefile(ROOT / "models")
    names = {p.stem for p in ROOT.glob("models/catalogue/*.toml")}
    assert {files.machine(name).name for name in files.machine_names()} == names
    tools = {p.stem for p in ROOT.glob("models/implements/*.toml")} | {"none"}
    assert {files.implement(name).name for name in files.implement_names()} == tools


@pytest.mark.parametrize("name", ["taishan_1404a", "electric_tractor"])
def test_a_hand_made_model_is_found_behind_its_file(name: str) -> None:
    path = files.mjcf_path(files.machine(name))
    assert path is not None
    assert path.samefile(ROOT / "models" / name / f"{name}.xml")


def test_every_console_script_leads_to_a_function() -> None:
    scripts = metadata.distribution("tractor-twin").entry_points.select(group="console_scripts")
    assert {script.name for script in scripts} == {"twin"}
    assert all(callable(script.load()) for script in scripts)


def test_as_a_module_it_is_the_same_command() -> None:
    command = [sys.executable, "-m", "twin", "rum"]
    done = subprocess.run(command, capture_output=True, text=True, cwd=ROOT)
    assert done.returncode == 2
    assert done.stderr.startswith("twin: no command is called 'rum'")


def test_the_long_line_names_its_pieces_when_asked_for_another() -> None:
    done = subprocess.run(["bash", ROOT / ".ci" / "long", "nought"], capture_output=True, text=True)
    assert done.returncode == 2
    assert done.stderr.startswith("no piece is called 'nought'; there are: tests wheel validate")


BREACHES = {
    "estimators/kalman.py": ("twin.truth.truth", "estimators.kalman -> twin.truth.truth"),
    "estimators/lag.py": ("twin.errors", "estimators.lag -> twin.errors"),
    "estimators/ratio.py": ("mujoco", "estimators.ratio -> mujoco"),
    "scenarios/plough.py": ("twin.machine.build", "scenarios.plough -> twin.machine.build"),
    "scenarios/road.py": ("twin.physics.tyre", "scenarios.road -> twin.physics.tyre"),
    "twin/pipeline/run.py": ("scenarios.plough", "twin.pipeline.run -> scenarios.plough"),
    "twin/truth/truth.py": ("estimators.ratio", "twin.truth.truth -> estimators.ratio"),
    "twin/sensors/gnss.py": ("rerun", "twin.sensors.gnss -> rerun"),
    "twin/machine/build.py": ("gymnasium", "twin.machine.build -> gymnasium"),
    "twin/scenario/soil.py": ("twin.physics.tyre", "twin.scenario.soil -> twin.physics.tyre"),
    "twin/scores/scores.py": ("twin.report.page", "twin.scores.scores -> twin.report.page"),
    "twin/logs/cells.py": ("twin.pipeline.log_check", "twin.logs.cells -> twin.pipeline.log_check"),
    "twin/streams.py": ("twin.io.plain", "twin.streams -> twin.io.plain"),
    "twin/compute/compiled.py": ("twin.io.plain", "twin.compute.compiled -> twin.io.plain"),
    "twin/stray.py": ("os", "- twin.stray"),
}
"""File -> (what it is made to import, how the broken contract names it). A stray module of no layer
is a breach by being there."""


@pytest.fixture(scope="module")
def tree(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The sources without anything else, to be spoilt."""
    folder = tmp_path_factory.mktemp("tree")
    for package in PACKAGES:
        ignore = shutil.ignore_patterns("__pycache__", "_models")
        shutil.copytree(ROOT / package.__name__, folder / package.__name__, ignore=ignore)
    shutil.copy(ROOT / "pyproject.toml", folder)
    return folder


def contracts(tree: Path) -> subprocess.CompletedProcess[str]:
    """`lint-imports` on a tree of sources, which stands first on the path."""
    program = (
        "import sys; from importlinter.cli import lint_imports_command as lint; sys.exit(lint())"
    )
    command = [sys.executable, "-c", program, "--no-cache"]
    return subprocess.run(command, cwd=tree, capture_output=True, text=True)


def test_the_import_contracts_hold_and_each_breach_is_seen(tree: Path) -> None:
    declared = tomllib.loads((tree / "pyproject.toml").read_text())["tool"]["importlinter"]
    held = contracts(tree)
    assert held.returncode == 0, held.stdout + held.stderr
    assert f"{len(declared['contracts'])} kept, 0 broken" in held.stdout
    for file, (module, _) in BREACHES.items():
        with (tree / file).open("a") as source:
            source.write(f"\nimport {module}\n")
    broken = contracts(tree)
    assert broken.returncode == 1
    assert f"0 kept, {len(declared['contracts'])} broken" in broken.stdout
    said = re.sub(r"\s+", " ", broken.stdout)
    assert [line for _, line in BREACHES.values() if line not in said] == []
