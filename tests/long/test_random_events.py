"""500 lists of events at random."""

from tests.simulation.random_events import drive


def test_500_random_lists_of_events_close():
    driven, wrong, same = 0, {}, 0
    for seed in range(1000, 2000):
        found = drive(seed)
        if found is None:
            continue
        driven += 1
        if found.wrong or not found.balance.closes:
            wrong[seed] = (found.wrong, found.balance)
        if driven % 50 == 0:
            same += (drive(seed).last == found.last).all()
        if driven == 500:
            break
    assert not wrong
    assert (driven, same) == (500, 10)
