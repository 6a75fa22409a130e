"""All checks of an estimator."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from twin.pipeline.estimating import Estimator
from twin.testing.checks import (
    check_absent_columns,
    check_absent_sensors,
    check_causal,
    check_chunks,
    check_columns,
    check_deterministic,
    check_gap,
    check_honest,
    check_input_unchanged,
    check_nan,
    check_states,
    check_time_backwards,
)
from twin.testing.stops import check_restart, check_reverse

CHECKS: tuple[Callable[[Estimator], None], ...] = (
    check_columns, check_chunks, check_causal, check_deterministic, check_states,
    check_input_unchanged, check_absent_sensors, check_absent_columns, check_nan, check_gap,
    check_time_backwards, check_honest, check_reverse, check_restart,
)  # fmt: skip


def check_estimator(
    estimator: Estimator, *, checks: Sequence[Callable[[Estimator], None]] = CHECKS
) -> None:
    """Run the checks, and raise one AssertionError that lists all that failed; see `CHECKS`.

    An estimator whose attribute `offline` is True sees the whole log: it need not be causal.

    Args:
        estimator: with `init(setup) -> state` and `run(state, chunk) -> (state, table)`.
        checks: those to run.

    Example:
        >>> from estimators.ratio import RATIO
        >>> check_estimator(RATIO)
    """
    failed = []
    for check in checks:
        try:
            check(estimator)
        except AssertionError as error:
            failed.append(f"{check.__name__}: {error}")
    if failed:
        raise AssertionError("\n".join(failed))
