"""Estimators of wheel slip and sideslip: streams in, estimates out, no truth.

An estimator is an object (an instance, a class that needs no argument, or a module) with

    init(setup) -> state
    run(state, chunk) -> (state, estimates)

`setup` is a `twin.streams.Setup`, `chunk` a `twin.streams.Streams` with the samples that arrived
since the last call, and `estimates` a table with `epoch_ns` and whichever of
`twin.streams.ESTIMATES` the estimator knows, NaN where it does not know. A state is a plain value
(a frozen dataclass of numbers and arrays) that can be pickled and kept; `run` returns a new one and
never changes the one it was given. Samples are taken in `Streams.merge_order`. Every estimator is

    causal            what arrives later changes nothing already said
    chunk-invariant   how the samples were cut into chunks changes no bit
    honest            its standard deviations agree with its errors where its model holds

An offline smoother has `offline = True`; it wants the whole log in one chunk, and is neither causal
nor chunk-invariant.

A missing sensor, a missing column and a NaN are measurements that were not made, never an error.
"""

REGISTRY: dict[str, str] = {
    "ratio": "estimators.ratio:RATIO",
    "ratio-front": "estimators.ratio:RATIO_FRONT",
    "four-state": "estimators.four_state:FourState",
    "four-state-printed": "estimators.four_state_printed:FourStatePrinted",
    "kf-z2": "estimators.parallel_kf:KF_Z2",
    "pkf": "estimators.parallel_kf:PKF",
    "kf-tuned": "estimators.parallel_kf:KF_TUNED",
    "pso-pkf": "estimators.adaptive_pkf:PSO_PKF",
    "ma-pkf": "estimators.adaptive_pkf:MA_PKF",
    "ima-pkf": "estimators.adaptive_pkf:IMA_PKF",
    "pso-pkf-log": "estimators.adaptive_pkf:PSO_PKF_LOG",
    "ma-pkf-log": "estimators.adaptive_pkf:MA_PKF_LOG",
    "ima-pkf-log": "estimators.adaptive_pkf:IMA_PKF_LOG",
    "sideslip-ekf": "estimators.sideslip_ekf:SideslipEkf",
    "mmae": "estimators.filter_bank:MMAE",
    "whiteness": "estimators.filter_bank:WHITENESS",
    "inekf": "estimators.inekf:INEKF",
    "slip-ekf": "estimators.slip_ekf:SLIP_EKF",
    "slip-ekf-smooth": "estimators.slip_ekf.smooth:SLIP_EKF_SMOOTH",
}
"""Name -> "module:Attribute"; nothing is imported until the name is asked for."""

GROUPS: dict[str, tuple[str, ...]] = {
    "baselines": ("ratio", "ratio-front"),
    "published": (
        "four-state-printed", "kf-z2", "pkf", "pso-pkf", "ma-pkf", "ima-pkf", "mmae", "whiteness",
        "inekf",
    ),
    "this project's": (
        "four-state", "kf-tuned", "pso-pkf-log", "ma-pkf-log", "ima-pkf-log", "sideslip-ekf",
        "slip-ekf",
    ),
    "offline, of this project": ("slip-ekf-smooth",),
}  # fmt: skip
"""Origin of estimators -> their names; every name is in one group."""
