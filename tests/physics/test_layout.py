"""Struct offsets from introspection against where the arrays of a compiled model really are."""

import ctypes

import mujoco
import numpy as np
import pytest

from tests.simulation.rigs import plough_rig
from twin.physics import callback, layout


@pytest.fixture(scope="module")
def compiled():
    model = plough_rig().model
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return model, data


def word(struct, offset, kind=ctypes.c_void_p):
    return kind.from_address(struct._address + offset).value


@pytest.mark.parametrize("which", ["mjModel", "mjData"])
def test_every_array_is_where_its_pointer_is_said_to_be(compiled, which):
    struct = compiled[0] if which == "mjModel" else compiled[1]
    checked = 0
    for name, kind in layout.struct(which)._fields_:
        array = getattr(struct, name, None)
        if kind is ctypes.c_void_p and isinstance(array, np.ndarray) and array.size:
            pointer = word(struct, layout.offset(which, name))
            if pointer is not None:  # null: in the arena, and made only while constraints act
                assert pointer == array.ctypes.data, name
                checked += 1
    assert checked > 70


def test_every_field_the_callback_reads(compiled):
    model, data = compiled
    arrays = {
        "NUMERIC_ADR": model.numeric_adr, "NUMERIC_SIZE": model.numeric_size,
        "NUMERIC_DATA": model.numeric_data, "ACTUATOR_ACTADR": model.actuator_actadr,
        "BODY_DOFADR": model.body_dofadr, "BODY_DOFNUM": model.body_dofnum,
        "BODY_PARENTID": model.body_parentid, "BODY_ROOTID": model.body_rootid,
        "DOF_PARENTID": model.dof_parentid,
    }  # fmt: skip
    for name, array in arrays.items():
        assert word(model, getattr(callback, name)) == array.ctypes.data, name
        assert array.dtype == (np.float64 if name == "NUMERIC_DATA" else np.int32)
    for name in ("xpos", "xmat", "cvel", "subtree_com", "cdof", "qvel", "act", "ctrl",
                 "qfrc_passive", "userdata"):  # fmt: skip
        array = getattr(data, name)
        assert word(data, getattr(callback, name.upper())) == array.ctypes.data, name
        assert array.dtype == np.float64
    for name in ("nv", "nbody", "nnumeric"):
        at = getattr(callback, name.upper())
        assert word(model, at, ctypes.c_int64) == getattr(model, name)


def test_the_nested_timestep(compiled):
    model, _ = compiled
    before = model.opt.timestep
    try:
        model.opt.timestep = 0.00123
        assert word(model, callback.TIMESTEP, ctypes.c_double) == 0.00123
    finally:
        model.opt.timestep = before
