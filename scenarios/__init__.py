"""What is driven, by name.

A name leads to "module:attribute", so that listing imports nothing heavy.
"""

REGISTRY: dict[str, str] = {
    "plough-15cm": "scenarios.plough:CM_15",
    "plough-20cm": "scenarios.plough:CM_20",
    "plough-25cm": "scenarios.plough:CM_25",
    "plough-30cm": "scenarios.plough:CM_30",
    "plough-rock": "scenarios.plough:ROCK",
    "plough-slip-patch": "scenarios.plough:SLIP_PATCH",
    "plough-patchy": "scenarios.plough:PATCHY",
    "plough-headland": "scenarios.plough:HEADLAND",
    **{
        f"fault-{kind}": f"scenarios.faults:{kind.upper().replace('-', '_')}"
        for kind in (
            "gnss-dropout",
            "gnss-spike",
            "gnss-frozen",
            "gnss-late",
            "wheels-stuck",
            "wheel-stuck",
            "wheel-missed",
            "imu-saturated",
            "imu-bias",
            "imu-back",
            "camera-black",
            "camera-frozen",
            "camera-dropout",
            "camera-half",
            "all",
        )
    },
    **{
        f"field-day-{part}": f"scenarios.field_day:{part.upper().replace('-', '_')}"
        for part in (
            "ploughing",
            "ploughing-morning",
            "cultivating",
            "cultivating-part",
            "t7165s",
            "t7165s-part",
        )
    },
    "slope-8-taishan": "scenarios.slope:TAISHAN_8",
    **{f"slope-{slope}-taishan": f"scenarios.slope:TAISHAN_{slope}" for slope in (5, 10)},
    **{f"slope-{slope}-plough": f"scenarios.slope:PLOUGH_{slope}" for slope in (5, 10)},
    **{f"slope-{slope}-dry": f"scenarios.slope:DRY_{slope}" for slope in (6, 9, 12, 18)},
    **{f"slope-{slope}-wet": f"scenarios.slope:WET_{slope}" for slope in (9, 18)},
    **{
        f"slope-{slope}-{soil}-masked": f"scenarios.slope:{soil.upper()}_{slope}_MASKED"
        for slope in (9, 18)
        for soil in ("dry", "wet")
    },
    **{
        f"road-{surface}-{kmh}kmh": f"scenarios.road:{surface.upper()}_{kmh}"
        for surface in ("asphalt", "gravel", "grass")
        for kmh in (5, 7, 10, 20)
    },
    "ima-pkf": "scenarios.ima_pkf:CLEAN",
    "ima-pkf-disturbed": "scenarios.ima_pkf:DISTURBED",
}
