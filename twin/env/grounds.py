"""The ground of an episode: drawn from a generator, or given through `reset`'s options.

The module is longer than 300 lines because the random draw and the check of options must name the
same quantities and limits.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, TypeAlias

import numpy as np
from numpy.random import Generator

from twin.errors import BadInput, OutOfRange, UnknownName, check_range
from twin.scenario import Field, Patch, Soil
from twin.scenario.field import MOST_PATCHES, check_patches
from twin.scenario.soils import PRESETS, Preset

KINDS = ("firm", "tilled", "soft", "grass")
"""Presets an episode draws from, each as likely as the others."""
SPREAD = {
    "friction": (0.85, 1.10),
    "cone_index_kpa": (0.80, 1.25),
    "draft_scale": (0.80, 1.20),
}
"""Range of the uniform factor on each of the preset's numbers."""
STEEPEST_DEG = {"cross_slope_deg": 6.0, "grade_deg": 3.0}
"""Largest slope drawn, either way."""
FURROW_SPREAD = (0.9, 1.1)
"""Range of the last furrow's depth over the depth ploughed now."""
PATCHES = (2, (3.0, 40.0), (2.0, 10.0), (0.7, 1.0), (0.6, 1.0))
"""Most patches drawn; ranges of start ahead and length [m], of friction and cone index factors."""
FARTHEST_M = 1000.0
"""How far from the field's origin an episode may stand [m]."""
OTHER = "field.other_soil."
"""What the options of the other soil begin with."""
SHAPE_COUNT = 16
"""How many slopes with furrows an episode draws from."""
SHAPE_FIELDS = (*STEEPEST_DEG, "furrow_depth_m")
OPTIONS = (
    "soil.preset",
    *(f"soil.{name}" for name in SPREAD),
    *(f"field.{name}" for name in SHAPE_FIELDS),
    "field.patches",
    "field.origin_m",
)
"""Names of `reset`'s options: these values are taken, the others are drawn."""


Options: TypeAlias = dict[str, Any]
"""Of `reset`, by the names in OPTIONS; users write them."""


@dataclass(frozen=True, kw_only=True)
class Recipe:
    """What an environment's grounds are drawn from."""

    presets: tuple[str, ...] = KINDS
    spread: Mapping[str, tuple[float, float]] = field(default_factory=lambda: SPREAD)
    law: str = "brixius"
    """Soil law: brixius or bekker."""
    heavier: tuple[float, float] | None = None
    """Range of the factor on the preset's draft in areas of heavier soil; None without areas."""
    steepest_deg: Mapping[str, float] = field(default_factory=lambda: STEEPEST_DEG)
    patches: tuple[int, *tuple[tuple[float, float], ...]] = PATCHES
    options: tuple[str, ...] = OPTIONS


PLOUGHED = Recipe()
ROLLED = Recipe(
    presets=("dry", "wet", "firm", "grass"),
    steepest_deg={"cross_slope_deg": 10.0, "grade_deg": 2.0},
    patches=(4, (1.0, 40.0), (2.0, 8.0), (0.5, 1.0), (0.6, 1.0)),
    options=tuple(name for name in OPTIONS if name != "field.furrow_depth_m"),
)
"""Of a tractor without a plough: no furrow, steeper, and patches more often and more slippery."""
SLANTED = Recipe(
    presets=("dry", "wet", "firm", "grass"),
    spread=SPREAD | {"draft_scale": (0.60, 1.40)},
    steepest_deg={"cross_slope_deg": 15.0, "grade_deg": 2.0},
    patches=(4, (1.0, 30.0), (2.0, 6.0), (0.6, 1.0), (0.6, 1.0)),
    options=ROLLED.options,
)
"""Steeper still across, and a draft that differs more from field to field."""
WORKED = Recipe(
    presets=("firm", "tilled", "soft"),
    spread=SPREAD | {"draft_scale": (0.60, 0.85)},
    heavier=(1.15, 1.40),
    options=(*OPTIONS, "soil.law", *(f"{OTHER}{name}" for name in ("preset", *SPREAD))),
)
"""Of fields with areas of another soil; both laws know the presets. D497 gives 40 % either way for
the draft of mould-board ploughs."""


@dataclass(frozen=True, kw_only=True)
class GroundShape:
    """How the field lies: what a tractor has to settle on before an episode."""

    cross_slope_deg: float = 0.0
    grade_deg: float = 0.0
    furrow_depth_m: float = 0.25
    """Depth of the last furrow, in which the right wheels run [m]."""

    def field(self) -> Field:
        """Its slopes as a scenario has them."""
        return Field(cross_slope_deg=self.cross_slope_deg, grade_deg=self.grade_deg)


