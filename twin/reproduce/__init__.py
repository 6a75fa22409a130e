"""Experiments of papers: the published results compared with the twin's.

Each is a function `rows(trials, jobs) -> list of rows` as `twin.io.result_rows` writes them.
"""

REGISTRY: dict[str, str] = {
    "plough-field": "twin.reproduce.plough_field:rows",
    "gnss-mimu": "twin.reproduce.gnss_mimu:rows",
    "cross-slope": "twin.reproduce.cross_slope:rows",
    "ima-pkf": "twin.reproduce.ima_pkf:rows",
    "ima-pkf-disturbed": "twin.reproduce.ima_pkf_disturbed:rows",
    "ima-pkf-field": "twin.reproduce.ima_pkf_field:rows",
    "slip-ekf": "twin.reproduce.slip_ekf:rows",
    "sideslip-ekf": "twin.reproduce.sideslip_ekf:rows",
    "slip-and-draft": "twin.reproduce.slip_and_draft:rows",
    "speed-and-depth": "twin.reproduce.speed_and_depth:rows",
}
"""Experiment -> "module:function"."""

STORIES: dict[str, str] = {
    "ima-pkf": "twin.reproduce.ima_pkf_story:clean",
    "ima-pkf-disturbed": "twin.reproduce.ima_pkf_story:disturbed",
    "ima-pkf-field": "twin.reproduce.ima_pkf_story:field",
    "sideslip-ekf": "twin.reproduce.sideslip_ekf:said",
    "slip-and-draft": "twin.reproduce.slip_and_draft:said",
    "speed-and-depth": "twin.reproduce.speed_and_depth:said",
}
"""Experiment -> "module:function" that makes a `story.Story` of its rows."""

ABOUT: dict[str, str] = {
    "plough-field": "ploughing at 15 to 30 cm: speed, slip, draft, roll, power (Fu et al.)",
    "gnss-mimu": "slip on three roads at 5 to 20 km/h by a four-state filter (Zhang 2018)",
    "cross-slope": "sideslip across slopes, antennas open and masked (Liu et al. 2023)",
    "ima-pkf": "slip by swarm-adapted parallel Kalman filters in simulated signals (Fu et al.)",
    "ima-pkf-disturbed": "the same with five half-sine disturbances a trial",
    "ima-pkf-field": "the same from the twin's own sensors, ploughing at 15 to 30 cm",
    "slip-ekf": "slip-ekf on both, beside the smallest errors that sensors and motion allow",
    "sideslip-ekf": "sideslip on a platform, ploughing and along slopes, beside the same",
    "slip-and-draft": "slip-and-draft against draft control while ploughing (Roul et al.)",
    "speed-and-depth": "slip control by speed and depth while subsoiling (Luo et al. 2023)",
}
