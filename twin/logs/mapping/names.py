"""What the name of a signal says of its quantity and its unit, in the languages of loggers."""

from __future__ import annotations

import re

from twin.logs.quantities import QUANTITIES

_LEFT, _RIGHT = r"(left|links|\bl\b|li\b)", r"(right|rechts|\br\b|re\b)"
_FRONT, _REAR = r"(front|vorn|\bf\b|\bv\b)", r"(rear|hinten|back|\br\b|\bh\b)"
_TURNS = r"(wheel|speed|vel|rad\b|rpm)"

QUANTITY_NAMES: tuple[tuple[str, str], ...] = (
    (r"(true|ref|reference).*(side ?slip|drift)", "reference.sideslip_angle"),
    (r"^(true|ref|reference) .*\bslip|\bslip.*(ref|true)|^slip$", "reference.slip"),
    (r"(engine|motor|eng).*(speed|rpm|drehzahl)|^n_?eng|^rpm$|drehzahl.*motor",
     "machine.engine_speed"),
    (r"(engine|motor|eng).*(load|last)|percent load|^load$|auslastung", "machine.engine_load"),
    (r"fuel.*(rate|flow|cons)|(rate|flow).*fuel|verbrauch|kraftstoff|consumption|^fuel",
     "machine.fuel_rate"),
    (r"draft|draught|zugkraft|(pull|drawbar|pin).*(force|load)|^f_?x$|^pull", "machine.draft_pin"),
    (r"axle.*torque|torque.*axle|achs.*moment", "machine.axle_torque"),
    (r"steer|lenk", "machine.steer"),
    (r"hitch.*(height|pos)|hubwerk", "machine.hitch"),
    (r"(tick|count|puls|enc).*(fl\b|front left|vl\b)", "wheels.ticks_fl"),
    (r"(tick|count|puls|enc).*(fr\b|front right|vr\b)", "wheels.ticks_fr"),
    (r"(tick|count|puls|enc).*(rl\b|rear left|hl\b)", "wheels.ticks_rl"),
    (r"(tick|count|puls|enc).*(rr\b|rear right|hr\b)", "wheels.ticks_rr"),
    (rf"^(v |w |wheel ?)?(fl|vl)$|{_TURNS}.* (fl|vl)\b|(fl|vl) .*{_TURNS}"
     rf"|{_FRONT}.*{_LEFT}.*{_TURNS}|{_TURNS}.*{_FRONT}.*{_LEFT}", "wheels.speed_fl"),
    (rf"^(v |w |wheel ?)?(fr|vr)$|{_TURNS}.* (fr|vr)\b|(fr|vr) .*{_TURNS}"
     rf"|{_FRONT}.*{_RIGHT}.*{_TURNS}|{_TURNS}.*{_FRONT}.*{_RIGHT}", "wheels.speed_fr"),
    (rf"^(v |w |wheel ?)?(rl|hl)$|{_TURNS}.* (rl|hl)\b|(rl|hl) .*{_TURNS}"
     rf"|{_REAR}.*{_LEFT}.*{_TURNS}|{_TURNS}.*{_REAR}.*{_LEFT}", "wheels.speed_rl"),
    (rf"^(v |w |wheel ?)?(rr|hr)$|{_TURNS}.* (rr|hr)\b|(rr|hr) .*{_TURNS}"
     rf"|{_REAR}.*{_RIGHT}.*{_TURNS}|{_TURNS}.*{_REAR}.*{_RIGHT}", "wheels.speed_rr"),
    (r"wheel.*(speed|vel)|(speed|vel).*wheel|wbs|wbvs|ccvs|radgeschw|theoretical speed"
     r"|^wheel\b|getriebe.*geschw|transmission.*speed", "wheels.driven_speed"),
    (r"(v|vel|velocity|speed).*(east)|^ve$|east.*(vel|speed)|^v e$", "gnss.v_east"),
    (r"(v|vel|velocity|speed).*(north)|^vn$|north.*(vel|speed)|^v n$", "gnss.v_north"),
    (r"(yaw|heading|gier).*(rate|geschw|vel)|gyro.*z|angular.*z|omega.*z|^g ?z$|^r$|rate of turn",
     "imu.gyro_z"),
    (r"gyro.*x|angular.*x|omega.*x|roll.*rate|^g ?x$", "imu.gyro_x"),
    (r"gyro.*y|angular.*y|omega.*y|pitch.*rate|^g ?y$", "imu.gyro_y"),
    (r"acc.*\bx\b|acc ?x|^a ?x$|acc.*long|linear.*acc.*x", "imu.accel_x"),
    (r"acc.*\by\b|acc ?y|^a ?y$|acc.*lat|linear.*acc.*y", "imu.accel_y"),
    (r"acc.*\bz\b|acc ?z|^a ?z$|linear.*acc.*z", "imu.accel_z"),
    (r"^(gnss|gps|position|pos)? ?(latitude|lat|breite)", "gnss.latitude"),
    (r"^(gnss|gps|position|pos)? ?(longitude|long|lon|lng|laenge|länge)", "gnss.longitude"),
    (r"^(gnss|gps|pos|position|utm)? ?(east|easting|x east)$", "gnss.east"),
    (r"^(gnss|gps|pos|position|utm)? ?(north|northing|y north)$", "gnss.north"),
    (r"altitude|elevation|^alt\b|^height|höhe|hoehe|hmsl", "gnss.height"),
    (r"course|\bcog\b|track|kurs|motion dir", "gnss.course"),
    (r"heading|\bhdg\b|\byaw\b|azimuth|richtung|\bhdt\b|compass", "gnss.heading"),
    (r"(gnss|gps|ground|sog|radar|nav).*(speed|vel|geschw)|(speed|vel|geschw).*(gnss|gps|ground)"
     r"|\bsog\b|^v$|^v ?g|^speed$|^velocity$|^vel$|^geschwindigkeit|^gs\b|^gspeed", "gnss.speed"),
    (r"(fix|gps|gnss|rtk).*(qual|type|mode|status)|^quality$|^fix$", "gnss.quality"),
    (r"(num|n|used)?.*\b(sats?|satellites|sv|numsv)\b", "gnss.satellites"),
)  # fmt: skip
"""Pattern of a name in lower case with blanks for what is no letter -> section and key."""

