"""A calibration that is killed hard goes on where it was."""

import json
import os
import signal
import subprocess
import sys
import time

TWIN = [sys.executable, "-m", "twin"]


def test_killed_in_the_middle_it_gives_the_same_result(tmp_path):
    drive = tmp_path / "drive"
    words = ["run", "plough-25cm", "--course.length-m", "90", "--estimators", "ratio", "--quiet"]
    subprocess.run([*TWIN, *words, "--out", str(drive)], check=True)
    asked = [
        *TWIN,
        "calibrate",
        str(drive),
        "--machine",
        "taishan_1404a",
        "--starts",
        "4",
        "--json",
    ]
    whole = subprocess.run([*asked, "--out", str(tmp_path / "whole")], check=True,
                           capture_output=True)  # fmt: skip
    out = tmp_path / "killed"
    kept = out / ".taishan_1404a.calibrating.json"
    seen = 0
    for starts in (1, 3):  # killed after the first start, and again after the third
        killed = subprocess.Popen([*asked, "--out", str(out)], start_new_session=True,
                                  stdout=subprocess.PIPE, stderr=subprocess.PIPE)  # fmt: skip
        while killed.poll() is None and seen < starts:
            time.sleep(0.01)
            seen = len(json.loads(kept.read_text())["kept"]) if kept.exists() else 0
        os.killpg(killed.pid, signal.SIGKILL)
        killed.communicate()
        assert killed.returncode == -signal.SIGKILL, "it ended by itself"
        assert [p for p in out.iterdir() if p != kept] == [], "something is half written"
    again = subprocess.run([*asked, "--out", str(out)], check=True, capture_output=True)
    assert again.stdout == whole.stdout
    assert not kept.exists()
    for name in ("calibrated.toml", "calibrated.posterior.json", "calibrated.soil.toml"):
        first, second = (tmp_path / f / f"taishan_1404a.{name}" for f in ("whole", "killed"))
        assert first.read_bytes() == second.read_bytes()
