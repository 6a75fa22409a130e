"""What a user may bring along: a scenario and estimators, some of which fail."""

import dataclasses

from estimators.ratio import RATIO
from scenarios.ima_pkf import Trial


@dataclasses.dataclass(frozen=True, kw_only=True)
class Odd(Trial):
    """Cannot be measured with an odd seed."""

    def measure(self):
        if self.seed % 2:
            raise ArithmeticError("odd\nand more")
        return super().measure()


ODD = Odd(name="odd")


@dataclasses.dataclass(frozen=True)
class Seeded:
    """The ratio, which is scaled by its seed."""

    seed: int = -1
    scale: float = 1.0

    def init(self, setup):
        return RATIO.init(setup)

    def run(self, state, chunk):
        state, table = RATIO.run(state, chunk)
        return state, table | {"slip": table["slip"] * 0.0 + self.scale * self.seed}


SEEDED = Seeded()
SCALED = Seeded(scale=2.0)


class Failing:
    """Fails on everything."""

    def init(self, setup):
        return None

    def run(self, state, chunk):
        raise RuntimeError("no idea")
