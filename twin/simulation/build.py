"""A scenario's machine, ready to run: its hitch set in a trial furrow, settled on its tyres."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

from twin.machine.build import Machine, assemble
from twin.machine.plough_setting import Setting
from twin.scenario import Plough, Scenario
from twin.simulation.settle import settled
from twin.terrain.grid import GridMap


def build(
    scenario: Scenario,
    *,
    looks: bool = False,
    settle: bool = True,
    setting: Setting | None = None,
    maps: dict[str, GridMap] | None = None,
) -> Machine:
    """Assemble the machine of a scenario and let it come to rest on its tyres.

    Args:
        scenario: what is built.
        looks: keep what is only looked at.
        settle: let it come to rest, which driving needs and looking does not.
        setting: how the hitch is set; None leaves it to the operator, who drives a trial furrow
            where the depth is not trimmed on the way.
        maps: of the ground; None for the scenario's.
    """
    find = None
    if scenario.plough is not None and scenario.plough.hitch != "depth" and settle:
        find = partial(_tried, scenario, scenario.plough)
    machine = assemble(scenario, looks=looks, setting=setting, find=find, maps=maps)
    if not settle:
        return machine
    rest = settled(machine.model, machine.start_qpos, machine.world_from_ground, scenario)
    return replace(machine, start_qpos=rest.qpos, start_act=rest.act, start_load_n=rest.load_n)


def _tried(scenario: Scenario, plough: Plough, geometry: Setting) -> Setting:
    from twin.simulation.trial import tried  # the trial is driven on a machine built here

    return tried(scenario, plough, geometry)
