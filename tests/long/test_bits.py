"""500 control steps to the bit."""

import pytest

from tests.env.test_bits import repeats_itself
from twin.env import IDS
from twin.env.observations import MODES


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("name", IDS)
def test_500_steps(name, mode):
    repeats_itself(name, mode, 500)
