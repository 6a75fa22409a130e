"""A reader of logs: a data logger that writes one value a line, as `1.250 v_gnss 1.98`."""

from collections import defaultdict

import numpy as np

from twin.errors import BadInput
from twin.logs import Reader, Signal


class DataLogger(Reader):
    name = "data logger"

    def signals(self, path):
        times, values = defaultdict(list), defaultdict(list)
        for number, line in enumerate(path.read_text().splitlines(), 1):
            try:
                time_s, name, value = line.split()
                times[name].append(round(1e9 * float(time_s)))
                values[name].append(float(value))
            except ValueError:
                raise BadInput(f"line {number}: {line[:40]!r} is no TIME NAME VALUE") from None
        return {n: Signal(np.array(values[n]), np.array(times[n], np.int64)) for n in values}