@dataclass(frozen=True, kw_only=True)
class Ground:
    """What is drawn for one episode."""

    preset: str
    """The soil's."""
    own: Options
    """The soil's own numbers, those of `SPREAD`."""
    shape: GroundShape
    patches: tuple[Patch, ...]
    """Stretches of other soil, `start_m` ahead of the rear axle at the start."""
    origin_m: tuple[float, float]
    """Where on the unbounded field the episode stands, along and to the left [m]."""
    pattern_seed: int
    """Seed of the field: what varies with place."""
    noise_seed: int
    """Seed of the sensors' errors."""
    law: str = "brixius"
    """Soil law: brixius or bekker."""
    other_preset: str | None = None
    """Soil of the other areas of the field; None where there are none."""
    other_own: Options = field(default_factory=dict)
    """That soil's own numbers."""

    @property
    def soil(self) -> Soil:
        """The soil as a scenario has it."""
        return Soil(preset=self.preset, law=self.law, **self.own)

    def info(self, recipe: Recipe = PLOUGHED) -> Options:
        """The ground by the names of the recipe's options."""
        known = {
            "soil.preset": self.preset,
            **{f"soil.{name}": value for name, value in self.own.items()},
            **{f"field.{name}": getattr(self.shape, name) for name in SHAPE_FIELDS},
            "field.patches": tuple(
                (p.start_m, p.length_m, p.friction_factor, p.cone_index_factor)
                for p in self.patches
            ),
            "field.origin_m": self.origin_m,
            "soil.law": self.law,
            "field.other_soil.preset": self.other_preset,
            **{f"field.other_soil.{name}": value for name, value in self.other_own.items()},
        }
        return {name: known[name] for name in recipe.options}


def ground_shapes(depth_m: float, recipe: Recipe = PLOUGHED) -> tuple[GroundShape, ...]:
    """The slopes and furrows an episode draws from, the same for every seed; the first is level.

    Args:
        depth_m: depth ploughed now.
        recipe: how steep they are, and whether there is a furrow.
    """
    generator = np.random.default_rng(0)
    drawn = [GroundShape(furrow_depth_m=depth_m)]
    for _ in range(SHAPE_COUNT - 1):
        slopes = {n: round(generator.uniform(-m, m), 1) for n, m in recipe.steepest_deg.items()}
        furrow_m = min(0.35, max(0.05, depth_m * generator.uniform(*FURROW_SPREAD)))
        if "field.furrow_depth_m" not in recipe.options:
            furrow_m = depth_m
        drawn.append(GroundShape(furrow_depth_m=round(furrow_m, 3), **slopes))
    return tuple(drawn)


def check_options(options: Options | None, recipe: Recipe = PLOUGHED) -> Options:
    """`reset`'s options, checked.

    Raises:
        UnknownName: an option or a preset there is not.
        BadInput: a value that is not of the option's kind.
        OutOfRange: a number outside the range of the scenario's field of that name, or patches
            on which a soil that may be drawn would leave its range.
    """
    chosen = dict(options or {})
    for name, value in chosen.items():
        if name not in recipe.options:
            raise UnknownName("option", name, recipe.options)
        if name.endswith((".preset", ".law")):
            if not isinstance(value, str):
                kind = name.rpartition(".")[2]
                raise BadInput(f"option {name} = {value!r} is not the name of a soil {kind}")
        elif name == "field.patches":
            chosen[name] = _patches(value)
        elif name == "field.origin_m":
            chosen[name] = _numbers(name, value, ("along", "to the left"))
        else:
            chosen[name] = _number(name, value)
    if not chosen:
        return chosen
    law = {"law": chosen["soil.law"]} if "soil.law" in chosen else {}
    Soil(**_part(chosen, "soil."))
    Soil(**_part(chosen, OTHER), **law)
    Field(**{n: v for n, v in _part(chosen, "field.").items() if n in STEEPEST_DEG})
    check_range("field.furrow_depth_m", chosen.get("field.furrow_depth_m", 0.05), 0.05, 0.35)
    for metres in chosen.get("field.origin_m", ()):
        check_range("field.origin_m", metres, -1e6, 1e6)
    for where, soil in _drawable_soils(chosen, recipe):
        check_patches(where, soil, chosen.get("field.patches", ()))
    return chosen


def _drawable_soils(options: Options, recipe: Recipe) -> Iterator[tuple[str, Preset]]:
    """The strongest and the weakest soil of each kind that may be drawn, and its option."""
    heavier = recipe.heavier is not None
    for prefix in ("soil.", OTHER) if heavier else ("soil.",):
        given = _part(options, prefix)
        kinds = (given["preset"],) if "preset" in given else recipe.presets
        for kind, share in itertools.product(kinds, (0.0, 1.0)):
            if kind not in PRESETS:
                raise UnknownName("soil preset of an episode", kind, PRESETS)
            shares = dict.fromkeys(recipe.spread, share)
            own: Options = _own_numbers(PRESETS[kind], given, recipe.spread, shares)
            yield prefix.removesuffix("."), replace(PRESETS[kind], **own)


