"""Driving on roads at steady speed, as in Zhang (2018): three surfaces, four speeds."""

from __future__ import annotations

from twin.scenario import Course, Drive, Field, Scenario, Soil

ROUGHNESS = {"asphalt": "A", "gravel": "C", "grass": "D"}
"""Classes of ISO 8608; assumed."""
GEARS = {5: 100.0, 7: 72.0, 10: 52.0, 20: 26.0}
"""Engine turns per turn of the axle for each speed [km/h]: about 1690 rpm in each gear."""


def _road(surface: str, speed_kmh: int) -> Scenario:
    return Scenario(
        name=f"road-{surface}-{speed_kmh}kmh",
        about=f"{surface} at {speed_kmh} km/h, 200 m",
        soil=Soil(preset=surface),
        field=Field(roughness_class=ROUGHNESS[surface]),
        drive=Drive(gear_ratio=GEARS[speed_kmh], engine_set_rpm=1700.0),
        course=Course(approach_m=15.0, length_m=200.0),
    )


ASPHALT_5, ASPHALT_7, ASPHALT_10, ASPHALT_20 = (_road("asphalt", v) for v in GEARS)
GRAVEL_5, GRAVEL_7, GRAVEL_10, GRAVEL_20 = (_road("gravel", v) for v in GEARS)
GRASS_5, GRASS_7, GRASS_10, GRASS_20 = (_road("grass", v) for v in GEARS)
