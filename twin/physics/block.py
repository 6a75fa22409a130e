"""The parameter block of a compiled model, and the slot table by which the callback reports.

The block is the last <numeric> of the model. The block holds every number that the laws need, so a
compiled model is complete, and a Batch can vary the block (`Batch.expand("numeric_data")`).
The slots are `mjData.userdata`. Every forward pass writes the slots from the state at its start.

The module is longer than 300 lines because each number of the block has a line with its unit.
"""

from __future__ import annotations

from enum import IntEnum
from typing import Any, TypeAlias

Part: TypeAlias = dict[Any, float]
"""Numbers of a part of the block, by the places of one of the enumerations below."""

MAGIC = 7.714e38
"""First number of the block; a model without it is left alone, bit for bit."""
VERSION = 7.0
WHEELS = ("fl", "fr", "rl", "rr")


class Head(IntEnum):
    """What the block begins with: identity, random seed, addresses in the model."""

    MAGIC = 0
    VERSION = 1
    RATES = 2  # first slot of the activation rates
    PLOUGH_BODY = 3  # -1 without a plough
    DEPTH_WHEEL_BODY = 4
    SIZE = 5


class Grid(IntEnum):
    """A map over the ground: nodes from 0 to 1 in a height field of the model, row by row."""

    FIRST = 0  # its first node in hfield_data
    ROWS = 1  # across the ground, from the right; 0 without a map
    COLUMNS = 2  # along it
    CELL_M = 3
    START_M = 4  # s of the first column
    RIGHT_M = 5  # t of the first row
    LOW = 6  # value at 0, and from there to that at 1
    RANGE = 7
    REPEATS = 8  # 1: without end; 0: its border goes on
    SIZE = 9


class Field(IntEnum):
    """The ground's shape and what varies over it, in its own frame: s along, t to the left."""

    AHEAD = 0  # unit vectors of the plane through the world's origin, three numbers each
    LEFT = 3
    NORMAL = 6
    SEED = 9
    ORIGIN_S_M = 10  # where on the unbounded field this simulation stands
    ORIGIN_T_M = 11
    FURROW_SIDE = 12  # +1 left, -1 right, 0 none
    FURROW_DEPTH_M = 13
    FURROW_EDGE_M = 14  # |t| of its wall
    FURROW_START_M = 15  # s where it begins, and over what length it gets its depth
    FURROW_RAMP_M = 16
    FURROW_END_M = 17  # s where it begins to rise again, over the same length
    FURROW_WIDTH_M = 18
    WALL_STIFFNESS_NPM = 19
    WALL_DAMPING_NSPM = 20
    PASS_S_M = 21  # where this pass over the field begins, and its way: +1 along, -1 back
    PASS_T_M = 22
    PASS_WAY = 23
    PATCH_COUNT = 24
    PATCHES = 25  # start, end [m], friction and cone index as factors; four of them
    HEIGHTS = 25 + 4 * 4  # a Grid: height above the plane [m]
    MIXTURE = HEIGHTS + 9  # a Grid: share of the other soil [-]
    OTHER = MIXTURE + 9  # that soil, as Soil numbers its own
    ENVELOPES = OTHER + 24  # first node of the heights as wheels feel them, laid as HEIGHTS
    SIZE = ENVELOPES + 1


class Soil(IntEnum):
    """Soil under the wheels and the plough; see twin.scenario.Soil for the meaning."""

    LAW = 0  # its number in twin.scenario.soils.LAWS, or that of a user's law
    FRICTION = 1
    CONE_INDEX_KPA = 2
    SLIP_RATE = 3
    ROLLING_MOMENT = 4
    MOBILITY_RESISTANCE = 5
    DRAFT_SCALE = 6
    DRAFT_CV = 7
    DRAFT_LENGTH_M = 8
    RIPPLE_CV = 9
    STRENGTH_CV = 10
    ROCKS_PER_M2 = 11
    ROCK_N = 12
    K_C = 13  # N/m**(n + 1); from here on Bekker and Wong
    K_PHI = 14  # N/m**(n + 2)
    SINKAGE_EXPONENT = 15
    COHESION_PA = 16
    TAN_PHI = 17
    SHEAR_LONG_M = 18
    SHEAR_LAT_M = 19
    UNIT_WEIGHT_NPM3 = 20
    PEAK = 21  # place of the greatest normal stress over the entry angle, and its growth with slip
    PEAK_SLIP = 22
    SLIP_SINKAGE = 23
    SIZE = 24


