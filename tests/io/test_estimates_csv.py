from pathlib import Path

import numpy as np
import pytest
from pyarrow import csv

from twin.errors import BadInput
from twin.io.columns import ESTIMATES
from twin.io.estimates_csv import write

EPOCH_NS = np.array([500_000_000, 1_500_000_000], np.int64)
DATED_NS = np.array([1_698_045_125_250_000_000, 1_698_045_126_250_000_000], np.int64)


def table(epoch_ns: np.ndarray) -> dict[str, np.ndarray]:
    return {
        "epoch_ns": epoch_ns, "slip": np.array([0.07, np.nan]), "speed_mps": np.array([2.0, 2.5]),
        "flags": np.array([0, 4]),
    }  # fmt: skip


def read(path: Path) -> dict[str, list]:
    return csv.read_csv(path).to_pydict()


def test_units_stand_in_the_names_and_slip_is_in_percent(tmp_path: Path) -> None:
    told = write({"ratio": table(EPOCH_NS)}, tmp_path / "e.csv")
    found = read(tmp_path / "e.csv")
    assert found["time_s"] == [0.5, 1.5]
    assert found["slip_percent"][0] == pytest.approx(7.0)
    assert found["slip_percent"][1] is None
    assert found["flags"] == [0, 4]
    assert found["estimator"] == ["ratio", "ratio"]
    assert told == "time_s is in seconds of the log's own clock"


def test_dates_are_iso_8601_to_what_they_resolve(tmp_path: Path) -> None:
    told = write({"ratio": table(DATED_NS)}, tmp_path / "e.csv")
    text = (tmp_path / "e.csv").read_text()
    assert "2023-10-23T07:12:05.250Z" in text
    assert told == "time_utc is ISO 8601"


def test_estimators_stand_below_each_other(tmp_path: Path) -> None:
    other = {"epoch_ns": EPOCH_NS, "sideslip_rad": np.zeros(2)}
    write({"ratio": table(EPOCH_NS), "mine:Own": other}, tmp_path / "e.csv")
    found = read(tmp_path / "e.csv")
    assert found["estimator"] == ["ratio", "ratio", "mine:Own", "mine:Own"]
    assert found["speed_mps"][2:] == [None, None]
    assert found["flags"][2:] == [None, None]


def test_every_column_of_estimates_has_its_unit_in_its_name(tmp_path: Path) -> None:
    every = {name: np.zeros(2) for name in ESTIMATES if name != "epoch_ns"}
    write({"all": {"epoch_ns": EPOCH_NS, **every}}, tmp_path / "e.csv")
    names = set(read(tmp_path / "e.csv")) - {"estimator", "flags"}
    assert all(name.endswith(("_s", "_percent", "_mps", "_rad", "_m")) for name in names), names


def test_a_folder_that_is_not_there_leaves_nothing(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match="cannot be written"):
        write({"ratio": table(EPOCH_NS)}, tmp_path / "none" / "e.csv")
    assert list(tmp_path.iterdir()) == []
