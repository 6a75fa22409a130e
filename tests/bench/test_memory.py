"""Peak memory of a process of its own."""

import numpy as np

from twin.bench.memory import own_peak_mb, peak_mb

FILLED = """
import sys
import numpy as np
held = np.ones(int(sys.argv[1]), np.uint8)
"""


def test_the_memory_of_the_process_that_asks_does_not_count():
    held = np.ones(400_000_000, np.uint8)
    small, large = (peak_mb(FILLED, str(count)) for count in (1, 150_000_000))
    assert own_peak_mb() > len(held) / 1e6
    assert small < 150.0
    assert 120.0 < large - small < 170.0
