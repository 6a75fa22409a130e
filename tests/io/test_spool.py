"""Tables that grow by chunks give the same rows, whether they went through files or not."""

import gc
import os
import resource

import numpy as np
import pytest

from twin.io.spool import Spool


def chunks(count, rows=100):
    rng = np.random.default_rng(3)
    for k in range(count):
        yield {
            "epoch_ns": np.arange(k * rows, (k + 1) * rows, dtype=np.int64),
            "x_m": rng.standard_normal(rows),
            "pair": rng.standard_normal((rows, 2)),
            "flag": rng.random(rows) > 0.5,
        }


@pytest.mark.parametrize("most_bytes", [0, 5000, 10**9])
def test_rows_are_those_that_were_appended(most_bytes):
    spool = Spool(most_bytes)
    for chunk in chunks(7):
        spool.append(chunk)
    table = spool.table()
    for name in table:
        expected = np.concatenate([chunk[name] for chunk in chunks(7)])
        assert np.array_equal(table[name], expected)
        assert table[name].dtype == expected.dtype


def test_a_chunk_may_be_changed_after_it_was_appended():
    spool, chunk = Spool(), {"x_m": np.ones(3)}
    spool.append(chunk)
    chunk["x_m"][:] = 2.0
    assert np.array_equal(spool.table()["x_m"], np.ones(3))


def test_no_file_stays_open():
    before = len(os.listdir("/proc/self/fd")) if os.path.isdir("/proc/self/fd") else None
    spool = Spool(0)
    for chunk in chunks(3):
        spool.append(chunk)
    table = spool.table()
    del table, spool
    gc.collect()
    if before is not None:
        assert len(os.listdir("/proc/self/fd")) == before


def test_memory_stays_flat():
    """200 MB through a spool that may hold one."""
    spool, block = Spool(2**20), {"x_m": np.ones(2**17)}
    spool.append(block)
    before_kb = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    for _ in range(200):
        spool.append(block)
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before_kb < 20_000
