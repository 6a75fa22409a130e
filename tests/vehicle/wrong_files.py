"""Files of machines and implements that are wrong, each in one way; and what is said of it."""

MACHINE = """\
schema = 1
name = "mine"
mass_kg = 4300
wheelbase_m = 2.4

[front]
tyre = "340/85R24"

[rear]
tyre = "420/85R34"
track_m = 1.7

[engine]
rated_power_kw = 74
rated_rpm = 2200
"""
"""A machine of a data sheet."""

IMPLEMENT = """\
schema = 1
name = "my_cultivator"
kind = "cultivator"
bodies = 11
width_m = 2.5
mass_kg = 480
depth_m = [0.04, 0.14]
"""


def other(text: str, **lines: str) -> str:
    """The text with the line of a field in place of its own; `table__field` for one of a table."""
    for field, value in lines.items():
        table, _, name = field.rpartition("__")
        out, here, done = [], "", False
        for line in text.splitlines():
            if line.startswith("["):
                if here == table and not done and value:
                    out.append(f"{name} = {value}")
                    done = True
                here = line.strip("[]")
            if here == table and line.partition(" =")[0] == name:
                if value:
                    out.append(f"{name} = {value}")
                done = True
                continue
            out.append(line)
        if not done and value:
            out += [f"[{table}]"] * (here != table) + [f"{name} = {value}"]
        text = "\n".join(out) + "\n"
    return text


