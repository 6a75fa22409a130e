"""Fusion of two estimates of the same state by their covariances."""

from __future__ import annotations

import numpy as np

from estimators.kalman import Array
from twin.compute.compiled import compiled


@compiled
def fuse(x1: Array, p1: Array, x2: Array, p2: Array) -> tuple[Array, Array]:
    """Inverse-covariance fusion of two estimates taken as independent.

    x = (P1^-1 + P2^-1)^-1 (P1^-1 x1 + P2^-1 x2) = x1 + K (x2 - x1)
    P = (P1^-1 + P2^-1)^-1 = P1 - K P1,   K = P1 (P1 + P2)^-1

    Args:
        x1: first mean, (n,).
        p1: its covariance, (n, n).
        x2: second mean, (n,).
        p2: its covariance, (n, n); p1 + p2 must be regular.
    """
    total, by_total = p1 + p2, np.zeros_like(p1)
    n = len(x1)
    for i in range(n):
        by_total[i, i] = 1.0
    for i in range(n):  # Gauss-Jordan without pivoting: the sum is positive definite
        pivot = total[i, i]
        for k in range(n):
            total[i, k] /= pivot
            by_total[i, k] /= pivot
        for j in range(n):
            factor = total[j, i]
            if j != i:
                for k in range(n):
                    total[j, k] -= factor * total[i, k]
                    by_total[j, k] -= factor * by_total[i, k]
    x, p = x1.copy(), p1.copy()
    for i in range(n):
        for j in range(n):
            gain = 0.0
            for k in range(n):
                gain += p1[i, k] * by_total[k, j]
            x[i] += gain * (x2[j] - x1[j])
            for k in range(n):
                p[i, k] -= gain * p1[j, k]
    return x, p
