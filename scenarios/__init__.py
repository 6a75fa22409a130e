"""What is driven, by name.

A name leads to "module:attribute", so that listing imports nothing heavy.
"""

REGISTRY: dict[str, str] = {
    "plough-15cm": "scenarios.plough:CM_15",
    "plough-20cm": "scenarios.plough:CM_20",
    "plough-25cm": "scenarios.plough:CM_25",
    "plough-30cm": "scenarios.plough:CM_30",
    "slope-8-taishan": "scenarios.slope:TAISHAN_8",
    "road-asphalt-10kmh": "scenarios.road:ASPHALT_10",
}
