"""Remembered types of calls are those that numba finds."""

import operator

import pytest
from numba.core import types
from numba.core.errors import TypingError
from numba.core.registry import cpu_target

from twin.compute.call_types import remembering


def test_a_call_has_the_type_that_numba_gives_it_and_is_asked_for_once():
    own = cpu_target.typing_context
    own.refresh()
    kept = remembering(own)
    for pair in ((types.float64, types.float64), (types.int64, types.float64)):
        found = kept.resolve_function_type(operator.add, pair, {})
        assert found == own.resolve_function_type(operator.add, pair, {})
        assert kept.resolve_function_type(operator.add, pair, {}) is found
    with pytest.raises(TypingError):
        kept.resolve_function_type(operator.add, (types.float64, types.unicode_type), {})
