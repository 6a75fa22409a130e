"""How the state moves, and its error with it.

    R' = R (w - b_g - n_g)^,   v' = R (f - b_f - n_f) + g,   u' = R n_u
    b_g', b_f' and the rate of the towed wheels' scale are white

With the error X = Exp(xi) X^ the model is group-affine but for the biases, so with all axes of the
unit the error's own law does not depend on the attitude:

    phi' = -R (G b_g + n_g)
    nu'  = R M R^T g^ phi - R (M b_f + n_f) - v^ R (G b_g + n_g)
    mu'  = R n_u - u^ R (G b_g + n_g)

Here b_g and b_f are the biases' errors, and v^ the matrix of v x. G and M are the identity with a
gyro and an accelerometer at each axis; where one is missing that rate or acceleration is noise.
"""

from __future__ import annotations

import math

import numpy as np

from estimators.inekf.group import rotation, skew, times, turn, turn_back
from estimators.inekf.layout import (
    ACCEL_BIAS,
    ATTITUDE,
    FRONT_SCALE,
    GYRO_BIAS,
    SIZE,
    SLIP,
    VELOCITY,
)
from estimators.kalman import Array, Record, predict
from estimators.layout import GRAVITY_MPS2
from twin.compute.compiled import compiled

LEVEL_PSD, YAW_PSD, PUSH_PSD = 1e-5, 0.01, 0.1
"""Densities of the rates of roll and pitch and of the yaw rate [rad2/s], and of the acceleration
[m2/s3], along axes that no inertial unit measures."""


@compiled
def gravity() -> Array:
    """Acceleration of free fall in the world [m/s2]."""
    fall = np.zeros(3)
    fall[2] = -GRAVITY_MPS2
    return fall


@compiled
def there(sample: Array) -> Array:
    """Diagonal matrix, (3, 3), with 1 for each axis that is measured."""
    out = np.zeros((3, 3))
    for i in range(3):
        out[i, i] = 1.0 if math.isfinite(sample[i]) else 0.0
    return out


@compiled
def rates(memory: Record) -> Array:
    """Turn rates of the body, (3,) [rad/s]; 0 about axes without a gyro."""
    rate = np.zeros(3)
    for i in range(3):
        if math.isfinite(memory.gyro[i]):
            rate[i] = memory.gyro[i] - memory.gyro_bias[i]
    return rate


@compiled
def push(nominal: Record, memory: Record) -> Array:
    """Acceleration of the inertial unit in the world, (3,) [m/s2].

    R (f - b_f) + g;  along a body axis without an accelerometer it is 0.
    """
    weight = turn_back(memory.world_from_body, gravity())
    force = -weight
    for i in range(3):
        if math.isfinite(memory.accel[i]):
            force[i] = memory.accel[i] - memory.accel_bias[i] - (1.0 - nominal.gravity) * weight[i]
    return turn(memory.world_from_body, force + weight)


@compiled
def carry(dt: float, nominal: Record, tuning: Record, memory: Record) -> None:
    """Carry mean and covariance over a step of dt [s]."""
    error_law, noise = law(nominal, tuning, memory)
    q = np.zeros((SIZE, SIZE))
    for k in range(noise.shape[1]):
        for i in range(SIZE):
            if noise[i, k] != 0.0:
                for j in range(SIZE):
                    q[i, j] += dt * noise[i, k] * noise[j, k]
    predict(np.zeros(SIZE), memory.p, transition(error_law, dt), q)
    half = rotation(0.5 * dt * rates(memory))
    middle = times(memory.world_from_body, half)
    before = memory.world_from_body.copy()
    memory.world_from_body[:, :] = middle
    acceleration = push(nominal, memory)
    for i in range(3):
        memory.v[i] += dt * acceleration[i]
    memory.world_from_body[:, :] = times(before, times(half, half))


@compiled
def transition(error_law: Array, dt: float) -> Array:
    """I + A dt + (A dt)^2 / 2, exact but for terms of the third order in dt."""
    f = np.eye(SIZE)
    for i in range(SIZE):
        for k in range(SIZE):
            if error_law[i, k] != 0.0:
                f[i, k] += dt * error_law[i, k]
                for j in range(SIZE):
                    f[i, j] += 0.5 * dt * dt * error_law[i, k] * error_law[k, j]
    return f


@compiled
def law(nominal: Record, tuning: Record, memory: Record) -> tuple[Array, Array]:
    """A of the error's law xi' = A xi + B n, and B times the root of n's density."""
    r = np.ascontiguousarray(memory.world_from_body)
    pushed, turned = times(r, there(memory.accel)), times(r, there(memory.gyro))
    by_v, by_u = skew(memory.v), skew(memory.u)
    noisy_v, noisy_u = times(by_v, r), times(by_u, r)
    by_v, by_u = times(by_v, turned), times(by_u, turned)
    fall = times(times(pushed, np.ascontiguousarray(r.T)), skew(gravity()))
    gyro, accel = _densities(nominal, tuning, memory)
    a, b = np.zeros((SIZE, SIZE)), np.zeros((SIZE, SIZE))
    for i in range(3):
        for k in range(3):
            a[VELOCITY + i, ATTITUDE + k] = fall[i, k]
            a[ATTITUDE + i, GYRO_BIAS + k] = -turned[i, k]
            a[VELOCITY + i, GYRO_BIAS + k] = -by_v[i, k]
            a[SLIP + i, GYRO_BIAS + k] = -by_u[i, k]
            a[VELOCITY + i, ACCEL_BIAS + k] = -pushed[i, k]
            b[ATTITUDE + i, k] = -r[i, k] * math.sqrt(gyro[k])
            b[VELOCITY + i, k] = -noisy_v[i, k] * math.sqrt(gyro[k])
            b[SLIP + i, k] = -noisy_u[i, k] * math.sqrt(gyro[k])
            b[VELOCITY + i, 3 + k] = -r[i, k] * math.sqrt(accel[k])
            b[SLIP + i, 6 + k] = r[i, k] * math.sqrt(tuning.skid_psd if k else tuning.slip_psd)
        b[GYRO_BIAS + i, 9 + i] = math.sqrt(tuning.gyro_bias_psd)
        b[ACCEL_BIAS + i, 12 + i] = math.sqrt(tuning.accel_bias_psd)
    b[FRONT_SCALE, 15] = math.sqrt(tuning.front_scale_psd)
    return a, b


@compiled
def _densities(nominal: Record, tuning: Record, memory: Record) -> tuple[Array, Array]:
    """Densities of the noise of turn rates [rad2/s] and accelerations [m2/s3], by body axis."""
    gyro, accel = np.full(3, LEVEL_PSD), np.full(3, PUSH_PSD)
    gyro[2] = YAW_PSD
    for i in range(3):
        if math.isfinite(memory.gyro[i]):
            gyro[i] = tuning.gyro_psd
        if math.isfinite(memory.accel[i]):
            accel[i] = tuning.accel_psd
    return gyro, accel