def draw(
    generator: Generator,
    options: Options,
    choices: Sequence[GroundShape],
    recipe: Recipe = PLOUGHED,
) -> Ground:
    """A ground: soil, shape, patches, origin; options take a drawn value's place.

    The same number of draws is made whatever the options. Drawn patches that would bring a soil out
    of its range together are left out, the last first.
    """
    kind = recipe.presets[int(generator.integers(len(recipe.presets)))]
    preset = str(options.get("soil.preset", kind))
    own_soil: Options = _drawn_soil(generator, preset, _part(options, "soil."), recipe.spread)
    pattern_seed, noise_seed = generator.integers(2**31, size=2).tolist()
    shape = choices[int(generator.integers(len(choices)))]
    own = {name: value for name, value in _part(options, "field.").items() if name in SHAPE_FIELDS}
    drawn = _drawn_patches(generator, recipe)
    along, left = generator.random(2).tolist()
    origin_m = (
        _between((-FARTHEST_M, FARTHEST_M), along),
        _between((-FARTHEST_M, FARTHEST_M), left),
    )
    other_preset, other_own = None, Options()
    if recipe.heavier is not None:
        other_preset, spread = str(options.get(f"{OTHER}preset", preset)), dict(recipe.spread)
        spread["draft_scale"] = recipe.heavier
        other_own = _drawn_soil(generator, other_preset, _part(options, OTHER), spread)
    soils = [replace(PRESETS[preset], **own_soil)]
    if other_preset is not None:
        soils.append(replace(PRESETS[other_preset], **other_own))
    return Ground(
        law=str(options.get("soil.law", recipe.law)),
        other_preset=other_preset,
        other_own=other_own,
        preset=preset,
        own=own_soil,
        shape=replace(shape, **own) if own else shape,
        patches=options["field.patches"] if "field.patches" in options else _had(soils, drawn),
        origin_m=options.get("field.origin_m", origin_m),
        pattern_seed=pattern_seed,
        noise_seed=noise_seed,
    )


def _drawn_soil(
    generator: Generator, preset: str, own: Options, spread: Mapping[str, tuple[float, float]]
) -> Options:
    """A soil's own numbers, drawn around its preset's where they are not given."""
    shares = dict(zip(spread, generator.random(len(SPREAD)).tolist(), strict=True))
    return _own_numbers(PRESETS[preset], own, spread, shares)


def _own_numbers(
    preset: Preset,
    own: Options,
    spread: Mapping[str, tuple[float, float]],
    shares: Mapping[str, float],
) -> Options:
    """A soil's own numbers: those given, else the preset's times a factor of its range."""
    return {
        name: own.get(name, getattr(preset, name) * _between(within, shares[name]))
        for name, within in spread.items()
    }


def _drawn_patches(generator: Generator, recipe: Recipe) -> tuple[Patch, ...]:
    most, *ranges = recipe.patches
    count = int(generator.integers(most + 1))
    shares = generator.random((most, len(ranges))).tolist()
    return tuple(_patch([*map(_between, ranges, row)]) for row in shares[:count])


def _had(soils: Sequence[Preset], patches: tuple[Patch, ...]) -> tuple[Patch, ...]:
    """The first of some drawn patches, as many as the soils can have together."""
    try:
        for soil in soils:
            check_patches("soil", soil, patches)
    except OutOfRange:
        return _had(soils, patches[:-1])
    return patches


def _between(within: tuple[float, float], share: float) -> float:
    """The place a share of the way along a range: uniform, where the share is."""
    low, high = within
    return low + (high - low) * share


def _patch(row: Sequence[float]) -> Patch:
    start_m, length_m, friction, cone_index = row
    return Patch(
        start_m=start_m, length_m=length_m, friction_factor=friction, cone_index_factor=cone_index
    )


def _patches(value: Any) -> tuple[Patch, ...]:
    wanted = ("start_m", "length_m", "friction_factor", "cone_index_factor")
    try:
        rows = list(value)
    except TypeError:
        raise BadInput(f"option field.patches = {value!r} is not a list of patches") from None
    if len(rows) > MOST_PATCHES:
        raise OutOfRange("field.patches", len(rows), f"0 to {MOST_PATCHES} patches")
    return tuple(
        row if isinstance(row, Patch) else _patch(_numbers("field.patches", row, wanted))
        for row in rows
    )


def _part(options: Options, prefix: str) -> Options:
    return {n.removeprefix(prefix): v for n, v in options.items() if n.startswith(prefix)}


def _numbers(name: str, value: Any, wanted: Sequence[str]) -> tuple[float, ...]:
    parts = list(value) if np.iterable(value) and not isinstance(value, str) else []
    if len(parts) != len(wanted):
        raise BadInput(
            f"option {name} = {value!r} is not {len(wanted)} numbers: {', '.join(wanted)}"
        )
    return tuple(_number(name, part) for part in parts)


def _number(name: str, value: Any) -> float:
    try:
        return float(value)
    except (TypeError, ValueError):
        raise BadInput(f"option {name} = {value!r} is not a number") from None
