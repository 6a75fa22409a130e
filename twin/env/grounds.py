"""The ground of an episode: drawn from a generator, or given through `reset`'s options."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from numpy.random import Generator

from twin.errors import BadInput, UnknownName
from twin.scenario import Soil
from twin.soils import PRESETS

KINDS = ("firm", "tilled", "soft", "grass")
"""Presets an episode draws from, each as likely as the others."""
SPREAD = {
    "friction": (0.85, 1.10),
    "cone_index_kpa": (0.80, 1.25),
    "draft_scale": (0.80, 1.20),
}
"""Range of the uniform factor on each of the preset's numbers."""
OPTIONS = ("soil.preset", *(f"soil.{name}" for name in SPREAD))
"""What `reset`'s options may name; what is named is taken as it is, the rest is drawn."""


@dataclass(frozen=True, kw_only=True)
class Ground:
    """What is drawn for one episode."""

    soil: Soil
    pattern_seed: int
    """Seed of the draft's variation with place."""
    noise_seed: int
    """Seed of the sensors' errors."""

    def info(self) -> dict[str, Any]:
        """The soil by the names of `OPTIONS`."""
        preset = self.soil.resolved()
        return {
            "soil.preset": self.soil.preset,
            **{f"soil.{name}": float(getattr(preset, name)) for name in SPREAD},
        }


def check_options(options: Mapping[str, Any] | None) -> dict[str, Any]:
    """`reset`'s options, checked.

    Raises:
        UnknownName: an option or a preset there is not.
        BadInput: a value that is not of the option's kind.
        OutOfRange: a number outside the range of the scenario's field of that name.
    """
    chosen = dict(options or {})
    for name, value in chosen.items():
        if name not in OPTIONS:
            raise UnknownName("option", name, OPTIONS)
        if name == "soil.preset" and not isinstance(value, str):
            raise BadInput(f"option {name} = {value!r} is not the name of a soil preset")
        if name != "soil.preset":
            chosen[name] = _number(name, value)
    fields: dict[str, Any] = {n.removeprefix("soil."): value for n, value in chosen.items()}
    Soil(**fields)
    return chosen


def draw(generator: Generator, options: Mapping[str, Any]) -> Ground:
    """A ground: preset, then a factor on each of its numbers; options take a drawn value's place.

    The same number of draws is made whatever the options.
    """
    kind = KINDS[int(generator.integers(len(KINDS)))]
    preset = str(options.get("soil.preset", kind))
    numbers: dict[str, Any] = {}
    for name, (low, high) in SPREAD.items():
        drawn = getattr(PRESETS[preset], name) * generator.uniform(low, high)
        numbers[name] = float(options.get(f"soil.{name}", drawn))
    pattern_seed, noise_seed = (int(seed) for seed in generator.integers(2**31, size=2))
    soil = Soil(preset=preset, **numbers)
    return Ground(soil=soil, pattern_seed=pattern_seed, noise_seed=noise_seed)


def _number(name: str, value: Any) -> float:
    try:
        return float(value)
    except (TypeError, ValueError):
        raise BadInput(f"option {name} = {value!r} is not a number") from None
