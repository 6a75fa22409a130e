"""A scenario of one's own: `twin run wet_hollow:WET_HOLLOW`, from this folder."""

from twin.scenario import Course, Field, Patch, Plough, Scenario, Soil
from twin.sensors import Gnss, Outage, Sensors

WET_HOLLOW = Scenario(
    name="wet-hollow",
    about="60 m of tilled soil on a 3 degree cross-slope, 15 m of it slippery, GNSS masked for 8 s",
    soil=Soil(preset="tilled", rocks_per_100m2=1.0),
    field=Field(
        cross_slope_deg=3.0,
        roughness_class="D",
        patches=(Patch(start_m=30.0, length_m=15.0, friction_factor=0.85),),
    ),
    plough=Plough(depth_m=0.22),
    course=Course(length_m=60.0),
    sensors=Sensors(gnss=Gnss(outages=(Outage(start_s=25.0, duration_s=8.0, kind="mask"),))),
    seed=7,
)
