import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from estimators import compiled

SOURCE = Path(compiled.__file__)


def test_key_changes_with_any_source(tmp_path):
    (tmp_path / "a.py").write_text("x = 1")
    first = compiled.source_key(tmp_path)
    assert compiled.source_key(tmp_path) == first
    (tmp_path / "b.py").write_text("y = 2")
    second = compiled.source_key(tmp_path)
    (tmp_path / "b.py").write_text("y = 3")
    assert len({first, second, compiled.source_key(tmp_path)}) == 3


def test_a_cache_that_cannot_be_written_is_replaced_by_a_temporary_one(tmp_path, monkeypatch):
    blocked = tmp_path / "file"
    blocked.write_text("")
    monkeypatch.setenv("XDG_CACHE_HOME", str(blocked))
    compiled.cache_folder.cache_clear()
    try:
        folder = compiled.cache_folder()
        assert folder.is_dir()
        assert blocked not in folder.parents
        folder.rmdir()
    finally:
        compiled.cache_folder.cache_clear()


@pytest.mark.slow
def test_an_edited_callee_runs_in_its_new_form(tmp_path):
    """numba's own cache would keep the caller, with the old callee inlined."""
    package = tmp_path / "estimators"
    package.mkdir()
    (package / "__init__.py").write_text("")
    shutil.copy(SOURCE, package / "compiled.py")
    head = "from twin.compiled import compiled\n"
    (package / "caller.py").write_text(
        f"{head}from estimators.callee import law\n@compiled\ndef go(x):\n    return law(x) + 1\n"
    )
    environment = os.environ | {"XDG_CACHE_HOME": str(tmp_path / "cache"), "PYTHONPATH": ""}
    program = (
        f"import sys; sys.path.insert(0, {str(tmp_path)!r});"
        "from estimators.caller import go; print(go(1), sum(go.stats.cache_hits.values()))"
    )

    def run(law):
        (package / "callee.py").write_text(f"{head}@compiled\ndef law(x):\n    return {law}\n")
        ran = subprocess.run(
            [sys.executable, "-P", "-c", program], env=environment, capture_output=True, text=True
        )
        assert not ran.stderr
        return ran.stdout.split()

    assert run("x * 10") == ["11", "0"]
    assert run("x * 10") == ["11", "1"]
    assert run("x * 20") == ["21", "0"]
