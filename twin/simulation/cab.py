"""The driver's hands and feet: gear, throttle, clutch, brake and key, one decision at a time.

What is wanted comes as `Orders`; what a machine lets a driver do, and how long it takes, stands
here. Every function gives the next `Cab` from the last.

The module has about 300 lines because all driving states (starting, braking, shifting, driving)
read and set the same few controls; in separate modules their order could not be read in one place.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from twin.physics.block import Key
from twin.simulation.controls import towards, within

STILL_MPS = 0.05
"""Slower than this the machine stands."""
THROTTLE_PER_S = 0.5
"""How fast the throttle is moved over its travel [1/s]; derived: chosen so that changes of engine
speed match a log of one New Holland T7.165S (docs/field-days.md), and used for every machine."""
PRESS_PER_S, FOOT_PER_S = 5.0, 3.0
"""How fast a clutch is opened and a brake pressed [1/s]; assumed."""
HALT_MPS2 = 1.2
"""Deceleration that a driver brakes with to a stand [m/s2]; assumed."""
HARDER_PER_MPS = 0.6
"""Pedal per speed above the one that this deceleration would have left [s/m]; assumed."""
HOLDS_MPS = 0.4
"""Below this speed the pedal goes down to hold the machine [m/s]; assumed."""
FEED_S = 1.2
"""Time in which a driver feeds in the clutch where the engine allows it [s]; assumed."""
BITES = 0.3
"""Engagement of the clutch at which the brake is off, that a machine does not roll back; of a motor
the throttle."""
STALLS, HOLDS = 0.65, 1.15
"""Engine speed over idle at which the driver opens the clutch again, and at which he feeds it in
without a pause [-]; assumed."""
LETS_SLIP = 4.0
"""Speed of opening the clutch over the speed of closing the clutch [-]; assumed."""
DEAD, RUNS = 0.45, 0.8
"""Engine speed over idle below which it has died, and above which it runs by itself [-]."""
MODULATED, SHIFT_S = 0.35, 0.6
"""Engagement at which the next clutch of a powershift begins, and the time to the next step [-, s];
assumed, shifts take 0.4 to 0.8 s."""
SYNCHRONISED_S = 0.7
"""Time for the lever of a synchronised gear, the clutch open [s]; assumed."""
STEPLESS_PER_S = 0.35
"""How fast a CVT changes the logarithm of its ratio [1/s]; assumed."""
LUGS, LUG_LOAD = 0.82, 0.9
"""Engine speed over its set speed, and load, at which it lugs [-]; assumed."""
SPARE_LOAD, SPARE_RPM = 0.8, 0.93
"""Load that the next gear may have, and speed over the set speed, to shift up [-]; assumed."""
UP_S = 0.8
"""How long that lasts before a driver shifts up [s]; assumed."""
LAUNCH_KMH = 9.0
"""Fastest gear, by its speed at the set engine speed, that a driver who shifts sets off in."""


class Gears(NamedTuple):
    """Constants of the transmission, the engine and the driver that decisions are made with."""

    kind: str
    ratios: tuple[float, ...]
    """Ratios from the slowest gear to the fastest; for a CVT, its two limits."""
    idle_rpm: float
    no_load_rpm: float
    rim_m: float
    pedal_per_mps2: float
    """Brake pedal that slows the machine by 1 m/s2."""
    reaction_s: float
    pause_s: float
    """Time at standstill before the driver changes the direction of travel."""
    shifts: bool
    """Whether the driver shifts down when the engine is overloaded, and later up again."""

    @property
    def stalls(self) -> bool:
        """Whether the engine can stall, so that the driver must open the clutch in time."""
        return self.kind != "electric"

    def set_rpm(self, throttle: float) -> float:
        """No-load engine speed set by a throttle position in [0, 1]."""
        return self.idle_rpm + throttle * (self.no_load_rpm - self.idle_rpm)

    def throttle(self, set_rpm: float) -> float:
        """Throttle position in [0, 1] that sets a no-load engine speed."""
        return (set_rpm - self.idle_rpm) / (self.no_load_rpm - self.idle_rpm)


class Orders(NamedTuple):
    """What the driver shall do in this interval: ratio, direction, engine, brake."""

    ratio: float
    """Engine turns per turn of the rear axle, above 0."""
    throttle: float
    way: int = 1
    """Direction of travel: 1 forward, -1 backward."""
    stands: bool = False
    off: bool = False
    """The engine, while it stands."""
    clutch_pedal: float = 0.0
    """At least so far down, as the brake."""
    brake_pedal: float = 0.0


class Felt(NamedTuple):
    """Measured state of the machine on which the driver decides."""

    engine_rpm: float
    speed_mps: float
    """Ground speed: positive forward, negative backward."""
    load: float
    """Torque over full-load torque."""
    rim_mps: float = 0.0
    """Wheel speed w R of the driven wheels: angular speed times rolling radius."""


class Cab(NamedTuple):
    """Positions of the controls, and the timers and counters kept between intervals."""

    ratio: float
    """Ratio of the engaged gear; negative in reverse."""
    throttle: float
    grip: float = 1.0
    """Engagement of the clutch: 0 open, 1 closed."""
    brake: float = 0.0
    key: int = Key.RUN
    standing: bool = False
    """Stopped, the clutch open, the brake on."""
    busy_s: float = 0.0
    """Until the next shift, or until the lever of a synchronised gear has been moved."""
    into: float = 0.0
    """Gear that a synchronised shift goes into; 0 for none."""
    fewer: int = 0
    """Gears below the one that is wanted, as the engine lugs, or has not yet been shifted up."""
    asked_mps: float = math.inf
    """Speed that is left as the machine is slowed down."""
    lug_s: float = 0.0
    spare_s: float = 0.0
    """How long the engine has lugged, or had torque to spare."""


def operate(gears: Gears, orders: Orders, last: Cab, felt: Felt, dt_s: float) -> Cab:
    """The cab after the next interval."""
    last = last._replace(busy_s=max(0.0, last.busy_s - dt_s))
    if last.key == Key.START and felt.engine_rpm < RUNS * gears.idle_rpm:
        return _cranked(last)
    if orders.stands or orders.way * last.ratio < 0.0:
        return _halted(gears, orders, last, felt, dt_s)
    dead = felt.engine_rpm < DEAD * gears.idle_rpm
    if gears.stalls and (last.key == Key.OFF or dead):
        return _cranked(last)
    last = last._replace(key=int(Key.RUN))
    if last.standing:
        return _set_off(gears, orders, last)
    return _driven(gears, orders, last, felt, dt_s)


def _cranked(last: Cab) -> Cab:
    """The starter turns an engine that is off or has died, the clutch open."""
    return last._replace(
        key=int(Key.START), grip=0.0, throttle=0.0, brake=max(last.brake, 0.5), into=0.0
    )


def _halted(gears: Gears, orders: Orders, last: Cab, felt: Felt, dt_s: float) -> Cab:
    """Slowed down to a stand; there the gear for the other way goes in.

    pedal = clip(a m r / (2 C) + k (|v| - v_a), 0, 1)     v_a falls by a from where it began
    """
    speed_mps, still = abs(felt.speed_mps), abs(felt.speed_mps) < STILL_MPS
    throttle = towards(last.throttle, 0.0, THROTTLE_PER_S * dt_s)
    if last.standing:
        key = Key.OFF if orders.off else Key.RUN
        ratio = last.ratio if last.busy_s > 0.0 else math.copysign(last.ratio, orders.way)
        return last._replace(throttle=throttle, brake=1.0, key=int(key), ratio=ratio)
    asked_mps = max(0.0, min(last.asked_mps, speed_mps + HALT_MPS2) - HALT_MPS2 * dt_s)
    pedal = HALT_MPS2 * gears.pedal_per_mps2 + HARDER_PER_MPS * (speed_mps - asked_mps)
    pedal = 1.0 if speed_mps < HOLDS_MPS else within(0.0, pedal, 1.0)
    pedal = towards(last.brake, pedal, FOOT_PER_S * dt_s)
    grip = last.grip
    if gears.stalls and (felt.engine_rpm < HOLDS * gears.idle_rpm or speed_mps < 0.3):
        grip = max(0.0, grip - PRESS_PER_S * dt_s)
        grip = 0.0 if felt.engine_rpm < STALLS * gears.idle_rpm else grip
    elif not gears.stalls and still:
        grip = 0.0  # a motor that stands is switched off
    standing = still and grip == 0.0
    pause_s = gears.pause_s if standing else 0.0
    return last._replace(
        busy_s=pause_s, throttle=throttle, brake=pedal, grip=grip, standing=standing, into=0.0,
        asked_mps=asked_mps,
    )  # fmt: skip


def _set_off(gears: Gears, orders: Orders, last: Cab) -> Cab:
    """The gear to start in goes in, while the brake still holds."""
    ratio, fewer = orders.ratio, 0
    if gears.kind == "cvt":
        ratio = gears.ratios[0]
    elif gears.shifts and len(gears.ratios) > 1:
        at = gears.ratios.index(orders.ratio)
        most = gears.set_rpm(orders.throttle) * math.pi / 30.0 * gears.rim_m / (LAUNCH_KMH / 3.6)
        slow = max((i for i, known in enumerate(gears.ratios) if known >= most), default=0)
        start = min(at, max(slow, 0))
        ratio, fewer = gears.ratios[start], at - start
    grip = 0.0 if gears.stalls else 1.0
    return last._replace(
        ratio=math.copysign(ratio, orders.way), fewer=fewer, standing=False, grip=grip, busy_s=0.0,
        lug_s=0.0, spare_s=0.0,
    )  # fmt: skip


def _driven(gears: Gears, orders: Orders, last: Cab, felt: Felt, dt_s: float) -> Cab:
    """On the way: throttle, clutch, gears."""
    throttle = towards(last.throttle, orders.throttle, THROTTLE_PER_S * dt_s)
    now = last._replace(throttle=throttle, asked_mps=math.inf)
    if last.into:
        return _levered(now, dt_s)
    if gears.stalls:
        now = now._replace(grip=_fed(gears, now.grip, felt.engine_rpm, orders.clutch_pedal, dt_s))
    takes = now.grip if gears.stalls else throttle
    now = now._replace(brake=min(last.brake, max(0.0, 1.0 - takes / BITES)))
    if gears.shifts:
        now = _heeded(gears, orders, now, felt, dt_s)
    return _shifted(gears, orders, now, felt, dt_s)


def _fed(gears: Gears, grip: float, engine_rpm: float, pedal: float, dt_s: float) -> float:
    """The clutch let in as fast as the engine bears it, and opened again where it would stall.

    d grip / dt = (n - n_h) / (n_h - n_s) / 1.2 s, limited to [-4, 1] / 1.2 s, between the speeds
    that hold (n_h less what is half of it) and stall.
    """
    middle = 0.5 * (STALLS + HOLDS) * gears.idle_rpm
    room = (engine_rpm - middle) / (HOLDS * gears.idle_rpm - middle)
    room = within(-1.0, room, 1.0)
    rate = (room if room > 0.0 else LETS_SLIP * room) / FEED_S
    return within(0.0, grip + rate * dt_s, 1.0 - pedal)


def _heeded(gears: Gears, orders: Orders, now: Cab, felt: Felt, dt_s: float) -> Cab:
    """A gear less where the engine has lugged, one more where it has torque to spare."""
    if len(gears.ratios) < 2 or gears.kind == "cvt":
        return now
    at, step = _target(gears, orders, now), 1.0
    set_rpm = gears.set_rpm(now.throttle)
    if at + 1 < len(gears.ratios):
        step = gears.ratios[at] / gears.ratios[at + 1]
    asked = now.throttle == orders.throttle
    engaged = asked and now.grip == 1.0
    lugs = asked and now.busy_s == 0.0 and felt.load > LUG_LOAD and felt.engine_rpm < LUGS * set_rpm
    spare = engaged and felt.load * step < SPARE_LOAD and felt.engine_rpm > SPARE_RPM * set_rpm
    lug_s, spare_s = (
        t + dt_s if on else 0.0 for t, on in ((now.lug_s, lugs), (now.spare_s, spare))
    )
    fewer = now.fewer
    if lug_s > gears.reaction_s and at > 0:
        fewer, lug_s, spare_s = fewer + 1, 0.0, 0.0
    elif spare_s > max(UP_S, gears.reaction_s) and fewer > 0:
        fewer, lug_s, spare_s = fewer - 1, 0.0, 0.0
    return now._replace(fewer=fewer, lug_s=lug_s, spare_s=spare_s)


def _target(gears: Gears, orders: Orders, now: Cab) -> int:
    """Place of the gear that is wanted now."""
    return max(0, gears.ratios.index(orders.ratio) - now.fewer)


def _shifted(gears: Gears, orders: Orders, now: Cab, felt: Felt, dt_s: float) -> Cab:
    """On towards the gear that is wanted, as the transmission does it."""
    way = math.copysign(1.0, now.ratio)
    if gears.kind == "cvt":
        return now._replace(ratio=way * _stepless(gears, orders, now, felt, dt_s))
    wanted = gears.ratios[_target(gears, orders, now)]
    if wanted == abs(now.ratio) or now.busy_s > 0.0:
        return now
    if gears.kind == "synchronised":
        return now._replace(into=way * wanted)
    at, to = gears.ratios.index(abs(now.ratio)), gears.ratios.index(wanted)
    step = gears.ratios[at + (1 if to > at else -1)]
    grip = min(now.grip, MODULATED) if gears.stalls else now.grip
    return now._replace(ratio=way * step, grip=grip, busy_s=SHIFT_S)


def _levered(now: Cab, dt_s: float) -> Cab:
    """A synchronised shift: the clutch opened, the lever moved; then it is fed in again."""
    throttle = towards(now.throttle, 0.0, 2.0 * THROTTLE_PER_S * dt_s)
    grip = max(0.0, now.grip - PRESS_PER_S * dt_s)
    if now.grip > 0.0:
        return now._replace(throttle=throttle, grip=grip, busy_s=SYNCHRONISED_S)
    if now.busy_s > 0.0:
        return now._replace(throttle=throttle)
    return now._replace(ratio=now.into, into=0.0)


def _stepless(gears: Gears, orders: Orders, now: Cab, felt: Felt, dt_s: float) -> float:
    """Towards the ratio that is wanted, and back where the engine lugs."""
    ratio, step = abs(now.ratio), STEPLESS_PER_S * dt_s
    wanted = orders.ratio
    if felt.load > LUG_LOAD and felt.engine_rpm < LUGS * gears.set_rpm(now.throttle):
        wanted = gears.ratios[0]
    change = within(-step, math.log(wanted / ratio), step)
    return within(gears.ratios[1], ratio * math.exp(change), gears.ratios[0])
