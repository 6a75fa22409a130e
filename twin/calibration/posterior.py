"""What is known of parameters after a log: a normal distribution of their logarithms, as a file."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from twin.errors import BadInput
from twin.io.atomic import write_text

Array = NDArray[np.float64]
LOG = "log"
"""The transform: mean and covariance are those of natural logarithms."""


@dataclass(frozen=True)
class Posterior:
    """Names, mean and covariance of the logarithms."""

    names: tuple[str, ...]
    mean: Array
    cov: Array

    def draw(self, count: int, seed: int = 0) -> list[dict[str, float]]:
        """Values of all parameters, so many times."""
        generator = np.random.default_rng(seed)
        draws = generator.multivariate_normal(self.mean, self.cov, count, method="cholesky")
        return [dict(zip(self.names, np.exp(row).tolist(), strict=True)) for row in draws]

    def write(self, path: Path) -> None:
        """Write it as JSON. Raises BadInput or NoSpace."""
        text = json.dumps(
            {
                "names": list(self.names),
                "mean": self.mean.tolist(),
                "cov": self.cov.tolist(),
                "transform": [LOG] * len(self.names),
            },
            indent=1,
        )
        write_text(path, text + "\n")


def beside(machine_file: Path) -> Path:
    """Where the posterior of a machine's file is."""
    return machine_file.with_suffix(".posterior.json")


def read(path: Path) -> Posterior:
    """A posterior from its file. Raises BadInput."""
    try:
        raw = json.loads(path.read_text(encoding="utf-8"))
        names = tuple(str(name) for name in raw["names"])
        mean, cov = np.array(raw["mean"], np.float64), np.array(raw["cov"], np.float64)
        transforms = list(raw["transform"])
    except FileNotFoundError:
        raise BadInput(
            f"{path} is missing; twin calibrate writes it beside the machine's file"
        ) from None
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise BadInput(f"{path} is no posterior: {error}") from None
    count = len(names)
    if mean.shape != (count,) or cov.shape != (count, count) or len(transforms) != count:
        raise BadInput(f"{path}: names, mean, cov and transform do not fit each other")
    if set(transforms) - {LOG}:
        raise BadInput(f"{path}: transform = {transforms[0]!r}; '{LOG}' would do")
    symmetric = np.isfinite(cov).all() and np.allclose(cov, cov.T)
    if not symmetric or np.linalg.eigvalsh(cov).min() <= 0.0:
        raise BadInput(f"{path}: cov is no covariance: not symmetric, or not positive")
    return Posterior(names, mean, cov)
