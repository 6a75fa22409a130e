"""Sizes by the code, beside catalogues."""

import pytest

from twin.errors import BadInput
from twin.vehicle.tyre_code import tyre_size

KNOWN = {
    "18.4-38": (0.467, 1.755, False),
    "18.4R38": (0.467, 1.755, True),
    "14.9-26": (0.378, 1.31, False),
    "6.00-16": (0.158, 0.735, False),
    "7.50-16": (0.195, 0.805, False),
    "480/70R34": (0.480, 1.536, True),
    "IF 600/70R30": (0.600, 1.602, True),
    "540/65R38": (0.540, 1.667, True),
    "420/85R34 142A8": (0.420, 1.578, True),
}
"""Width and diameter [m] of catalogues and of the metric codes' own arithmetic; radial."""


@pytest.mark.parametrize("code", KNOWN)
def test_a_code_gives_the_sizes_of_the_catalogue(code):
    width_m, diameter_m, radial = KNOWN[code]
    size = tyre_size(code)
    assert size.width_m == pytest.approx(width_m, rel=0.04)
    assert size.diameter_m == pytest.approx(diameter_m, rel=0.015)
    assert size.radial is radial


@pytest.mark.parametrize("code", ["", "large", "18.4", "38", "18.4-380", "R38", "1/2R3", "99.9-38"])
def test_what_is_no_code_is_refused(code):
    with pytest.raises(BadInput, match="tyre = "):
        tyre_size(code)
