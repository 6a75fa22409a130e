"""Settings of all tests, and what is checked of whatever they leave."""

from collections.abc import Iterator

import pytest
from hypothesis import settings
from recordings import broken

# a law's first call compiles it, which takes longer than any deadline
settings.register_profile("compiled", settings.default, deadline=None)
settings.load_profile("compiled")


@pytest.fixture(scope="session", autouse=True)
def _every_recording_is_whole(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Verify each recording that any test wrote below its temporary folder, once all have ended."""
    yield
    found = broken(sorted(tmp_path_factory.getbasetemp().glob("**/*.rrd")))
    assert not found, "\n".join(found)