M, T = MACHINE, IMPLEMENT
WRONG_MACHINES: dict[str, tuple[str, tuple[str, ...]]] = {
    # units
    "mass in tonnes": (other(M, mass_kg="4.3"), ("mass_kg", "4.3", "20, 60000")),
    "wheelbase in mm": (other(M, wheelbase_m="2400"), ("wheelbase_m", "2400", "0.3, 6")),
    "track in cm": (other(M, rear__track_m="170"), ("rear.track_m", "170", "0.2, 4")),
    "power in watts": (other(M, engine__rated_power_kw="74000"),
                       ("engine.rated_power_kw", "74000", "0.05, 1000")),
    "speed in rad/s": (other(M, engine__rated_rpm="230"), ("engine.rated_rpm", "230", "300, 8000")),
    "pressure in bar": (other(M, rear__pressure_kpa="1.1"),
                        ("rear.pressure_kpa", "1.1", "40, 600")),
    "droop in per cent": (other(M, engine__droop="8"), ("engine.droop", "8", "0.002, 0.3")),
    "efficiency in per cent": (other(M, transmission__efficiency="87"),
                               ("transmission.efficiency", "87", "0.4, 1")),
    "lead in per cent": (other(M, drive__front_lead="3"), ("drive.front_lead", "3", "-0.2, 0.2")),
    "radius in mm": (other(M, rear__free_rolling_radius_m="762"),
                     ("rear.free_rolling_radius_m", "762", "0.05, 1.5")),
    "limit in degrees": (other(M, chassis__steer_limit_rad="43"),
                         ("chassis.steer_limit_rad", "43", "0.1, 1.2")),
    "displacement in cm3": (other(M, engine__displacement_l="4500"),
                            ("engine.displacement_l", "4500", "0.1, 40")),
    "mass by another unit's name": (other(M, mass_t="4.3"), ("mass_t", "4.3", "mass_kg")),
    "power by another unit's name": (other(M, engine__rated_power_hp="100"),
                                     ("engine.rated_power_hp", "100", "rated_power_kw")),
    "a text with its unit": (other(M, mass_kg='"4300 kg"'), ("mass_kg", "4300 kg", "a number")),
    # signs and impossible values
    "negative mass": (other(M, mass_kg="-4300"), ("mass_kg", "-4300", "20, 60000")),
    "negative power": (other(M, engine__rated_power_kw="-74"),
                       ("engine.rated_power_kw", "-74", "0.05, 1000")),
    "no track at all": (other(M, rear__track_m="0"), ("rear.track_m", "0", "0.2, 4")),
    "not a number": (other(M, mass_kg="nan"), ("mass_kg", "nan", "a number")),
    "endless": (other(M, wheelbase_m="inf"), ("wheelbase_m", "inf", "a number")),
    "true for a number": (other(M, mass_kg="true"), ("mass_kg", "True", "a number")),
    "negative ballast": (M + "[[ballast]]\nmass_kg = -200\nx_m = 3.0\n",
                         ("ballast.0.mass_kg", "-200", "0, 10000")),
    "the top link below the lower links": (
        M + "[linkage]\ntop_pivot_m = [-0.28, -0.5]\n", ("linkage.top_pivot_m", "-0.5", "above")),
    # missing
    "no mass": (other(M, mass_kg=""), ("mass_kg", "missing", "weighbridge")),
    "no wheelbase": (other(M, wheelbase_m=""), ("wheelbase_m", "missing", "data sheet")),
    "no rear tyre": (other(M, rear__tyre=""), ("rear.tyre", "missing", "18.4R38")),
    "no power": (other(M, engine__rated_power_kw=""),
                 ("engine.rated_power_kw", "missing", "would")),
    "no rated speed": (other(M, engine__rated_rpm=""), ("engine.rated_rpm", "missing", "would")),
    "a weight without its place": (M + "[[ballast]]\nmass_kg = 200\n",
                                   ("ballast.0.x_m", "missing")),
    # form
    "no TOML": ("mass = = 3", ("no TOML",)),
    "an empty file": ("", ("mass_kg", "missing")),
    "a misspelt field": (other(M, wheelbse_m="2.4"), ("wheelbse_m", "2.4", "wheelbase_m")),
    "a misspelt table": (M + "[transmision]\nefficiency = 0.87\n",
                         ("transmision", "transmission")),
    "a table for a number": (M.replace("mass_kg = 4300", "mass_kg = {kg = 4300}"),
                             ("mass_kg", "4300", "value, grade, source")),
    "a number for a table": (M.replace("[front]\ntyre = \"340/85R24\"\n", "front = 3\n").replace(
        "wheelbase_m = 2.4\n\nfront = 3\n", "wheelbase_m = 2.4\nfront = 3\n"),
        ("front", "3", "[front]")),
    "a grade that there is not": (
        M.replace("mass_kg = 4300", 'mass_kg = {value = 4300, grade = "guessed"}'),
        ("mass_kg", "guessed", "assumed")),
    "another schema": (other(M, schema="2"), ("schema", "2", "1")),
    "a name with a path": (other(M, name='"../mine"'), ("name", "../mine", "letters")),
    "two coordinates of three": (M + "[places]\nimu_m = [0.5, 0.0]\n",
                                 ("places.imu_m", "2 values", "3")),
    # tyres
    "no tyre size": (other(M, rear__tyre='"large"'), ("rear.tyre", "large", "18.4R38")),
    "a tyre of a car": (other(M, rear__tyre='"205/55R16 91V"'), ("rear.", "205/55R16")),
    "a tyre's sizes exchanged": (other(M, rear__tyre='"34R420/85"'), ("rear.tyre", "34R420/85")),
    "a diameter that is not the code's": (other(M, rear__diameter_m="1.2"),
                                          ("rear.diameter_m", "1.2", "1.58")),
    "a radius that is the diameter": (other(M, rear__free_rolling_radius_m="1.5"),
                                      ("rear.free_rolling_radius_m", "1.5", "would do")),
    "a tyre far too small": (other(M, mass_kg="14000", rear__tyre='"9.5-24"'), ("would do",)),
    # contradictions
    "axle loads that are not the mass": (
        other(M, front_axle_kg="1700", rear_axle_kg="2900"),
        ("front_axle_kg", "1700", "4600", "4300")),
    "all of the weight in front": (other(M, front_axle_kg="4200", rear_axle_kg="100"),
                                   ("front_axle_kg", "98%", "12 to 70")),
    "torque against power": (other(M, engine__rated_torque_nm="600"),
                             ("engine.rated_torque_nm", "600", "321")),
    "take-off above the engine": (other(M, engine__pto_power_kw="80"),
                                  ("engine.pto_power_kw", "80", "74")),
    "greatest below rated power": (other(M, engine__max_power_kw="60"),
                                   ("engine.max_power_kw", "60", "74")),
    "greatest far above rated power": (other(M, engine__max_power_kw="150"),
                                       ("engine.max_power_kw", "150", "74", "99.9")),
    "torque points far above rated power": (
        other(M, engine__torque_points="[[1400, 800], [2200, 321]]"),
        ("engine.torque_points", "117", "74", "99.9")),
    "torque points that end before rated speed": (
        other(M, engine__torque_points="[[321, 2200], [400, 1400]]"),
        ("engine.torque_points", "400 rpm", "2200", "[rpm, N m]")),
    "torque points below rated power": (
        other(M, engine__torque_points="[[1400, 300], [2190, 300]]"),
        ("engine.torque_points", "68.8", "74")),
    "torque points that are exchanged": (
        other(M, engine__torque_points="[[400, 1400], [321, 2200]]"),
        ("engine.torque_points.1", "321", "[rpm, N m]")),
    "torque points that are one": (
        other(M, engine__torque_points="[1400, 400]"),
        ("engine.torque_points.0", "1400", "; [rpm, N m] would do")),
    "torque points that are a number": (
        other(M, engine__torque_points="400"),
        ("engine.torque_points", "400", "pairs [rpm, N m] would do")),
    "one ratio of a range": (M + "[transmission]\ncvt_ratio = 30\n",
                             ("transmission.cvt_ratio", "30", "[least, greatest] would do")),
    "three ratios of a range": (M + "[transmission]\ncvt_ratio = [10, 20, 30]\n",
                                ("transmission.cvt_ratio", "[least, greatest] would do")),
    "one gear": (M + "[transmission]\nspeeds_kmh = 7\n",
                 ("transmission.speeds_kmh", "7", "[speed of each gear] would do")),
    "a place of two": (M + "[places]\nimu_m = [0.1, 0.2]\n",
                       ("places.imu_m", "[x, y, z] would do")),
    "letters exchanged": (M.replace("rated_rpm", "rated_rmp"),
                          ("engine.rated_rmp", "did you mean rated_rpm?")),
    "peak below idle": (other(M, engine__peak_rpm="700"),
                        ("engine.peak_rpm = 700", "above engine.idle_rpm", "rising")),
    "idle above rated speed": (other(M, engine__idle_rpm="2300"), ("engine.idle_rpm", "2300")),
    "no-load below rated speed": (other(M, engine__no_load_rpm="2100"),
                                  ("engine.rated_rpm", "2200", "2100")),
    "droop and no-load speed": (other(M, engine__droop="0.05", engine__no_load_rpm="2400"),
                                ("engine.no_load_rpm", "2400", "0.05", "one of them")),
    "lead and ratio": (other(M, drive__front_lead="0.02", drive__front_ratio="1.35"),
                       ("drive.front_ratio", "1.35", "one of them")),
    "ratios and speeds": (M + "[transmission]\nratios = [60.0]\nspeeds_kmh = [7.0]\n",
                          ("transmission.ratios", "transmission.speeds_kmh", "one of them")),
    "a usual gear that is none": (M + "[transmission]\nratios = [60.0, 80.0]\nusual_ratio = 70.0\n",
                                  ("transmission.usual_ratio", "70")),
    "torque points that fall back": (
        other(M, engine__torque_points="[[1400, 400], [1200, 390], [2200, 321]]"),
        ("engine.torque_points.1", "1200", "rising")),
    "torque points against power": (
        other(M, engine__torque_points="[[1400, 400], [2200, 400]]"),
        ("engine.torque_points", "92", "74")),
    "an axle height that is not the tyre's": (other(M, rear_axle_height_m="0.95"),
                                              ("rear_axle_height_m", "0.95", "0.75")),
    "wheels that overlap": (other(M, wheelbase_m="1.2"), ("wheelbase_m", "1.2", "1.38")),
    "power of another machine": (other(M, mass_kg="500"), ("mass_kg", "500")),
    "a kind of engine that there is not": (other(M, engine__kind='"petrol"'),
                                           ("engine.kind", "petrol", "diesel")),
    "driven wheels that there are not": (M + '[drive]\ndriven = "front"\n',
                                         ("drive.driven", "front", "rear")),
    "a battery of a diesel": (other(M, engine__battery_kwh="50"), ("engine.battery_kwh", "50")),
    "ballast in millimetres": (M + "[[ballast]]\nmass_kg = 400\nx_m = 3300\n",
                               ("ballast.0.x_m", "3300")),
    "an implement that there is not": (M.replace("mass_kg", 'implement = "plow"\nmass_kg', 1),
                                       ("implement", "plow")),
    "a MJCF that is missing": (other(M, mjcf='"nowhere.xml"'), ("nowhere.xml", "missing")),
}  # fmt: skip

