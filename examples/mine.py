"""An estimator of one's own: slip from wheel ticks over 0.2 s and the newest GNSS speed."""

import numpy as np

LAG = 10  # samples of the wheels, at 50 Hz


class Mine:
    def init(self, setup):
        metres = 2 * np.pi * setup.wheels.radius_m["rl"] / setup.wheels.counts_per_turn
        return metres, np.full(LAG, np.nan), np.full(LAG, np.nan), np.nan

    def run(self, state, chunk):
        metres, time, ticks, ground = state
        epoch_ns = chunk.column("wheels", "epoch_ns").astype(np.int64)
        turned = chunk.column("wheels", "ticks_rl") + chunk.column("wheels", "ticks_rr")
        time, ticks = np.append(time, 1e-9 * epoch_ns), np.append(ticks, 0.5 * turned)
        wheel = metres * (ticks[LAG:] - ticks[:-LAG]) / (time[LAG:] - time[:-LAG])
        speed = np.hypot(chunk.column("gnss", "v_east_mps"), chunk.column("gnss", "v_north_mps"))
        grounds = np.append(ground, speed)  # what was known before, then each fix
        arrival = chunk.column("gnss", "arrival_ns"), chunk.column("wheels", "arrival_ns")
        slip = 1 - grounds[np.searchsorted(*arrival, side="right")] / np.maximum(wheel, 0.1)
        state = metres, time[-LAG:], ticks[-LAG:], grounds[-1]
        return state, {"epoch_ns": epoch_ns, "slip": slip}