class Wheel(IntEnum):
    """One wheel: where it is in the model, its size, its springs."""

    BODY = 0  # -1 where there is no wheel
    SPIN = 1  # address of the joint's velocity
    TYRE = 2  # activation of the deflection along; that across and the contact's slips follow
    WIDTH_M = 3
    DIAMETER_M = 4
    DEFLECTION_RATIO = 5
    FREE_ROLLING_RADIUS_M = 6
    STIFFNESS_NPM = 7
    DAMPING_NSPM = 8
    RELAXATION_LONG_M = 9
    RELAXATION_LAT_M = 10
    LATERAL_RATIO = 11
    SHEAR_DAMPING_S = 12  # damping of the deflections, over load and relaxation length
    NOMINAL_LOAD_N = 13  # at which the relaxation lengths hold, on firm soil
    SHEAR_LONG_NPM = 14  # from here on derived of these: springs between tread and rim,
    SHEAR_LAT_NPM = 15
    SHEAR_DAMPING_LONG_SPM = 16  # and their dampers over the load
    SHEAR_DAMPING_LAT_SPM = 17
    INERTIA_KGM2 = 18  # about the axle
    ENVELOPE = 19  # which of the envelopes is that of its radius
    SLIP_RATE_CHANGE = 20  # relative change of k, c0 and m of Brixius' law by the tyre; 0 for bias
    ROLLING_MOMENT_CHANGE = 21
    MOBILITY_RESISTANCE_CHANGE = 22
    PAIRED = 23  # 1 for two tyres side by side, whose widths and springs are added above; else 0
    SIZE = 24


BUILD = (
    Wheel.SLIP_RATE_CHANGE, Wheel.ROLLING_MOMENT_CHANGE, Wheel.MOBILITY_RESISTANCE_CHANGE,
    Wheel.PAIRED,
)  # fmt: skip
"""Fields that are 0 where a model does not give them: changes by a radial tyre, and pairs."""


class Envelope(IntEnum):
    """Kinds of wheel in the order of their envelope maps: the ground's height as a hub feels it.

    Each kind has two maps, for a wheel that rolls along the ground's s axis and across it.
    """

    FRONT = 0
    REAR = 1
    DEPTH_WHEEL = 2
    SIZE = 3


class Engine(IntEnum):
    """Governed diesel or electric motor, and transmission; see the models' READMEs."""

    RATED_TORQUE_NM = 0
    RATED_RPM = 1
    TORQUE_RISE = 2
    PEAK_RPM = 3
    NO_LOAD_RPM = 4
    IDLE_RPM = 5
    DROOP_RPM_PER_NM = 6
    PARASITIC_NM = 7
    TRANSMISSION_EFFICIENCY = 8
    KIND = 9  # 0 diesel, 1 electric
    MAX_POWER_W = 10  # at the crank, at any speed
    DISPLACEMENT_M3 = 11  # of a diesel, as the stroke
    STROKE_M = 12
    EXHAUST_BRAKE_PA = 13  # mean effective pressure of a closed exhaust brake; 0 without one
    REGENERATION_W = 14  # most that an electric motor takes back; 0 for a diesel
    GEAR_RATIO = 15
    FRONT_RATIO = 16  # turns of the front axle per turn of the rear
    SHAFT = 17  # address of the drive shaft's velocity, at the rear axle's speed; -1 without one
    THROTTLE = 18  # address of the control
    POINT_COUNT = 19  # points of a measured full-load curve; 0 for the parabola
    KEY = 20  # a Key: whether a diesel has fuel, and its starter turns
    POINTS = 21  # speed [rpm] and torque [N m] of each; room for MOST_POINTS
    SIZE = 21 + 2 * 10


class Key(IntEnum):
    """The ignition key."""

    RUN = 0
    OFF = 1
    START = 2


class Coupling(IntEnum):
    """A friction element: elastic up to its capacity, then sliding."""

    CONTROL = 0  # address of the control that applies it
    WINDUP = 1  # address of its activation
    CAPACITY_NM = 2
    WINDUP_RAD = 3  # twist at capacity
    DAMPING_S = 4
    SIZE = 5


COUPLINGS = ("clutch", "lock", "front_drive", "brake_rl", "brake_rr")


