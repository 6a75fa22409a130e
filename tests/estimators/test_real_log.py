"""A real tractor's log: whoever foresees the receiver's speed while it is hidden knows the motion.

python -m pytest -s tests/estimators/test_real_log.py      prints the figures
"""

from pathlib import Path

import numpy as np
import pytest

from twin import logs
from twin.pipeline import log_check as logcheck
from twin.pipeline.named import load
from twin.streams import Streams

ROOT = Path(__file__).parents[2]
LOG = ROOT.parent / "shared" / "data" / "t7165s_field.csv"
OTHERS = ("ratio", "four-state", "pkf", "kf-tuned")
EVERY_S = {1.0: 5.0, 10.0: 40.0, 30.0: 80.0, 60.0: 140.0}
"""How long the receiver is hidden, and after what time again [s]."""
MOVING_MPS = 0.5

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not LOG.exists(), reason=f"{LOG.name} is not at hand"),
]


@pytest.fixture(scope="module")
def log():
    read = logs.read(LOG, ROOT / "examples" / "t7165s.toml")
    return logcheck.scaled(read, logcheck.log_scale(read).scale)


def foresight(log, name, hidden_s):
    """Errors of the ground speed at the end of each hiding [m/s]; NaN where it is silent."""
    gnss = log.streams["gnss"]
    time = gnss["epoch_ns"] * 1e-9
    speed = np.hypot(gnss["v_east_mps"], gnss["v_north_mps"])
    starts = np.arange(time[0] + 30.0, time[-1] - hidden_s - 5.0, EVERY_S[hidden_s])
    hidden = np.any([(time > s) & (time <= s + hidden_s) for s in starts], axis=0)
    seen = {column: values[~hidden] for column, values in gnss.items()}
    estimator = load("estimator", name)
    _, table = estimator.run(
        estimator.init(log.setup), Streams({**log.streams.tables, "gnss": seen})
    )
    spans = [np.flatnonzero((time > s) & (time <= s + hidden_s)) for s in starts]
    last = [span[-1] for span in spans if len(span)]
    error = np.interp(time[last], table["epoch_ns"] * 1e-9, table["speed_mps"]) - speed[last]
    return error[speed[last] > MOVING_MPS]


def rms(error):
    return float(np.sqrt(np.mean(np.square(error)))) if np.isfinite(error).all() else np.inf


def test_a_second_ahead_it_is_likelier_than_the_others(log):
    """By Gaussians, each with its own scatter: the mean log-likelihood is a constant - log(rms)."""
    ours = rms(foresight(log, "slip-ekf", 1.0))
    others = {name: rms(foresight(log, name, 1.0)) for name in OTHERS}
    print(f"1 s ahead: slip-ekf {ours:.3f} m/s;", others)
    assert -np.log(ours) > max(-np.log(sd) for sd in others.values()) + 0.5


@pytest.mark.parametrize("hidden_s", [10.0, 30.0, 60.0])
def test_with_the_receiver_hidden_its_speed_is_nearer(log, hidden_s):
    ours = rms(foresight(log, "slip-ekf", hidden_s))
    others = {name: rms(foresight(log, name, hidden_s)) for name in OTHERS}
    print(f"{hidden_s:.0f} s hidden: slip-ekf {ours:.3f} m/s;", others)
    assert ours < 0.5 * min(others.values())
