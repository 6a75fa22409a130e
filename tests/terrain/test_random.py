"""Ground made from a seed: its spectrum, its scale, its patches."""

import numpy as np
import pytest
from scipy.signal import welch

from twin.terrain.random import CELL_M, mixture, rough_heights


@pytest.mark.parametrize("axis", [0, 1], ids=["across", "along"])
def test_roughness_has_iso_8608s_spectrum(axis):
    """G_d(n) = G_d(0.1) (n / 0.1)**-2 along lines, read as the laws do: between the nodes.

    A tenth per octave over 40 lines of 205 m in 6 seeds; class D has 1024e-6 m3.
    """
    lines = []
    for seed in range(6):
        heights = rough_heights("D", (2048, 2048), np.random.default_rng(seed))
        picked = np.moveaxis(heights, axis, -1)[:: 2048 // 40]
        between = 0.5 * (picked + np.roll(picked, -1, axis=-1))
        lines.append(np.stack([picked, between], axis=-1).reshape(len(picked), -1))
    n, density = welch(np.concatenate(lines), 2.0 / CELL_M, nperseg=4096, detrend=False)
    density = density.mean(axis=0)
    for low, tolerance in ((0.03, 0.1), (0.06, 0.1), (0.12, 0.1), (0.24, 0.1), (0.48, 0.2)):
        band = (n >= low) & (n < 2.0 * low)  # the last fades towards the shortest waves
        wanted = np.mean(1024e-6 * (n[band] / 0.1) ** -2.0)
        assert density[band].mean() == pytest.approx(wanted, rel=tolerance), low
    assert density[n > 2.0].max() < 0.05 * 1024e-6 * 20.0**-2.0  # nothing under the contact
    assert density[n < 0.01].max() < 1024e-6 * 0.2**-2.0  # no hills


def test_a_class_is_four_times_the_one_below_and_repeats_without_a_seam():
    heights = rough_heights("E", (256, 512), np.random.default_rng(1))
    assert heights == pytest.approx(2.0 * rough_heights("D", (256, 512), np.random.default_rng(1)))
    for axis in (0, 1):
        steps = np.diff(heights, axis=axis)
        seam = np.take(heights, 0, axis) - np.take(heights, -1, axis)
        assert seam.std() == pytest.approx(steps.std(), rel=0.4)


@pytest.mark.parametrize("share", [0.1, 0.33, 0.8])
def test_patches_cover_their_share_and_have_their_size(share):
    cells = mixture(share, 10.0, (400, 1600), 0.25, np.random.default_rng(2))
    assert cells.min() == 0.0
    assert cells.max() == 1.0
    assert cells.mean() == pytest.approx(share, abs=0.02)
    apart = cells - cells.mean()
    alike = [np.mean(apart * np.roll(apart, round(m / 0.25), 1)) / apart.var() for m in (1.0, 15.0)]
    assert alike[0] > 0.75
    assert abs(alike[1]) < 0.15
