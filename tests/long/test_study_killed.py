"""A study that is killed hard goes on where it was."""

import os
import signal
import subprocess
import sys
import time

import numpy as np
import pyarrow.parquet as pq

from twin.studies import plan, read, work


def test_killed_three_times_at_random_moments_it_gives_the_same_table(tmp_path):
    """And nothing that was done is done again. Killed hard, workers and all."""
    seeds, estimators = 300, "ratio,pkf"
    asked = [sys.executable, "-m", "twin", "study", "ima-pkf-disturbed", "--jobs", "2", "--quiet"]
    asked += ["--seeds", str(seeds), "--estimators", estimators, "--out", str(tmp_path / "s")]
    parts, rng, kept = tmp_path / "s" / "parts", np.random.default_rng(), {}
    for share in (0.1, 0.4, 0.7):
        limit = int(seeds * (share + rng.uniform(0.0, 0.1)))
        killed = subprocess.Popen(asked, start_new_session=True, stderr=subprocess.PIPE)
        while len(list(parts.glob("[!.]*"))) < limit and killed.poll() is None:
            time.sleep(rng.uniform(0.0, 0.02))
        os.killpg(killed.pid, signal.SIGKILL)
        _, said = killed.communicate()
        assert killed.returncode == -signal.SIGKILL, f"ended by itself: {said.decode()}"
        now = {p.name: p.stat().st_mtime_ns for p in parts.glob("[!.]*")}
        assert now.items() >= kept.items(), "a run that had its part was done again"
        assert len(kept) < len(now) < seeds
        kept = now
    subprocess.run(asked, check=True, timeout=120)
    names = {p.name: p.stat().st_mtime_ns for p in parts.iterdir()}
    assert names.items() >= kept.items()
    assert len(names) == seeds, "a part is doubled, missing or half written"
    cases = plan(["ima-pkf-disturbed"], range(seeds), estimators.split(","), {})
    work(cases, tmp_path / "whole", jobs=1)
    assert pq.read_table(tmp_path / "s" / "table.parquet").equals(read(cases, tmp_path / "whole"))
