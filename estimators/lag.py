"""How late GNSS speed is against wheel speed, found from a drive that speeds up and slows down.

A receiver filters its velocity and hands it on late; at 1 Hz the lag is a fraction of a sample. The
phase of the cross-spectrum shows it without interpolating anything: a pure lag turns frequency f by
2 pi f lag. Frequencies count by how coherent the two speeds are there (Hannan and Thomson 1973,
"Estimating group delay", Biometrika 60, 241; Knapp and Carter 1976, IEEE Trans. ASSP 24, 320).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

REPLICATES = 400
_SEGMENT_ROWS = 64
_SEGMENT_S = 8.0
_FEWEST_SEGMENTS = 4
_GAP_STEPS = 2.5


@dataclass(frozen=True, kw_only=True)
class Lag:
    """A lag of GNSS speed behind wheel speed; positive is late. NaN where it is unknown."""

    lag_s: float
    low_s: float
    """2.5 % end of the interval."""
    high_s: float
    """97.5 % end of the interval."""
    segments: int
    """Stretches without a gap it was found from."""


UNKNOWN = Lag(lag_s=np.nan, low_s=np.nan, high_s=np.nan, segments=0)


def gnss_lag(
    gnss_epoch_ns: NDArray[np.int64],
    gnss_speed_mps: NDArray[Any],
    wheel_epoch_ns: NDArray[np.int64],
    wheel_speed_mps: NDArray[Any],
    *,
    max_lag_s: float = 2.0,
    seed: int = 0,
) -> Lag:
    """The lag in [-max_lag_s, max_lag_s] with its 95 % interval.

    lag = argmax over tau of Re sum_f W(f) C(f)/|C(f)| exp(i 2 pi f tau),  W = g / (1 - g)

    C is the cross-spectrum of the two speeds over half-overlapping segments with a Hann window, g
    their squared coherence less what chance gives. The interval is a bootstrap over segments.
    """
    pair = _on_one_grid(gnss_epoch_ns, gnss_speed_mps, wheel_epoch_ns, wheel_speed_mps)
    if pair is None:
        return UNKNOWN
    step_s, gnss, wheel = pair
    rows = max(_SEGMENT_ROWS, round(_SEGMENT_S / step_s))
    spectra = _spectra(gnss, wheel, rows)
    segments = len(spectra[0])
    if segments < _FEWEST_SEGMENTS:
        return UNKNOWN
    frequency_hz = np.fft.rfftfreq(rows, step_s)[1:]
    taus_s = np.arange(-max_lag_s, max_lag_s + step_s / 40, step_s / 20)
    turn = np.exp(2j * np.pi * frequency_hz[:, None] * taus_s)
    lag_s = _best(spectra, np.ones((1, segments)), turn, taus_s)[0]
    generator = np.random.default_rng(seed)
    # neighbours share half their samples: drawn two by two they vary as they should
    starts = generator.integers(0, segments, (REPLICATES, -(-segments // 2)))
    drawn = np.concatenate([starts, (starts + 1) % segments], axis=1)
    counts = np.stack([np.bincount(d, minlength=segments) for d in drawn]).astype(float)
    low, high = np.quantile(_best(spectra, counts, turn, taus_s), (0.025, 0.975))
    return Lag(lag_s=float(lag_s), low_s=float(low), high_s=float(high), segments=segments)


_Spectra = tuple[NDArray[np.complex128], NDArray[np.float64], NDArray[np.float64]]


def _on_one_grid(
    gnss_epoch_ns: NDArray[np.int64],
    gnss_speed_mps: NDArray[Any],
    wheel_epoch_ns: NDArray[np.int64],
    wheel_speed_mps: NDArray[Any],
) -> tuple[float, NDArray[np.float64], NDArray[np.float64]] | None:
    """Both speeds on the grid of the slower source, NaN in gaps; None if they do not overlap."""
    gnss_ok, wheel_ok = np.isfinite(gnss_speed_mps), np.isfinite(wheel_speed_mps)
    if gnss_ok.sum() < 2 or wheel_ok.sum() < 2:
        return None
    start_ns = max(gnss_epoch_ns[gnss_ok][0], wheel_epoch_ns[wheel_ok][0])
    gnss_s = (gnss_epoch_ns[gnss_ok] - start_ns) * 1e-9
    wheel_s = (wheel_epoch_ns[wheel_ok] - start_ns) * 1e-9
    step_s = float(max(np.median(np.diff(gnss_s)), np.median(np.diff(wheel_s))))
    stop_s = min(gnss_s[-1], wheel_s[-1])
    if not 0.0 < step_s < stop_s or stop_s / step_s > 1e8:
        return None
    grid_s = np.arange(0.0, stop_s + step_s / 2, step_s)
    gnss = _resampled(grid_s, gnss_s, gnss_speed_mps[gnss_ok])
    return step_s, gnss, _resampled(grid_s, wheel_s, wheel_speed_mps[wheel_ok])


def _resampled(
    grid_s: NDArray[Any], time_s: NDArray[Any], speed_mps: NDArray[Any]
) -> NDArray[np.float64]:
    """Linear interpolation that does not bridge gaps. Symmetric, so it adds no lag."""
    values: NDArray[np.float64] = np.interp(grid_s, time_s, speed_mps)
    right = np.clip(np.searchsorted(time_s, grid_s), 1, len(time_s) - 1)
    step_s = np.diff(time_s)
    values[step_s[right - 1] > _GAP_STEPS * np.median(step_s)] = np.nan
    return values


def _spectra(gnss: NDArray[Any], wheel: NDArray[Any], rows: int) -> _Spectra:
    """Cross-spectrum and both power spectra of each segment without a gap; frequency 0 left out."""
    starts = np.arange(0, len(gnss) - rows + 1, rows // 2)
    index = starts[:, None] + np.arange(rows)
    g, w = gnss[index], wheel[index]
    whole = np.isfinite(g).all(axis=1) & np.isfinite(w).all(axis=1)
    window = np.hanning(rows + 1)[:-1]
    g = np.fft.rfft((g[whole] - g[whole].mean(axis=1, keepdims=True)) * window)[:, 1:]
    w = np.fft.rfft((w[whole] - w[whole].mean(axis=1, keepdims=True)) * window)[:, 1:]
    return g * np.conj(w), np.abs(g) ** 2, np.abs(w) ** 2


def _best(
    spectra: _Spectra, counts: NDArray[Any], turn: NDArray[Any], taus_s: NDArray[Any]
) -> NDArray[np.float64]:
    """The lag for each row of segment counts: the peak, refined by a parabola through its sides."""
    cross, gnss, wheel = (counts @ s for s in spectra)
    segments = counts.sum(axis=1, keepdims=True)
    power = np.maximum(gnss * wheel, np.finfo(float).tiny)
    coherence = np.abs(cross) ** 2 / power
    # with few segments coherence comes out high by about (1 - g) / segments
    coherence = np.clip((coherence - 2.0 / segments) / (1.0 - 2.0 / segments), 0.0, 0.999)
    weight = coherence / (1.0 - coherence)
    phase = cross / np.maximum(np.abs(cross), np.finfo(float).tiny)
    score = np.real((weight * phase) @ turn)
    peak = np.clip(np.argmax(score, axis=1), 1, len(taus_s) - 2)
    row = np.arange(len(score))
    before, at, after = score[row, peak - 1], score[row, peak], score[row, peak + 1]
    curve = before - 2.0 * at + after
    shift = np.where(curve < 0.0, 0.5 * (before - after) / np.where(curve < 0.0, curve, 1.0), 0.0)
    lag = taus_s[peak] + np.clip(shift, -1.0, 1.0) * (taus_s[1] - taus_s[0])
    return np.asarray(np.where(weight.any(axis=1), lag, np.nan))
