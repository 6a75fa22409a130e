"""Ploughing at four depths.

The field experiment of Fu et al. (INMATEH 77-13), one parameter set.
"""

from __future__ import annotations

from dataclasses import replace

from twin.scenario import Course, Field, Patch, Plough, Scenario, Soil

CM_25 = Scenario(
    name="plough-25cm",
    about="200 m at 25 cm in firm soil; published mean speed 5.44 km/h",
    field=Field(roughness_class="C"),
    plough=Plough(depth_m=0.25),
)
CM_15 = replace(
    CM_25,
    name="plough-15cm",
    about="200 m at 15 cm in firm soil; published mean speed 6.48 km/h",
    plough=Plough(depth_m=0.15),
)
CM_20 = replace(
    CM_25,
    name="plough-20cm",
    about="200 m at 20 cm in firm soil; published mean speed 5.83 km/h",
    plough=Plough(depth_m=0.20),
)
CM_30 = replace(
    CM_25,
    name="plough-30cm",
    about="200 m at 30 cm in firm soil; published mean speed 5.04 km/h",
    plough=Plough(depth_m=0.30),
)

ROCK = replace(
    CM_25,
    name="plough-rock",
    about="25 cm in firm soil with rocks, two in 100 m2, that pull 15 kN for a sixth of a second",
    soil=Soil(rocks_per_100m2=2.0),
)
SLIP_PATCH = replace(
    CM_25,
    name="plough-slip-patch",
    about="25 cm in firm soil with 10 m of 15 % less grip from 80 m and from 140 m",
    field=Field(
        roughness_class="C",
        patches=(
            Patch(start_m=80.0, length_m=10.0, friction_factor=0.85),
            Patch(start_m=140.0, length_m=10.0, friction_factor=0.85),
        ),
    ),
)
HEADLAND = replace(
    CM_25,
    name="plough-headland",
    about="three passes of 80 m at 25 cm, the plough raised and turned over on the headlands",
    course=Course(length_m=80.0, passes=3),
)
PATCHY = replace(
    CM_25,
    name="plough-patchy",
    about="25 cm in firm soil, a third of it patches of soft soil some 10 m in size",
    field=Field(roughness_class="C", other_share=0.33, other_soil=Soil(preset="soft")),
)
