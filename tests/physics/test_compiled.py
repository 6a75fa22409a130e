"""Compiled laws are never stale: the cache follows every source, offset and version."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import mujoco
import numba
import pytest

import twin
from twin.physics import compiled, layout

PACKAGE = Path(twin.__file__).parent
PROGRAM = """
import numpy as np
from tests.physics.blocks import soil, wheel
from twin.physics.tyre import relaxed_shear
force = relaxed_shear(soil(), wheel(), 21.7e3, 1.7, 1.5, 0.1, (0.02, -0.04, 0.1, -0.05), 0.002)
hits = sum(relaxed_shear.stats.cache_hits.values())
print(repr(force[0]), hits)
"""


@pytest.fixture
def run(tmp_path):
    """Runs the law of a copied package in a process of its own; its force and cache hits."""
    checkout = tmp_path / "checkout"
    ignored = shutil.ignore_patterns("__pycache__")
    shutil.copytree(PACKAGE, checkout / "twin", ignore=ignored)
    shutil.copytree(Path(__file__).parent, checkout / "tests" / "physics", ignore=ignored)
    environment = os.environ | {
        "XDG_CACHE_HOME": str(tmp_path / "cache"),
        "PYTHONPATH": str(checkout),
        "PYTHONDONTWRITEBYTECODE": "1",
    }

    def once():
        done = subprocess.run(
            [sys.executable, "-c", PROGRAM],
            env=environment, cwd=checkout, capture_output=True, text=True, check=True,
        )  # fmt: skip
        force, hits = done.stdout.split()
        return float(force), int(hits)

    once.checkout, once.cache = checkout, tmp_path / "cache" / "tractor-twin"
    return once


@pytest.mark.slow
def test_an_edited_law_runs_in_its_new_form_and_an_unedited_one_from_the_cache(run):
    first, hits = run()
    assert hits == 0
    assert run() == (first, 1)
    assert len(list(run.cache.iterdir())) == 1
    source = run.checkout / "twin" / "physics" / "brixius.py"  # what the called law calls
    text = source.read_text()
    assert text.count("math.expm1(-k * sigma)") == 1
    source.write_text(text.replace("math.expm1(-k * sigma)", "math.expm1(-0.9 * k * sigma)"))
    times = source.stat()
    edited, hits = run()
    assert hits == 0
    assert edited != first
    assert len(list(run.cache.iterdir())) == 2
    source.write_text(text)
    os.utime(source, (times.st_atime, times.st_mtime))
    assert run()[0] == first


def test_the_key_is_the_same_until_something_changes():
    assert compiled.cache_key() == compiled.cache_key()
    assert re.fullmatch("[0-9a-f]{16}", compiled.cache_key())


@pytest.mark.parametrize("module", [mujoco, numba])
def test_the_key_follows_the_versions(module, monkeypatch):
    before = compiled.cache_key()
    monkeypatch.setattr(module, "__version__", "99.0.0")
    assert compiled.cache_key() != before


@pytest.mark.parametrize("field", [("mjModel", "numeric_data"), ("mjData", "userdata")])
def test_the_key_follows_a_moved_field(field, monkeypatch):
    before, real = compiled.cache_key(), layout.offset
    monkeypatch.setattr(layout, "offset", lambda *at: real(*at) + 8 * (at == field))
    assert compiled.cache_key() != before


def test_the_key_follows_every_source(tmp_path, monkeypatch):
    shutil.copytree(compiled.SOURCES, tmp_path / "physics")
    monkeypatch.setattr(compiled, "SOURCES", tmp_path / "physics")
    keys = {compiled.cache_key()}
    for source in sorted((tmp_path / "physics").glob("*.py")):
        source.write_text(source.read_text() + "# edited\n")
        keys.add(compiled.cache_key())
    assert len(keys) == 1 + len(list((tmp_path / "physics").glob("*.py")))


def test_numbas_own_cache_folder_is_left_as_it_was():
    before = numba.config.CACHE_DIR
    compiled.law(lambda x: x)
    assert before == numba.config.CACHE_DIR
