import sys

import numpy as np
import pytest

from tests.synthetic_run import synthetic_run
from twin.errors import BadInput
from twin.pipeline import named as registry
from twin.pipeline.estimating import estimates

RUN = synthetic_run(duration_s=4.0)
HEAD = (
    "import numpy as np\nclass Mine:\n def init(self, setup): return 0\n def run(self, s, chunk):\n"
)


def made(tmp_path, monkeypatch, body):
    monkeypatch.setattr(sys, "path", list(sys.path))
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    monkeypatch.delitem(sys.modules, "own_estimator", raising=False)
    monkeypatch.chdir(tmp_path)
    (tmp_path / "own_estimator.py").write_text(HEAD + body)
    mine = registry.load("estimator", "own_estimator:Mine")
    return estimates("mine", mine, RUN.setup, RUN.streams)


@pytest.mark.parametrize(
    ("body", "says"),
    [
        ("  return s, chunk['wheelz']", r"fails: KeyError: 'wheelz' \(own_estimator.py, line 5\)"),
        ("  return s, np.linalg.inv(np.zeros((2, 2)))", r"Singular.*\(own_estimator.py, line 5\)"),
        ("  return {'slip': np.zeros(3)}", r"run gives dict, not \(state, table"),
        ("  return s, {'epoch_ns': np.arange(4), 'slip': np.zeros(3)}",
         r"slip has shape \(3,\), epoch_ns \(4,\)"),
        ("  return s, {'epoch_ns': np.arange(4), 'slip': 0.1}", r"slip has shape \(\)"),
        ("  return s, {'slip': np.zeros(3)}", r"slip has shape \(3,\), epoch_ns \(0,\)"),
    ],
)  # fmt: skip
def test_what_an_estimator_does_wrong_is_told_in_one_line(tmp_path, monkeypatch, body, says):
    with pytest.raises(BadInput, match=says) as caught:
        made(tmp_path, monkeypatch, body)
    assert "\n" not in str(caught.value)
    assert "estimator 'mine'" in str(caught.value)


def test_epochs_become_whole_numbers_and_lists_arrays(tmp_path, monkeypatch):
    body = "  return s, {'epoch_ns': np.array([1.0, 2.0]), 'slip': [0.1, 0.2]}"
    table = made(tmp_path, monkeypatch, body)
    assert table["epoch_ns"].dtype == np.int64
    np.testing.assert_array_equal(table["slip"], [0.1, 0.2])


def test_a_file_named_without_what_is_in_it_is_hinted_at(tmp_path, monkeypatch):
    made(tmp_path, monkeypatch, "  return s, {}")
    with pytest.raises(BadInput, match="as own_estimator:Name"):
        registry.load("estimator", "own_estimator")
