"""Settings of all tests."""

from hypothesis import settings

# a law's first call compiles it, which takes longer than any deadline
settings.register_profile("compiled", settings.default, deadline=None)
settings.load_profile("compiled")
