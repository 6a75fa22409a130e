"""The laws inside MuJoCo: pure, saved with the state, alike on threads, strangers untouched."""

import mujoco
import numba
import numpy as np
import pytest
from mujoco.batch import Batch
from numba import types
from numba.extending import intrinsic

from tests.simulation.rigs import PLOUGHING, bare_rig, plough_rig, set_controls, soiled, start
from twin.errors import BadInput
from twin.physics import block, callback
from twin.simulation.build import build

INTEGRATION = mujoco.mjtState.mjSTATE_INTEGRATION
FOREIGN = """<mujoco><option timestep="0.002"/>{size}<custom>{numeric}</custom><worldbody>
<geom type="plane" size="5 5 1"/>
<body pos="0 0 0.3"><freejoint/><geom type="box" size=".1 .1 .1"/>
<body pos="0.2 0 0"><joint name="hinge" axis="0 1 0" damping=".1" stiffness="2"/>
<geom type="capsule" size=".02 .1"/></body></body></worldbody><actuator>
<motor joint="hinge" ctrlrange="-1 1"/>{actuator}</actuator></mujoco>"""
NUMERICS = {
    "none": "",
    "other": "<numeric name='a' size='3' data='1 2 3'/>",
    "as long": f"<numeric name='a' size='{block.SIZE}' data='1 2 3'/>",
    "not last": f"<numeric name='a' size='{block.SIZE}' data='{block.MAGIC}'/>"
    "<numeric name='b' data='1'/>",
}
ACTUATORS = {
    "no activation": "",
    "filter": "<general joint='hinge' dyntype='filter' dynprm='.1' gainprm='2'/>",
    "user": "<general name='mine' joint='hinge' dyntype='user' gainprm='2'/>",
}


@intrinsic
def pointer(typing_context, address):
    """An address as the pointer a callback is given."""

    def codegen(context, builder, signature, args):
        return builder.inttoptr(args[0], context.get_value_type(types.voidptr))

    return types.voidptr(types.int64), codegen


def ploughing_state(seconds=3.0):
    """A state in the furrow, and its model."""
    machine = plough_rig()
    data = start(machine)
    set_controls(machine, data, throttle=machine.throttle, differential_lock=1.0, lift=0.0)
    mujoco.mj_step(machine.model, data, round(seconds / machine.model.opt.timestep))
    return machine, data


def state(model, data):
    out = np.empty(mujoco.mj_stateSize(model, INTEGRATION))
    mujoco.mj_getState(model, data, out, INTEGRATION)
    return out


def test_forward_twice_changes_nothing_to_the_bit():
    machine, data = ploughing_state()
    names = ("qacc", "act", "act_dot", "qpos", "qvel", "userdata", "qfrc_passive", "sensordata")
    mujoco.mj_forward(machine.model, data)
    once = {n: getattr(data, n).copy() for n in names}
    mujoco.mj_forward(machine.model, data)
    assert all(np.array_equal(getattr(data, n), once[n]) for n in names)
    assert machine_draft(data) > 5e3  # it was ploughing
    assert np.any(once["act_dot"] != 0.0)


def machine_draft(data):
    return data.userdata[block.MACHINE_SLOTS + block.MachineSlot.DRAFT_N]


def test_a_saved_state_continues_to_the_bit():
    machine, data = ploughing_state()
    saved, controls = state(machine.model, data), data.ctrl.copy()
    mujoco.mj_step(machine.model, data, 500)
    other = mujoco.MjData(machine.model)
    mujoco.mj_setState(machine.model, other, saved, INTEGRATION)
    assert np.array_equal(other.ctrl, controls)
    mujoco.mj_step(machine.model, other, 500)
    assert np.array_equal(state(machine.model, other), state(machine.model, data))


def test_a_reset_forgets_everything():
    machine, data = ploughing_state(0.5)
    fresh = start(machine)
    mujoco.mj_resetData(machine.model, data)
    data.qpos[:], data.qvel[:] = fresh.qpos, fresh.qvel
    for one in (data, fresh):
        set_controls(machine, one, throttle=machine.throttle)
        mujoco.mj_step(machine.model, one, 200)
    assert np.array_equal(state(machine.model, data), state(machine.model, fresh))


def fallen(model):
    """What a block on the ground of a foreign model comes to."""
    data = mujoco.MjData(model)
    data.qvel[:3], data.ctrl[:] = (1.0, 0.3, 0.0), 0.2
    data.act[:] = 0.1
    data.userdata[:] = 7.0
    mujoco.mj_step(model, data, 500)
    return np.concatenate([data.qpos, data.qvel, data.act, data.qfrc_passive, data.userdata])


HEADS = {
    "another version": (90, (block.MAGIC, block.VERSION + 1.0, block.RATE_SLOTS)),
    "no room for the slots": (block.RATE_SLOTS - 1, (block.MAGIC, block.VERSION, block.RATE_SLOTS)),
    "rates among the slots": (90, (block.MAGIC, block.VERSION, 3.0)),
}


@pytest.mark.parametrize("what", HEADS)
def test_a_block_that_is_not_of_this_form_is_left_alone(what):
    bare_rig()  # the callbacks are installed
    room, head = HEADS[what]
    data = " ".join(map(str, (*head, -1.0, -1.0)))
    xml = FOREIGN.format(
        size=f'<size nuserdata="{room}"/>', actuator="",
        numeric=f"<numeric name='tractor_twin' size='{block.SIZE}' data='{data}'/>",
    )  # fmt: skip
    plain = FOREIGN.format(size=f'<size nuserdata="{room}"/>', actuator="", numeric="")
    ours, without = (fallen(mujoco.MjModel.from_xml_string(x)) for x in (xml, plain))
    assert np.array_equal(ours, without)


