"""Minimisers: what they reach on standard functions, and what they may never do."""

import importlib

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import qmc

from estimators.optimisers import NAMES, chance, mayfly
from estimators.optimisers.improved_mayfly import good_point_set
from estimators.optimisers.opposition import ETA_MAX, ETA_MIN, lens_image, next_chaos, scale
from twin.compute.compiled import compiled

MINIMISERS = {n: importlib.import_module(f"estimators.optimisers.{n}").minimise for n in NAMES}
COMPILED = {n: m for n, m in MINIMISERS.items() if n != "comparator"}
DIMENSIONS = 10


def rng(seed=0):
    return chance.start(np.random.default_rng(seed))


@compiled
def sphere(x, shift):
    total = 0.0
    for k in range(len(x)):
        total += (x[k] - shift) ** 2
    return total


@compiled
def rastrigin(x, shift):
    total = 10.0 * len(x)
    for k in range(len(x)):
        z = x[k] - shift
        total += z * z - 10.0 * np.cos(2.0 * np.pi * z)
    return total


@compiled
def rosenbrock(x, shift):
    total = 0.0
    for k in range(len(x) - 1):
        a, b = x[k] - shift, x[k + 1] - shift
        total += 100.0 * (b - a * a) ** 2 + (1.0 - a) ** 2
    return total


@compiled
def ackley(x, shift):
    squares, cosines = 0.0, 0.0
    for k in range(len(x)):
        squares += (x[k] - shift) ** 2
        cosines += np.cos(2.0 * np.pi * (x[k] - shift))
    n = len(x)
    return 20.0 + np.e - 20.0 * np.exp(-0.2 * np.sqrt(squares / n)) - np.exp(cosines / n)


@compiled
def outside(x, box):
    """Counts in box[2, 0] how often it was called, in box[2, 1] how often outside the box."""
    box[2, 0] += 1.0
    total = 0.0
    for k in range(len(x)):
        if not box[0, k] <= x[k] <= box[1, k]:
            box[2, 1] += 1.0
        total -= x[k]  # drives against the upper faces
    return total


@compiled
def standard(x, chosen):
    """One function for all, so that each minimiser is compiled once."""
    number, shift, box = chosen
    if number == 0:
        return sphere(x, shift)
    if number == 1:
        return rastrigin(x, shift)
    if number == 2:
        return rosenbrock(x, shift)
    if number == 3:
        return ackley(x, shift)
    return outside(x, box)


FUNCTIONS = {  # number, half-width of the usual box, value that every one of them must come below
    "sphere": (0, 5.12, 1e-2),
    "rastrigin": (1, 5.12, 40.0),
    "rosenbrock": (2, 2.048, 12.0),
    "ackley": (3, 32.768, 1.5),
}
SHIFT = 0.7
"""Off the middle, which the lens would find by itself."""
NO_BOX = np.zeros((3, 1))
SPHERE = (0, SHIFT, NO_BOX)


def median_found(name, minimise, budget=6000, seeds=9, shift=SHIFT):
    number, half, _ = FUNCTIONS[name]
    low, high = np.full(DIMENSIONS, -half), np.full(DIMENSIONS, half)
    chosen = (number, shift, NO_BOX)
    return np.median(
        [minimise(standard, low, high, budget, rng(s), chosen).value for s in range(seeds)]
    )


def random_search(name, budget, seed=0):
    number, half, _ = FUNCTIONS[name]
    points = np.random.default_rng(seed).uniform(-half, half, (budget, DIMENSIONS))
    return min(standard(x, (number, SHIFT, NO_BOX)) for x in points)


def test_the_functions_are_zero_where_they_should_be():
    for name, (number, _, _) in FUNCTIONS.items():
        place = np.full(DIMENSIONS, SHIFT + (name == "rosenbrock"))
        assert standard(place, (number, SHIFT, NO_BOX)) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("function", FUNCTIONS)
@pytest.mark.parametrize("name", MINIMISERS)
def test_standard_functions(name, function):
    found = median_found(function, MINIMISERS[name], seeds=9 if name in COMPILED else 3)
    assert found < FUNCTIONS[function][2]
    assert found < 0.5 * random_search(function, 6000)


@pytest.mark.parametrize("name", MINIMISERS)
def test_more_evaluations_find_more(name):
    few, many = (median_found("sphere", MINIMISERS[name], budget=b, seeds=3) for b in (300, 6000))
    assert many < 0.1 * few


@pytest.mark.parametrize("name", MINIMISERS)
@settings(max_examples=25, deadline=None)
@given(
    low=st.floats(-1e3, 1e3),
    width=st.floats(1e-6, 1e3),
    budget=st.integers(40, 700),
    seed=st.integers(0, 2**31),
)
def test_box_and_budget_are_kept(name, low, width, budget, seed):
    n = 3
    box = np.array([np.full(n, low), np.full(n, low + width), np.zeros(n)])
    found = MINIMISERS[name](standard, box[0], box[1], budget, rng(seed), (4, 0.0, box))
    calls, left = box[2, :2]
    assert left == 0
    assert calls == found.evaluations
    assert budget - mayfly.PER_GENERATION - 1 < found.evaluations <= budget
    assert np.all((found.x >= box[0]) & (found.x <= box[1]))