WRONG_IMPLEMENTS: dict[str, tuple[str, tuple[str, ...]]] = {
    "a seventh body": (other(T, kind='"mouldboard"', bodies="7"), ("bodies", "7", "1 to 6")),
    "a seventeenth tine": (other(T, bodies="17"), ("bodies", "17", "1 to 16")),
    "half a body": (other(T, bodies="2.5"), ("bodies", "2.5", "a whole number")),
    "no body": (other(T, bodies="0"), ("bodies", "0", "1 to 16")),
    "no width": (other(T, width_m=""), ("width_m", "missing", "would do")),
    "width in cm": (other(T, width_m="250"), ("width_m", "250", "0.1, 12")),
    "a width that the bodies do not work": (other(T, width_m="9.0"), ("width_m", "9", "5.5")),
    "mass in tonnes": (other(T, mass_kg="0.48"), ("mass_kg", "0.48", "5, 10000")),
    "depth in cm": (other(T, depth_m="[4, 14]"), ("depth_m", "4, 14", "0.01, 0.8")),
    "depths exchanged": (other(T, depth_m="[0.14, 0.04]"), ("depth_m", "rising")),
    "one depth": (other(T, depth_m="0.1"), ("depth_m", "0.1", "[least, greatest] would do")),
    "a kind that there is not": (other(T, kind='"harrow"'), ("kind", "harrow", "chisel")),
    "a hitch that there is not": (other(T, hitch='"ball"'), ("hitch", "ball", "three-point")),
    "negative draft": (T + "[draft]\na = -46\n", ("draft.a", "-46", "0, 5000")),
    "a law without its module": (T + '[draft]\nlaw = "mine"\n', ("mine", "module:function")),
    "a misspelt field": (other(T, body="11"), ("body", "11", "bodies")),
}


def cases() -> dict[str, tuple[str, str, tuple[str, ...]]]:
    """All of them: what is wrong -> kind of file, text, what must be said."""
    machines = {f"machine, {k}": ("machine", *v) for k, v in WRONG_MACHINES.items()}
    return machines | {f"implement, {k}": ("implement", *v) for k, v in WRONG_IMPLEMENTS.items()}