class Plough(IntEnum):
    """An implement with a depth wheel; the places of its bodies or tools are its last numbers."""

    BODIES = 0  # bodies or tools
    BODY_WIDTH_M = 1
    DRAFT_A = 2
    DRAFT_B = 3
    DRAFT_C = 4
    DRAFT_WIDTH = 5  # W of D497 for one: its width [m], or 1 where the law is per tool
    FACTOR_MEDIUM = 6  # F of its kind on medium and coarse soil, where a mould-board's is .70, .45
    FACTOR_COARSE = 7
    VERTICAL_RATIO = 8
    FORCE_DEPTH_RATIO = 9
    SIDE_RATIO = 10  # side force of the mould-boards, which the landsides take
    WHEEL_RADIUS_M = 11
    WHEEL_STIFFNESS_NPM = 12
    WHEEL_DAMPING_NSPM = 13
    WHEEL_RESISTANCE_RATIO = 14
    SOIL_STIFFNESS_NPM = 15  # of the soil before one body, until it fails
    LAW = 16  # 0 for D497, or the number of a law of the user's
    SOIL = 17  # activation of the first body's displacement ahead; sideways and the others follow
    SHARES = 18  # x, y, z of each share tip in the implement's frame
    SIZE = 18 + 3 * 16  # room for MOST_SHARES


MOST_SHARES = 16
"""Bodies or tools of an implement, at most."""
MOST_POINTS = 10
"""Points of a measured full-load curve, at most."""
FIELD = int(Head.SIZE)
SOIL = FIELD + int(Field.SIZE)
WHEEL = SOIL + int(Soil.SIZE)
ENGINE = WHEEL + 4 * int(Wheel.SIZE)
COUPLING = ENGINE + int(Engine.SIZE)
PLOUGH = COUPLING + len(COUPLINGS) * int(Coupling.SIZE)
GEAR_RATIO = ENGINE + int(Engine.GEAR_RATIO)
CLUTCH_NM = COUPLING + COUPLINGS.index("clutch") * int(Coupling.SIZE) + int(Coupling.CAPACITY_NM)
"""Where the ratio is, and the clutch's capacity at the axle."""
SIZE = PLOUGH + int(Plough.SIZE)


class WheelSlot(IntEnum):
    """What the callback reports of one wheel."""

    SLIP = 0
    TREAD_SPEED_Y_MPS = 1  # of the tread to the left, where it meets the ground
    LOAD_N = 2
    SHEAR_X_N = 3
    SHEAR_Y_N = 4
    RESISTANCE_N = 5
    ROLLING_MOMENT_NM = 6
    SINKAGE_M = 7
    ROLLING_RADIUS_M = 8
    DEFLECTION_M = 9
    SPEED_X_MPS = 10  # of the hub, along its rolling direction and to the left
    SPEED_Y_MPS = 11
    RATE_RADPS = 12
    WALL_N = 13
    ELASTIC_J = 14  # stored in the tyre's springs and in the furrow's wall
    SPRING_X_N = 15  # force of the tyre's springs on the hub, world axes: load without damping
    SPRING_Y_N = 16
    SPRING_Z_N = 17
    SIZE = 18


class MachineSlot(IntEnum):
    """What the callback reports of engine, plough and ground, after the four wheels."""

    ENGINE_RADPS = 0
    ENGINE_TORQUE_NM = 1
    AXLE_TORQUE_NM = 2
    DRAFT_X_N = 3  # summed soil force on the bodies and the depth wheel, world axes
    DRAFT_Y_N = 4
    DRAFT_Z_N = 5
    DRAFT_N = 6  # its part against the motion
    DEPTH_M = 7
    DEPTH_WHEEL_N = 8
    BRAKE_TORQUE_NM = 9
    SIDE_N = 10  # soil force on the plough to the left
    LANDSIDE_N = 11
    ELASTIC_J = 12  # stored beside the wheels: driveline, depth wheel, soil before the shares
    SIZE = 13


class PowerSlot(IntEnum):
    """Power that leaves the machine by each way [W], from that way's own force and speed."""

    ENGINE = 0  # what the crank gives: the source, counted positive
    PARASITIC = 1
    TRANSMISSION = 2
    DRIVELINE = 3  # clutch, lock and front drive: slip, damping and wind-up
    BRAKE = 4
    SLIP_LONG = 5
    SLIP_LAT = 6
    ROLLING = 7
    TYRE = 8  # vertical springs and dampers
    WALL = 9
    DRAWBAR = 10  # soil on the shares, and the drag of the depth wheel
    DEPTH_WHEEL = 11  # its spring and damper
    JOINT = 12  # damping of joints and tendons
    SIZE = 13


MACHINE_SLOTS = 4 * int(WheelSlot.SIZE)
POWER_SLOTS = MACHINE_SLOTS + int(MachineSlot.SIZE)
SCRATCH_SLOTS = POWER_SLOTS + int(PowerSlot.SIZE)
"""The soil at the place of one wheel or share, while its force is computed."""
RATE_SLOTS = SCRATCH_SLOTS + int(Soil.SIZE)
"""First of the slots by which mjcb_passive hands the activation rates to mjcb_act_dyn."""