@pytest.mark.parametrize("name", MINIMISERS)
@pytest.mark.parametrize("function", FUNCTIONS)
def test_the_best_never_gets_worse_and_is_what_is_returned(name, function):
    number, half, _ = FUNCTIONS[function]
    low, high = np.full(4, -half), np.full(4, half)
    chosen = (number, SHIFT, NO_BOX)
    found = MINIMISERS[name](standard, low, high, 1000, rng(3), chosen)
    assert np.all(np.diff(found.history) <= 0)
    assert found.history[-1] == found.value == standard(found.x, chosen)
    assert found.history[0] > found.value


@pytest.mark.parametrize("name", MINIMISERS)
def test_same_seed_same_bits_and_the_state_goes_on(name):
    low, high, state = np.full(4, -5.0), np.full(4, 5.0), rng(7)
    first = MINIMISERS[name](standard, low, high, 500, state, SPHERE)
    second = MINIMISERS[name](standard, low, high, 500, state, SPHERE)
    again = MINIMISERS[name](standard, low, high, 500, rng(7), SPHERE)
    assert again.x.tobytes() == first.x.tobytes()
    assert second.x.tobytes() != first.x.tobytes()


@pytest.mark.parametrize("name", MINIMISERS)
def test_a_moved_and_stretched_box_changes_nothing(name):
    """By powers of two, so that not a bit is lost: the search sees only the unit cube."""
    half = np.full(4, 4.0)
    minimise = MINIMISERS[name]
    at = [
        minimise(standard, -w * half, w * half, 500, rng(5), (0, w * 0.5, NO_BOX))
        for w in (1.0, 8.0)
    ]
    assert at[1].x == pytest.approx(8.0 * at[0].x, rel=1e-12)
    moved = minimise(standard, np.full(4, 12.0), np.full(4, 20.0), 500, rng(5), (0, 16.5, NO_BOX))
    assert moved.x - 16.0 == pytest.approx(at[0].x, abs=1e-6)


@pytest.mark.parametrize("name", COMPILED)
def test_callable_from_compiled_code(name):
    minimise = COMPILED[name]

    @compiled
    def within(low, high, state, chosen):
        return minimise(standard, low, high, 300, state, chosen).value

    low, high = np.full(4, -5.0), np.full(4, 5.0)
    assert (
        within(low, high, rng(), SPHERE) == minimise(standard, low, high, 300, rng(), SPHERE).value
    )


@pytest.mark.parametrize(("count", "n"), [(40, 3), (40, 10), (200, 10)])
def test_good_points_are_more_even_than_random_ones(count, n):
    good = qmc.discrepancy(good_point_set(count, n))
    drawn = [qmc.discrepancy(np.random.default_rng(s).random((count, n))) for s in range(100)]
    assert good < np.quantile(drawn, 0.05)


def test_good_points_are_worse_than_random_ones_in_five_dimensions():
    """p = 13 repeats itself: being good is a matter of n and count, not of the construction."""
    drawn = [qmc.discrepancy(np.random.default_rng(s).random((40, 5))) for s in range(100)]
    assert qmc.discrepancy(good_point_set(40, 5)) > np.quantile(drawn, 0.95)


def test_good_points_are_the_printed_ones():
    """n = 10: p = 23; r_1 = 2 cos(2 pi / 23)."""
    points = good_point_set(40, 10)
    assert points[0, 0] == pytest.approx(2 * np.cos(2 * np.pi / 23) % 1)
    assert points[6, 3] == pytest.approx(7 * 2 * np.cos(8 * np.pi / 23) % 1)
    assert points.min() >= 0
    assert points.max() < 1


@given(st.lists(st.floats(0, 1), min_size=1, max_size=8), st.floats(ETA_MIN, ETA_MAX))
def test_lens(u, eta):
    """((ub + lb)/2 - X) / (X* - (ub + lb)/2) = eta, unless that leaves the cube."""
    u = np.array(u)
    image = lens_image(u, eta)
    assert np.all((image >= 0) & (image <= 1))
    inside = (image > 0) & (image < 1)
    assert (0.5 - u)[inside] == pytest.approx((eta * (image - 0.5))[inside], abs=1e-12)
    assert lens_image(u, 1.0) == pytest.approx(1 - u)


@given(st.floats(0.1, 0.2))
def test_chaos_stays_in_its_range_and_does_not_settle(chaos):
    seen = []
    for _ in range(50):
        chaos = next_chaos(chaos)
        seen.append(scale(chaos))
    assert ETA_MIN <= min(seen) < 0.8
    assert 1.7 < max(seen) <= ETA_MAX


def test_pull_is_the_gaussian():
    r = np.linspace(-1, 1, 201)
    assert [mayfly.pull(x) for x in r] == pytest.approx(np.exp(-2 * r**2) * r, abs=1e-12)


def test_uniform_numbers_are_those_of_the_reference_code():
    """First outputs of xoshiro256++ from the state 1, 2, 3, 4."""
    state = np.array([1, 2, 3, 4], np.uint64)
    for expected in (41943041, 58720359, 3588806011781223, 3591011842654386):
        assert chance.uniform(state) == (expected >> 11) * 2.0**-53


def test_uniform_numbers_are_uniform():
    state = rng(11)
    drawn = np.array([chance.uniform(state) for _ in range(20000)])
    assert np.histogram(drawn, 20, (0, 1))[0] == pytest.approx(1000, rel=0.13)
    assert abs(np.corrcoef(drawn[:-1], drawn[1:])[0, 1]) < 0.03
