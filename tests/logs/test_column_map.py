import pytest
from example_log import MAP, write, write_map

from twin.errors import BadInput
from twin.logs import read, read_column_map


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("[gnss]", "[gps]", "no section is called 'gps'"),
        ("latitude =", "lattitude =", "did you mean 'latitude'?"),
        ('unit = "km/h"', 'unit = "kmh"', "did you mean 'km/h'?"),
        ('unit = "km/h"', "unit = 3", "wheels.driven_speed.unit"),
        (', unit = "km/h"', "", "wheels.driven_speed has no unit"),
        ('column = "t",', "", "log.time.column"),
        ('column = "t", unit', 'col = "t", unit', "no key of log.time is called 'col'"),
        ('"compass"', '"compas"', "did you mean 'compass'?"),
        ("min_speed_kmh = 5.0", "min_speed = 5.0", "did you mean 'min_speed_kmh'?"),
        ("min_speed_kmh = 5.0", "min_speed_kmh = -5.0", "zero_slip.min_speed_kmh = -5.0"),
        ("min_speed_kmh = 5.0", "min_speed_kmh = nan", "zero_slip.min_speed_kmh = nan"),
        ('{state = ["M"]}', '{stat = ["M"]}', "did you mean 'state'?"),
        ('{state = ["M"]}', '{state = "M"}', "list of labels"),
        ("wheelbase_m = 2.5", "wheelbase = 2.5", "did you mean 'wheelbase_m'?"),
        ("wheelbase_m = 2.5", "wheelbase_m = '2.5'", "setup.wheelbase_m"),
        ("wheelbase_m = 2.5", "wheelbase_m = -2.5", "above zero"),
        ("wheelbase_m = 2.5", "gnss = {rate_hz = 0}", "setup.gnss.rate_hz"),
        ("wheelbase_m = 2.5", "gnss = 3", "setup.gnss"),
        ("[log]", "[log", "not TOML"),
        ("[log]", "x = " + "[" * 5000, "TOML"),
    ],
)
def test_a_bad_map_names_the_key(tmp_path, old, new, says):
    path = write_map(tmp_path, MAP.replace(old, new, 1))
    with pytest.raises(BadInput) as caught:
        read(write(tmp_path), path)
    message = str(caught.value)
    assert message.startswith(str(path))
    assert "\n" not in message
    assert says in message


def test_a_map_without_time_or_sensor(tmp_path):
    with pytest.raises(BadInput, match="time"):
        read(write(tmp_path), write_map(tmp_path, ""))
    with pytest.raises(BadInput, match="no sensor"):
        read(write(tmp_path), write_map(tmp_path, '[log]\ntime = {column = "t", unit = "s"}'))


def test_the_rule_says_itself_in_words(tmp_path):
    rules = read_column_map(write_map(tmp_path)).rules
    assert str(rules["zero_slip"]) == "state in {M}, wheel speed > 5 km/h"
    assert "0.15 km/h per s" in str(rules["steady"])
