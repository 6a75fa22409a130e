"""A sensor: a Doppler radar that measures the speed over ground."""

from dataclasses import dataclass
from typing import Annotated

import numpy as np

from twin.sensors import Column, Range, Sensor, arrivals, generator, read, reader


@dataclass(frozen=True, kw_only=True)
class Radar(Sensor):
    rate_hz: Annotated[float, Range(1, 100)] = 10.0
    speed_sd_mps: Annotated[float, Range(0, 1)] = 0.03  # assumed
    latency_s: Annotated[float, Range(0, 1)] = 0.05  # assumed
    scale_error: Annotated[float, Range(-0.2, 0.2)] = 0.01  # the true one: not in the set-up

    stream = "radar"
    columns = (Column("speed_mps", "m/s", "speed over ground along the tractor"),)

    def setup(self, geometry):
        return {"rate_hz": self.rate_hz, "speed_sd_mps": self.speed_sd_mps}

    def init(self, seed, start_ns):
        return reader(start_ns, self.rate_hz), generator(seed, "radar", "noise"), start_ns

    def sample(self, state, chunk):
        position, noise, last_ns = state
        position, epoch_ns, at = read(position, chunk, ("velocity_w", "world_from_body"))
        w, x, y, z = at["world_from_body"].T
        ahead = 1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)  # the x axis
        speed = sum(a * v for a, v in zip(ahead, at["velocity_w"].T, strict=True))
        drawn = self.speed_sd_mps * noise.standard_normal(len(epoch_ns))
        last_ns, arrival_ns = arrivals(last_ns, epoch_ns, np.full(len(epoch_ns), self.latency_s))
        table = {"epoch_ns": epoch_ns, "arrival_ns": arrival_ns}
        table["speed_mps"] = (1 + self.scale_error) * speed + drawn
        return (position, noise, last_ns), table
