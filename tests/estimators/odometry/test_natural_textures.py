import numpy as np
import pytest
from natural import CENTRE, TEXTURES, pair

pytest.importorskip("skimage")

from estimators.odometry import orb, phase_ecc
from estimators.odometry.lens import evened

GROSS_PX = 3.0
HARD = {"move_px": 60.0, "turn_deg": 0.5, "scale": 0.01, "blur_px": 10.0}


def errors(match, name, count, move_px, turn_deg, scale, blur_px):
    """Errors across and along the motion [px], shape (n, 2), NaN where nothing was found."""
    rng = np.random.default_rng(7)
    found = np.full((count, 2), np.nan)
    for row in found:
        first, second, moved, turn = pair(name, move_px, turn_deg, scale, blur_px, rng)
        gyro = turn + rng.normal(0, 2e-4)
        made = match(*(evened(p.astype(np.float32)) for p in (first, second)), gyro)
        if made is not None:
            error = made.previous_from_current @ [*CENTRE, 1.0] - CENTRE - moved
            along = moved / np.linalg.norm(moved)
            row[:] = error @ [-along[1], along[0]], error @ along
    return found


@pytest.mark.parametrize("name", TEXTURES)
@pytest.mark.parametrize(
    ("motion", "lateral_px"),
    [({"move_px": 10.0, "turn_deg": 0.1, "scale": 0.0, "blur_px": 0.0}, 0.02),
     ({"move_px": 30.0, "turn_deg": 0.3, "scale": 0.005, "blur_px": 0.0}, 0.04),
     (HARD, 0.2)],
)  # fmt: skip
def test_phase_and_ecc_never_fail_grossly_and_are_this_good(name, motion, lateral_px):
    error = errors(phase_ecc.match, name, 10, **motion)
    assert not np.any(np.isnan(error))
    assert np.abs(error).max() < GROSS_PX
    assert np.sqrt(np.mean(error[:, 0] ** 2)) <= lateral_px
    assert np.sqrt(np.mean(error[:, 1] ** 2)) <= 0.2


def test_the_lateral_error_is_as_large_as_reported():
    rng, ratios = np.random.default_rng(8), []
    for name in TEXTURES:
        for _ in range(8):
            first, second, moved, turn = pair(name, 30.0, 0.3, 0.005, 0.0, rng)
            made = phase_ecc.match(*(evened(p.astype(np.float32)) for p in (first, second)), turn)
            error = made.previous_from_current @ [*CENTRE, 1.0] - CENTRE - moved
            ratios.append(float(error @ [-moved[1], moved[0]]) / 30.0 / made.variance_px2**0.5)
    assert 0.15 < np.sqrt(np.mean(np.square(ratios))) < 1.5


def test_unrelated_pictures_are_not_matched():
    rng = np.random.default_rng(9)
    gravel, grass, brick = (
        evened(pair(n, 1.0, 0, 0, 0, rng)[0].astype(np.float32)) for n in TEXTURES
    )
    for one, other in ((gravel, grass), (grass, brick), (brick, gravel)):
        assert phase_ecc.match(one, other, 0.0) is None


@pytest.mark.parametrize("name", ["gravel", "grass"])
def test_features_with_a_similarity_are_good_to_a_fraction_of_a_pixel(name):
    gentle = {"move_px": 30.0, "turn_deg": 0.3, "scale": 0.005, "blur_px": 0.0}
    error = errors(orb.match_similarity, name, 10, **gentle)
    assert not np.any(np.isnan(error))
    assert np.sqrt(np.mean(error**2)) < 0.3


def test_the_printed_pipeline_is_a_baseline_and_no_more():
    printed = errors(orb.match_printed, "gravel", 10, **HARD)
    ours = errors(phase_ecc.match, "gravel", 10, **HARD)
    wrong = np.isnan(printed).any(axis=1) | (np.abs(printed).max(axis=1) > 3.0)
    assert wrong.mean() > 0.3  # half and more of the frames, at this blur
    gentle = {"move_px": 10.0, "turn_deg": 0.1, "scale": 0.0, "blur_px": 0.0}
    assert np.nanmedian(np.abs(errors(orb.match_printed, "gravel", 10, **gentle))) < 3.0
    assert np.abs(ours).max() < 0.5
