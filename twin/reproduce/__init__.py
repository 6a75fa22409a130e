"""The papers' experiments, published figures and ours side by side.

Each is a function `rows(trials, jobs) -> list of rows` as `twin.rows` writes them.
"""

REGISTRY: dict[str, str] = {
    "plough-field": "twin.reproduce.plough_field:rows",
    "gnss-mimu": "twin.reproduce.gnss_mimu:rows",
}
"""Experiment -> "module:function"."""

ABOUT: dict[str, str] = {
    "plough-field": "ploughing at 15 to 30 cm: speed, slip, draft, roll, power (Fu et al.)",
    "gnss-mimu": "slip on three roads at 5 to 20 km/h by a four-state filter (Zhang 2018)",
}
