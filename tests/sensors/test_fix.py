import numpy as np
import pytest

from twin.sensors.fix import Mode, Outage, timeline


def modes(*outages, times, seed=0):
    line = timeline(outages, np.full(3, 0.01), np.random.default_rng(seed))
    return [Mode(m) for m in line.at(np.asarray(times, float))[0]]


def test_a_short_loss_of_corrections_is_bridged():
    lost = Outage(start_s=10, duration_s=8)
    F, E = Mode.FIXED, Mode.EXTRAPOLATED
    assert modes(lost, times=[9.9, 10, 17.9, 18, 60]) == [F, E, E, F, F]


def test_the_extrapolated_error_is_one_centimetre_per_second_of_age():
    at_ten = []
    for seed in range(1000):
        line = timeline([Outage(start_s=5, duration_s=20)], np.full(3, 0.01),
                        np.random.default_rng(seed))  # fmt: skip
        mode, age_s, drift = line.at(np.array([14.999]))
        assert mode[0] == Mode.EXTRAPOLATED
        at_ten.append(drift[0] * age_s[0])
    np.testing.assert_allclose(np.std(at_ten, axis=0), 0.10, rtol=0.1)


def test_the_refix_takes_five_to_thirty_seconds():
    times = []
    for seed in range(300):
        line = timeline([Outage(start_s=0, duration_s=40)], np.zeros(3),
                        np.random.default_rng(seed))  # fmt: skip
        times.append(line.start_s[-1] - 40)
    assert 5 <= min(times) < 7
    assert 28 < max(times) <= 30
    assert np.mean(times) == pytest.approx(17.5, rel=0.1)


def test_a_new_fault_cuts_the_recovery_short():
    faults = (Outage(start_s=0, duration_s=40), Outage(start_s=41, duration_s=5, kind="block"))
    assert modes(*faults, times=[39, 40.5, 41, 45.9, 46.5, 47.5, 80]) == [
        Mode.SINGLE, Mode.FLOAT, Mode.NONE, Mode.NONE, Mode.SINGLE, Mode.FLOAT, Mode.FIXED,
    ]  # fmt: skip


def test_no_fault_is_fixed_for_ever():
    assert modes(times=[0, 1e6]) == [Mode.FIXED, Mode.FIXED]