TIME_NAMES = re.compile(
    r"^(time|t|timestamp|stamp|datetime|date time|zeit|zeitstempel|utc|epoch|tempo|temps|sec|secs"
    r"|seconds|elapsed|millis|uptime|log time|gps time|time stamp)\b|\b(time|timestamp|zeit)$"
)
UNIT_NAMES: tuple[tuple[str, str], ...] = (
    (r"km[/_ ]?h|kph|kmh", "km/h"), (r"m[/_]s2|mps2|m s 2|m[/_]s\^2|m[/_]s²", "m/s2"),
    (r"deg(rees?)?[/_ ]?(per[_ ])?s(ec)?\b|\bdps|°/s", "deg/s"),
    (r"rad[/_ ]?s\b|radps|rad/s", "rad/s"),
    (r"\bm[/_]s\b|mps|m s 1", "m/s"), (r"mph", "mph"), (r"knots?|kts?\b|\bkn\b", "kn"),
    (r"rpm|u/min|1/min|min-1", "rpm"), (r"deg|°|grad\b", "deg"), (r"\brad\b", "rad"),
    (r"%|pct|percent|prozent", "%"), (r"l[/_ ]?h\b|lph|l/h", "L/h"), (r"\bkN\b", "kN"),
    (r"\b[Nn]\b|[Nn]ewton", "N"), (r"kNm", "kNm"), (r"\b[Nn]m\b", "Nm"),
    (r"\bms\b|millis", "ms"), (r"\bus\b|micros", "us"), (r"\bns\b|nanos", "ns"),
    (r"\bs\b|sec", "s"), (r"\bmm\b", "mm"), (r"\bcm\b", "cm"), (r"\bm\b", "m"), (r"\bg\b", "g"),
)  # fmt: skip
"""Pattern in a name, with blanks for underscores -> unit; the first that can be counts."""


