import numpy as np
import pytest

from tests.camera.views import LENS, view
from twin.camera.patch import NoGraphics, PatchRenderer
from twin.camera.planar import planar
from twin.errors import OutOfRange

cv2 = pytest.importorskip("cv2")


@pytest.fixture(scope="module")
def patch():
    try:
        with PatchRenderer(LENS, 1, 0.5, centre_m=(100.0, 3.0)) as renderer:
            yield renderer
    except NoGraphics as reason:
        pytest.skip(str(reason))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("x_m", "y_m", "turn_rad", "exposure_s"),
    [(100.0, 3.0, (0, 0, 0), 0.0), (100.1, 3.05, (0.02, 0.01, 0.7), 0.0),
     (99.9, 2.95, (0, -0.03, -2.0), 0.002)],
)  # fmt: skip
def test_both_renderers_draw_the_same_ground_in_the_same_place(
    patch, x_m, y_m, turn_rad, exposure_s
):
    seen = view(x_m, y_m, turn_rad=turn_rad, velocity_mps=(1.0, 0, 0), exposure_s=exposure_s)
    ours, theirs = planar(LENS, 1, 0.5).radiance(seen), patch.radiance(seen)
    until = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, 30, 1e-6)
    mask = np.full(ours.shape, 255, np.uint8)
    alike, warp = cv2.findTransformECC(
        ours, theirs, np.eye(2, 3, dtype=np.float32), cv2.MOTION_AFFINE, until, mask, 1
    )
    corners = LENS.corners_px()
    assert alike > 0.98
    assert np.abs(warp @ corners - corners[:2]).max() <= 0.1


def test_beyond_the_patch_is_refused(patch):
    with pytest.raises(OutOfRange, match="beyond is outside the patch"):
        patch.radiance(view(100.5, 3.0))
