"""Settings of all tests, and what is checked of whatever they leave."""

import os
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import settings

from tests.recordings import broken

# a law's first call compiles it, which takes longer than any deadline
settings.register_profile("compiled", settings.default, deadline=None)
settings.load_profile("compiled")

os.environ.pop("COLUMNS", None)  # some terminals hand it on; what is printed here has no width

LONG = Path(__file__).parent / "long"


def pytest_ignore_collect(collection_path: Path, config: pytest.Config) -> bool | None:
    """Leave out what takes long, unless it is asked for by its path, as `.ci/long` does."""
    folder = config.invocation_params.dir
    asked = [(folder / arg.partition("::")[0]).resolve() for arg in config.args]
    wanted = any(path.is_relative_to(LONG) for path in asked)
    return True if collection_path == LONG and not wanted else None


@pytest.fixture(scope="session", autouse=True)
def _every_recording_is_whole(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Verify each recording that any test wrote below its temporary folder, once all have ended."""
    yield
    found = broken(sorted(tmp_path_factory.getbasetemp().glob("**/*.rrd")))
    assert not found, "\n".join(found)