_ENDS: dict[str, tuple[str, ...]] = {
    "radps": ("rad/s",), "rad/s": ("rad/s",), "rad_s": ("rad/s",),
    "degps": ("deg/s",), "deg/s": ("deg/s",), "deg_s": ("deg/s",), "dps": ("deg/s",),
    "°/s": ("deg/s",), "rad": ("rad",), "mrad": ("mrad",), "deg": ("deg",), "°": ("deg",),
    "mps": ("m/s",), "m/s": ("m/s",), "m_s": ("m/s",), "mps2": ("m/s2",), "m/s2": ("m/s2",),
    "m/s^2": ("m/s2",), "m/s²": ("m/s2",), "kmh": ("km/h",), "km/h": ("km/h",),
    "km_h": ("km/h",), "kph": ("km/h",), "mph": ("mph",), "kn": ("kN", "kn"), "kt": ("kn",),
    "kts": ("kn",), "n": ("N",), "dan": ("daN",), "nm": ("Nm",), "knm": ("kNm",),
    "rpm": ("rpm",), "1/min": ("rpm",), "u/min": ("rpm",), "lph": ("L/h",), "l/h": ("L/h",),
    "l_h": ("L/h",), "m": ("m",), "cm": ("cm",), "mm": ("mm",), "s": ("s",),
    "ms": ("ms", "m/s"), "us": ("us",), "ns": ("ns",), "min": ("min",), "pct": ("%",),
    "percent": ("%",), "%": ("%",), "g": ("g",),
}  # fmt: skip
"""Unit at the end of a name, in lower case -> units it may mean; the first allowed counts."""
_BRACKETS = re.compile(r"[\[(]\s*([^\])]*?)\s*[\])]\s*$")
_LONGEST_FIRST = "|".join(re.escape(end) for end in sorted(_ENDS, key=len, reverse=True))
_END = re.compile(rf"[_ ](?!(?<=\bv[_ ])n$)(?!(?<=vel[_ ])n$)({_LONGEST_FIRST})$", re.IGNORECASE)
"""The `n` of `v_n` and `vel_n` is north."""

OWN_NAMES: dict[str, str] = {
    f"{section}_{quantity.column}": f"{section}.{key}"
    for section, keys in QUANTITIES.items()
    for key, quantity in keys.items()
}
"""Column of a stream or a reference, with its sensor before it -> section and key."""


def plain(name: str) -> str:
    """A name in lower case, with blanks for underscores, points, brackets and camel humps."""
    humps = re.sub(r"([a-z])([A-Z])", r"\1 \2", name)
    return re.sub(r"[\W_]+", " ", humps.lower()).strip()


def without_unit(name: str) -> str:
    """The name without a unit in brackets or at its end."""
    bare = re.sub(r"[\[(,].*$", "", name).strip()
    return _END.sub("", bare or name)


def quantity_of(name: str) -> str:
    """Section and key that a name says, or nothing."""
    if name in OWN_NAMES:
        return OWN_NAMES[name]
    texts = (plain(without_unit(name)), plain(name))
    return next((key for text in texts for pattern, key in QUANTITY_NAMES
                 if re.search(pattern, text)), "")  # fmt: skip


def unit_of(name: str, allowed: tuple[str, ...]) -> str:
    """The unit that a name says, of those allowed, or nothing; at its end before anywhere else."""
    end = _BRACKETS.search(name) or _END.search(name)
    said = _ENDS.get(end[1].lower(), ()) if end else ()
    at_end = next((unit for unit in said if unit in allowed), "")
    if at_end:
        return at_end
    for pattern, unit in UNIT_NAMES:
        folds = unit not in ("kN", "N", "Nm", "kNm")
        if unit in allowed and re.search(
            pattern, name.replace("_", " "), re.IGNORECASE if folds else 0
        ):
            return unit
    return ""


def is_time(name: str) -> bool:
    """Whether a name says that it is the time."""
    return bool(TIME_NAMES.search(plain(without_unit(name))))
