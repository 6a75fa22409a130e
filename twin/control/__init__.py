"""Slip controllers for a ploughing tractor: baselines, saved policies, and how they compare.

A controller turns what is seen into throttle and depth set point, and keeps a state:

    init(count) -> state          act(state, seen, period_s) -> (state, actions)

`seen` maps names of observations to arrays (count,), actions are (count, 2) in [-1, 1]. Every gain
may be an array (count,) too, so that one batch of tractors tries many at once.
"""
