"""Days in the field: hours with stops, shifts, turns, a refill, and the road there and back.

The day of the T7.165S has the shape of a public log of that tractor (3.3 h at 1 Hz, Padova, 2023;
github.com/lindiap/tractor-field-operations-dataset, CC BY-NC 4.0), of which only statistics stand
here: lengths of its stops, passes of 70 m, engine speeds, and speeds of work, headland and road.
"""

from __future__ import annotations

from dataclasses import replace

from twin.scenario import Course, Drive, Driver, Event, Field, Patch, Plough, Scenario, Soil

ROAD_M = 1500.0


def _road(length_m: float, soil: float) -> Patch:
    """A road of the field's soil, firm by so much, up to a metre before the field."""
    return Patch(
        start_m=-length_m - 50.0, length_m=length_m + 49.0, cone_index_factor=soil,
        friction_factor=1.15,
    )  # fmt: skip


PLOUGHING = Scenario(
    name="field-day-ploughing",
    about="3.4 h of ploughing: 1.5 km of road, 60 passes of 200 m, stops, fuel, and the road back",
    field=Field(roughness_class="C", patches=(_road(ROAD_M, 2.5),)),
    plough=Plough(depth_m=0.22),
    course=Course(length_m=200.0, passes=60, road_m=ROAD_M),
    driver=Driver(
        shifts=True, starts_standing=True, headland_rpm=1300.0, headland_kmh=5.0, road_kmh=25.0
    ),
    events=(
        Event(do="stop", at_m=5.0, for_s=40.0),  # the plough is unfolded
        Event(do="stop", at_m=60.0, in_pass=1, for_s=25.0),  # and its depth looked at
        Event(do="stop", at_m=5.0, in_pass=20, for_s=900.0, engine_off=True),
        Event(do="stop", at_m=120.0, in_pass=33, for_s=90.0),  # a stone
        Event(do="reverse", distance_m=4.0),
        Event(do="stop", at_m=5.0, in_pass=41, for_s=300.0, engine_off=True),
        Event(do="mass", at_m=5.0, in_pass=41, mass_kg=160.0, tank="fuel", rate_kgps=0.8),
        Event(do="lift", when="slip > 0.45", times=50),
        Event(do="lower"),
    ),
)
PLOUGHING_MORNING = replace(
    PLOUGHING,
    name="field-day-ploughing-morning",
    about="the first minutes of field-day-ploughing: 100 m of road, two passes of 30 m, two stops",
    field=Field(roughness_class="C", patches=(_road(100.0, 2.5),)),
    course=Course(length_m=30.0, passes=2, road_m=100.0),
    events=(
        Event(do="stop", at_m=5.0, for_s=5.0),
        Event(do="stop", at_m=30.0, for_s=5.0),
    ),
)

CULTIVATING = Scenario(
    name="field-day-cultivating",
    about="3.6 h of cultivating at 9 km/h with all wheels driven, backing on the headlands",
    implement="cultivator_3m",
    soil=Soil(preset="tilled"),
    field=Field(roughness_class="B", patches=(_road(ROAD_M, 2.5),)),
    plough=Plough(depth_m=0.10, furrow="none"),
    drive=Drive(all_wheel_drive=True, gear_kmh=9.0, engine_set_rpm=2000.0),
    course=Course(length_m=250.0, passes=70, road_m=ROAD_M, headland="backing"),
    driver=Driver(
        shifts=True, starts_standing=True, headland_rpm=1400.0, headland_kmh=5.0, road_kmh=30.0
    ),
    events=(
        Event(do="stop", at_m=3.0, for_s=30.0),
        Event(do="depth", at_m=80.0, depth_m=0.12),
        Event(do="stop", at_m=3.0, in_pass=31, for_s=600.0, engine_off=True),
        Event(do="mass", at_m=3.0, in_pass=31, mass_kg=120.0, tank="fuel", rate_kgps=0.8),
    ),
)
CULTIVATING_PART = replace(
    CULTIVATING,
    name="field-day-cultivating-part",
    about="a part of field-day-cultivating: 50 m of road and two passes of 40 m, backing between",
    field=Field(roughness_class="B", patches=(_road(50.0, 2.5),)),
    course=Course(length_m=40.0, passes=2, road_m=50.0, headland="backing"),
    events=(Event(do="stop", at_m=3.0, for_s=5.0), Event(do="depth", at_m=30.0, depth_m=0.12)),
)

T7165S_PART = Scenario(
    name="field-day-t7165s-part",
    about="half an hour of field-day-t7165s",
    machine="nh_t7165s",
    implement="chisel_3m",
    field=Field(roughness_class="C", patches=(_road(200.0, 2.0),)),
    plough=Plough(depth_m=0.20, furrow="none"),
    drive=Drive(all_wheel_drive=True, engine_set_rpm=2190.0, gear_kmh=8.35),
    course=Course(length_m=50.0, passes=22, road_m=200.0, headland="backing"),
    driver=Driver(
        shifts=True, starts_standing=True, headland_rpm=1450.0, headland_rpm_sd=120.0,
        headland_kmh=4.1, pause_s=1.2, road_rpm=1380.0, road_kmh=14.6,
    ),
    events=(Event(do="stop", at_m=5.0, for_s=30.0),),
)  # fmt: skip
T7165S = replace(
    T7165S_PART,
    name="field-day-t7165s",
    about="3.3 h in the shape of a T7.165S' log: engine off, road, 82 passes, stops",
    field=Field(roughness_class="C", patches=(_road(450.0, 2.0),)),
    course=Course(length_m=50.0, passes=82, road_m=450.0, headland="backing"),
    events=(
        Event(do="stop", at_s=0.0, for_s=4270.0, engine_off=True),
        Event(do="stop", at_m=5.0, for_s=30.0),
        *(
            Event(do="stop", at_m=8.0, in_pass=number, for_s=float(seconds))
            for number, seconds in ((9, 10), (17, 46), (24, 10), (31, 127), (38, 13), (45, 149),
                                    (52, 20), (60, 27), (67, 10), (73, 312), (82, 424))
        ),
    ),
)  # fmt: skip
