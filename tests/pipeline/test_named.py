import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from estimators import REGISTRY
from twin.errors import BadInput, UnknownName
from twin.pipeline import named as registry
from twin.pipeline.run import run
from twin.streams import Setup, Streams

MINE = Path(__file__).parents[1] / "estimators" / "mine.py"


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A working directory of a user's own, forgotten afterwards."""
    modules = set(sys.modules)
    monkeypatch.setattr(sys, "path", list(sys.path))
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    monkeypatch.chdir(tmp_path)
    yield tmp_path
    for name in set(sys.modules) - modules:
        if str(tmp_path) in str(getattr(sys.modules[name], "__file__", "")):
            del sys.modules[name]


def message(kind, spec):
    with pytest.raises(BadInput) as caught:
        registry.load(kind, spec)
    assert "\n" not in str(caught.value)
    return str(caught.value)


HEAD = "from dataclasses import dataclass\n@dataclass\nclass Own:\n name: str = 'own'\n"


@pytest.mark.parametrize(
    ("source", "spec", "says"),
    [
        ("Own = 3", "own:Own", "is int; it must be a twin.scenario.Scenario"),
        (HEAD + " seed: int = 0", "own:Own", "is Own; it must be"),
        (HEAD + " def measure(self): pass", "own:Own", "has no seed"),
        ("class Own:\n def __init__(self, x): pass", "own:Own", "cannot be made: TypeError"),
        (
            "class Own:\n name, seed, measure = 'own', 0, print",
            "own:Own",
            "or a dataclass with name",
        ),
    ],
)
def test_what_is_no_scenario_is_told_in_one_line(folder, source, spec, says):
    (folder / "own.py").write_text(source)
    assert says in message("scenario", spec)


def test_signals_that_fail_say_where(folder):
    body = " seed: int = 0\n def measure(self):\n  return {}['x']\n"
    (folder / "own.py").write_text(HEAD + body)
    with pytest.raises(BadInput, match=r"'own': measure fails: KeyError: 'x' \(own.py, line 7\)"):
        run(registry.load("scenario", "own:Own"), estimators={})


@pytest.mark.parametrize("name", REGISTRY)
def test_every_registered_estimator_loads(name):
    estimator = registry.load("estimator", name)
    assert callable(estimator.init)
    assert callable(estimator.run)


def test_names_are_sorted_and_registered():
    assert registry.names("estimator") == sorted(REGISTRY)


def test_a_name_nearly_right_is_hinted_at():
    with pytest.raises(UnknownName, match="did you mean 'four-state'"):
        registry.load("estimator", "four-stat")


def test_a_kind_that_there_is_not():
    with pytest.raises(UnknownName, match="no kind is called 'tractor'"):
        registry.names("tractor")


@pytest.mark.parametrize("attribute", ["Mine", "INSTANCE", ""])
def test_own_class_instance_or_module_runs(folder, attribute):
    source = MINE.read_text()
    assert len(source.splitlines()) < 20
    extra = "\nINSTANCE = Mine()\ninit = INSTANCE.init\nrun = INSTANCE.run\n"
    (folder / "own_filter.py").write_text(source + extra)
    own = registry.load("estimator", f"own_filter:{attribute}")
    stamps = {name: np.array([0, 20]) for name in ("epoch_ns", "arrival_ns")}
    chunk = Streams(
        {
            "gnss": stamps | {"v_east_mps": np.full(2, 1.8), "v_north_mps": np.zeros(2)},
            "wheels": stamps | {"speed_rl_mps": np.full(2, 2.0)},
        }
    )
    setup = Setup(machine="m", wheelbase_m=2, track_front_m=1, track_rear_m=1, cg_x_m=1)
    _, estimates = own.run(own.init(setup), chunk)
    assert estimates["slip"] == pytest.approx([0.1, 0.1])


def test_a_folder_called_estimators_shadows_nothing(tmp_path):
    """As the console script runs: the working directory is not at the head of the path."""
    (tmp_path / "estimators").mkdir()
    (tmp_path / "estimators" / "__init__.py").write_text("raise RuntimeError('shadowed')")
    (tmp_path / "own_filter.py").write_text(MINE.read_text())
    program = (
        "from twin.pipeline import named as registry;"
        "registry.load('estimator', 'own_filter:Mine');"
        "registry.load('estimator', 'ratio'); import estimators; print(estimators.REGISTRY['pkf'])"
    )
    ran = subprocess.run(
        [sys.executable, "-P", "-c", program], cwd=tmp_path, capture_output=True, text=True
    )
    assert ran.stdout == f"{REGISTRY['pkf']}\n", ran.stderr


def test_naming_estimators_imports_nothing_heavy():
    program = (
        "import sys; from twin.pipeline import named as registry; registry.names('estimator');"
        "print([m for m in ('numba', 'scipy', 'mujoco') if m in sys.modules])"
    )
    ran = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert ran.stdout == "[]\n", ran.stderr


@pytest.mark.parametrize(
    ("source", "spec", "says"),
    [
        (None, "absent:Mine", "there is no module 'absent'"),
        ("import nowhere_at_all", "own:Mine", "No module named 'nowhere_at_all'"),
        ("raise ValueError('two\\nlines')", "own:Mine", "ValueError: two"),
        ("def x(:", "own:Mine", "SyntaxError"),
        ("class Mine: pass", "own:Mien", "did you mean 'Mine'"),
        ("class Mine: pass", "own:Mine", "has no init and no run"),
        ("class Mine:\n def init(self, s): pass", "own:Mine", "has no run"),
        ("Mine = 3", "own:Mine", "has no init and no run"),
        ("class Mine:\n def __init__(self, x): pass", "own:Mine", "cannot be made: TypeError"),
        ("", "own:", "has no init and no run"),
        (None, ":Mine", "cannot be imported"),
    ],
)
def test_what_cannot_be_used_is_told_in_one_line(folder, source, spec, says):
    if source is not None:
        (folder / "own.py").write_text(source)
    assert says in message("estimator", spec)
