import numpy as np

from twin.sensors.noise import advance, advance_smooth, gauss_markov, generator, smooth


def correlation(x, lag):
    return float(np.mean(x[lag:] * x[:-lag]) / np.mean(x * x))


def test_a_gauss_markov_process_has_its_sd_and_correlation_time():
    process = gauss_markov(generator(1, "t", "x"), [0.5, 2.0], 3.0)
    _, x = advance(process, np.full(200_000, 0.1))
    np.testing.assert_allclose(x.std(axis=0), [0.5, 2.0], rtol=0.05)
    for lag_s in (1.5, 3.0):
        for j in range(2):
            expected = np.exp(-lag_s / 3.0)
            assert abs(correlation(x[:, j], round(lag_s / 0.1)) / expected - 1) < 0.1


def test_its_statistics_do_not_depend_on_the_step():
    rng = np.random.default_rng(5)
    process = gauss_markov(generator(1, "t", "x"), 1.0, 3.0)
    _, x = advance(process, rng.exponential(0.4, 100_000))
    assert abs(x.std() - 1) < 0.05


def test_it_starts_stationary():
    first = [gauss_markov(generator(s, "t", "x"), 2.0, 1.0).last[0] for s in range(2000)]
    assert abs(np.std(first) / 2.0 - 1) < 0.1


def test_no_step_is_no_change():
    process = gauss_markov(generator(1, "t", "x"), 1.0, 3.0)
    _, x = advance(process, np.zeros(5))
    np.testing.assert_array_equal(x[:, 0], process.last[0])


def test_terms_and_seeds_are_independent():
    draws = [
        generator(seed, sensor, term).standard_normal(20_000)
        for seed in (0, 1)
        for sensor in ("gnss", "imu")
        for term in ("white", "latency")
    ]
    off = np.corrcoef(draws) - np.eye(len(draws))
    assert np.abs(off).max() < 4 / np.sqrt(20_000)


def test_the_same_seed_gives_the_same_bits():
    a, b = (generator(7, "imu", "white").standard_normal(9) for _ in range(2))
    assert a.tobytes() == b.tobytes()


def test_a_smooth_process_has_its_sd_and_correlation_from_its_start():
    process = smooth(generator(1, "t", "x"), [0.5, 2.0], 3.0)
    _, x = advance_smooth(process, np.full(300_000, 0.1))
    np.testing.assert_allclose(x.std(axis=0), [0.5, 2.0], rtol=0.05)
    for lag_s in (0.5, 1.5, 6.0):
        due = (1 + lag_s / 3.0) * np.exp(-lag_s / 3.0)
        for j in range(2):
            assert abs(correlation(x[:, j], round(lag_s / 0.1)) - due) < 0.04
    first = [
        advance_smooth(smooth(generator(s, "t", "x"), 2.0, 1.0), np.full(1, 0.01))[1][0, 0]
        for s in range(2000)
    ]
    assert abs(np.std(first) / 2.0 - 1) < 0.1


def test_a_smooth_process_goes_on_where_it_stood():
    whole = advance_smooth(smooth(generator(1, "t", "x"), 1.0, 3.0), np.full(9, 0.1))[1]
    process, head = advance_smooth(smooth(generator(1, "t", "x"), 1.0, 3.0), np.full(4, 0.1))
    tail = advance_smooth(process, np.full(5, 0.1))[1]
    np.testing.assert_array_equal(np.concatenate([head, tail]), whole)
