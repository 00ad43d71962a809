"""Settings of all tests."""

from hypothesis import settings

# The first call of a kernel compiles it, so the time of one example says nothing. The same examples are drawn
# each time, so that a failure is due to the change at hand; `--hypothesis-profile explore` draws new ones.
settings.register_profile("cutgap", deadline=None, derandomize=True)
settings.register_profile("explore", deadline=None)
settings.load_profile("cutgap")
