"""Settings of all tests."""

import os

from hypothesis import settings

# The first call of a kernel compiles it, so the time of one example says nothing. Where CI is set, the same
# examples are drawn each time; elsewhere new ones.
settings.register_profile("cutgap", deadline=None, derandomize="CI" in os.environ)
settings.load_profile("cutgap")
