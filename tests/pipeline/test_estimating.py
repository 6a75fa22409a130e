import sys

import numpy as np
import pytest

from tests.synthetic_run import synthetic_run
from twin.errors import BadInput
from twin.pipeline import named as registry
from twin.pipeline.estimating import all_estimates, estimates
from twin.plugins.percent import percent_note

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
        ("  return s, {'slip': np.zeros(3)}", "have no column epoch_ns"),
        ("  return s, {'epoch_ns': np.arange(3)}", "epoch_ns alone; add one of speed_mps"),
        ("  return s, {'epoch_ns': np.arange(3), 'slipp': np.zeros(3)}",
         "no column of estimates is called 'slipp'; did you mean 'slip'?"),
        ("  return s, {'epoch_ns': [0.02, 0.04], 'slip': np.zeros(2)}", "0.02; it counts whole"),
        ("  return s, {'epoch_ns': [1.0, np.nan], 'slip': np.zeros(2)}", "has nan; it counts"),
        ("  return s, {'epoch_ns': ['a'], 'slip': [0.1]}", "holds <U1 values, not nanoseconds"),
        ("  return s, {'epoch_ns': [1], 'slip': ['a']}", "slip holds <U1 values, not numbers"),
        ("  v = chunk['gnss']['v_east_mps']; v -= v.mean()",
         r"writes to an array it was handed \(own_estimator.py, line 5\).*x.copy\(\)"),
        ("  chunk.column('gnss', 'v_east_mps')[:3] = 0.0", r"line 5\).*x.copy\(\)"),
        ("  chunk.samples(0, 9)['wheels']['epoch_ns'].sort()", r"line 5\).*x.copy\(\)"),
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
    made(tmp_path, monkeypatch, "  return s, {'epoch_ns': [], 'slip': []}")
    with pytest.raises(BadInput, match="as own_estimator:Name"):
        registry.load("estimator", "own_estimator")


class Adds:
    """Adds a column to what it is handed, and replaces one."""

    def init(self, setup):
        return None

    def run(self, state, chunk):
        chunk["gnss"]["v_east_mps"] = 0.0 * chunk["gnss"]["v_east_mps"]
        chunk["gnss"]["mine"] = chunk["gnss"].pop("v_north_mps")
        epoch_ns = chunk["wheels"]["epoch_ns"]
        return state, {"epoch_ns": epoch_ns, "slip": np.full(len(epoch_ns), 0.1)}


class Percent(Adds):
    def run(self, state, chunk):
        state, table = super().run(state, chunk)
        return state, table | {"slip": 123.0 * table["slip"]}


class Fails(Adds):
    def run(self, state, chunk):
        raise ZeroDivisionError("no speed")


def test_no_estimator_changes_what_another_sees_or_what_is_saved():
    before = {s: {c: v.copy() for c, v in t.items()} for s, t in RUN.streams.tables.items()}
    estimates("adds", Adds(), RUN.setup, RUN.streams)
    assert {s: set(t) for s, t in RUN.streams.tables.items()} == {s: set(before[s]) for s in before}
    for sensor, table in before.items():
        for column, values in table.items():
            np.testing.assert_array_equal(values, RUN.streams[sensor][column])


def test_one_that_fails_is_named_and_the_others_go_on():
    done = all_estimates({"mine": Fails(), "adds": Adds()}, RUN.setup, RUN.streams)
    assert (
        "estimator 'mine' fails: ZeroDivisionError: no speed (test_estimating.py, line"
        in (done.failed["mine"])
    )
    assert done.notes == (done.failed["mine"],)
    assert np.isnan(done.tables["mine"]["slip"]).all()
    assert np.all(done.tables["adds"]["slip"] == 0.1)


def test_a_slip_in_percent_is_told_and_a_ratio_is_not():
    done = all_estimates({"adds": Adds(), "mine": Percent()}, RUN.setup, RUN.streams)
    assert not done.failed
    assert done.notes == (
        "slip of 'mine' has median 12.3: it looks like percent; slip is a ratio, 0.123",
    )
    assert done.tables["mine"]["slip"][0] == pytest.approx(12.3)


def test_slip_while_standing_is_no_sign_of_percent():
    table = {
        "epoch_ns": np.arange(4), "slip": np.array([50.0, 50.0, 50.0, 0.1]),
        "speed_mps": np.array([0.0, 0.0, 0.0, 1.0]),
    }  # fmt: skip
    assert percent_note("slip", table) is None
    assert "-12.3" in percent_note("slip of the truth", {"slip": np.full(3, -12.3)})
    assert percent_note("slip", {"epoch_ns": np.arange(3), "speed_mps": np.ones(3)}) is None
