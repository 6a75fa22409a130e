"""Minimisers of a function of a vector in a box, for the same budget of evaluations.

Each module here has one function

    minimise(function, low, high, budget, rng, given=()) -> Result

`function(x, given)` is the value at x, shape (n,); `given` is whatever else it needs, handed on as
it is. `low` and `high`, (n,), are the box: no x outside it is ever evaluated. `budget` is the most
evaluations; what does not fill a whole iteration is left. `rng` is a state of
`chance`, changed in place: the same state gives the same bits.

`pso`, `mayfly` and `improved_mayfly` are compiled; the function must be too, and they may be called
from compiled code. `comparator` takes any function.
"""

NAMES = ("pso", "mayfly", "improved_mayfly", "comparator")
"""The modules."""
