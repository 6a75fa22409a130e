import gymnasium
import pytest

from twin.env.observations import MODES


@pytest.fixture(scope="session")
def environments():
    """One environment per mode of observation, shared: every test begins with a reset."""
    made = {m: gymnasium.make("twin.env:Plough-v0", observation=m).unwrapped for m in MODES}
    yield made
    for env in made.values():
        env.close()


@pytest.fixture(params=MODES)
def env(request, environments):
    return environments[request.param]


@pytest.fixture
def truth_env(environments):
    return environments["truth"]