def test_the_same_block_in_its_right_form_is_heard():
    """So that the refusals above refuse for their own reason."""
    bare_rig()
    data = " ".join(map(str, (block.MAGIC, block.VERSION, block.RATE_SLOTS, -1.0, -1.0)))
    numbers = [float(x) for x in data.split()] + [0.0] * (block.SIZE - 5)
    for w in range(4):
        numbers[block.WHEEL + w * block.Wheel.SIZE] = -1.0
    numbers[block.ENGINE + block.Engine.SHAFT] = -1.0
    xml = FOREIGN.format(
        size=f'<size nuserdata="{block.RATE_SLOTS}"/>', actuator="",
        numeric=f"<numeric name='tractor_twin' size='{block.SIZE}' "
        f"data='{' '.join(map(str, numbers))}'/>",
    )  # fmt: skip
    model = mujoco.MjModel.from_xml_string(xml)
    state = mujoco.MjData(model)
    state.userdata[:] = 7.0
    mujoco.mj_step(model, state)
    assert np.all(state.userdata[block.MACHINE_SLOTS : block.SCRATCH_SLOTS - 1] == 0.0)


def test_a_body_that_nothing_moves_has_no_last_dof():
    model = mujoco.MjModel.from_xml_string(
        "<mujoco><worldbody><body name='post'><geom size='.1'/><body name='arm'>"
        "<geom size='.1'/></body></body><body><freejoint/><geom size='.1'/><body name='rider'>"
        "<geom size='.1'/></body></body></worldbody></mujoco>"
    )
    asked = numba.njit(lambda model, body: callback.last_dof(pointer(model), body))
    found = [asked(model._address, model.body(n).id) for n in ("post", "arm", "rider")]
    assert found == [-1, -1, 5]


@pytest.mark.parametrize("actuator", ACTUATORS)
@pytest.mark.parametrize("numeric", NUMERICS)
def test_a_foreign_model_is_left_alone_to_the_bit(numeric, actuator):
    bare_rig()  # the callbacks are installed
    xml = FOREIGN.format(
        size='<size nuserdata="90"/>', numeric=NUMERICS[numeric], actuator=ACTUATORS[actuator]
    )
    model = mujoco.MjModel.from_xml_string(xml)
    ours = fallen(model)
    mujoco.set_mjcb_passive(None)
    mujoco.set_mjcb_act_dyn(None)
    try:
        without = fallen(model)
    finally:
        callback.install()
    assert np.array_equal(ours, without)


def test_installing_twice_is_once_and_never_over_anothers_callback():
    callback.install()
    callback.install()
    mujoco.set_mjcb_passive(lambda model, data: None)
    try:
        with pytest.raises(BadInput, match="mjcb_passive is already taken"):
            callback.install()
    finally:
        mujoco.set_mjcb_passive(None)
        callback.install()


@pytest.mark.parametrize("threads", [1, 2])
@pytest.mark.parametrize("count", [1, 2, 8])
def test_a_batch_is_mj_step_to_the_bit(count, threads):
    machine, data = ploughing_state(1.0)
    begin = state(machine.model, data)
    steps = 300
    batch = Batch(machine.model, nsim=count, nthread=threads)
    for name in ("qpos", "qvel", "act", "ctrl", "userdata", "qacc_warmstart"):
        batch.bind(name)[:] = getattr(data, name)
    throttle = batch.bind("ctrl")[:, machine.model.actuator("throttle").id]
    throttle[:] = np.linspace(0.4, 0.9, count)
    batch.rollout(steps, record=("userdata",))
    for i in range(count):
        single = mujoco.MjData(machine.model)
        mujoco.mj_setState(machine.model, single, begin, INTEGRATION)
        single.ctrl[machine.model.actuator("throttle").id] = np.linspace(0.4, 0.9, count)[i]
        mujoco.mj_step(machine.model, single, steps)
        for name in ("qpos", "qvel", "act", "userdata"):
            assert np.array_equal(batch.bind(name)[i], getattr(single, name)), (name, i)


def test_each_simulation_of_a_batch_has_its_own_soil():
    """Cone indices set in numeric_data give what models built on such soils give."""
    cone_indices = (450.0, 900.0, 2000.0)
    machine, data = ploughing_state(1.0)
    batch = Batch(machine.model, nsim=3, nthread=2)
    numbers = batch.expand("numeric_data")
    at = machine.model.nnumericdata - block.SIZE + block.SOIL + block.Soil.CONE_INDEX_KPA
    numbers[:, at] = cone_indices
    for name in ("qpos", "qvel", "act", "ctrl"):
        batch.bind(name)[:] = getattr(data, name)
    batch.step(nstep=300)
    for i, cone_index_kpa in enumerate(cone_indices):
        model = build(soiled(PLOUGHING, cone_index_kpa=cone_index_kpa)).model
        single = mujoco.MjData(model)
        for name in ("qpos", "qvel", "act", "ctrl"):
            getattr(single, name)[:] = getattr(data, name)
        mujoco.mj_step(model, single, 300)
        assert np.array_equal(batch.bind("qpos")[i], single.qpos)
    assert len(np.unique(batch.bind("qpos")[:, 0])) == 3


def test_controls_beyond_their_range_act_as_at_its_end():
    machine, data = ploughing_state(0.5)
    begin = state(machine.model, data)
    ends = []
    for throttle, brake in ((1.0, 0.0), (3.0, -2.0)):
        mujoco.mj_setState(machine.model, data, begin, INTEGRATION)
        set_controls(machine, data, throttle=throttle, brake=brake)
        mujoco.mj_step(machine.model, data, 200)
        ends.append(data.qpos.copy())
    assert np.array_equal(*ends)
