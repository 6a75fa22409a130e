"""Second-order sections of a filter, run sample by sample in compiled code."""

from __future__ import annotations

from twin.compute.compiled import compiled
from twin.sensors.noise import Array


@compiled
def run_sections(sections: Array, state: Array, x: Array, y: Array) -> None:
    """Transposed direct form II of each section in turn; the state is changed in place."""
    for i in range(x.shape[0]):
        for j in range(x.shape[1]):
            value = x[i, j]
            for k in range(sections.shape[0]):
                out = sections[k, 0] * value + state[k, 0, j]
                state[k, 0, j] = sections[k, 1] * value - sections[k, 4] * out + state[k, 1, j]
                state[k, 1, j] = sections[k, 2] * value - sections[k, 5] * out
                value = out
            y[i, j] = value
