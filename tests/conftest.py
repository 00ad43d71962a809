"""Settings of all tests."""

import signal

from hypothesis import settings

# A shell that starts the tests in the background has them and their children ignore Ctrl-C, which tests send.
signal.signal(signal.SIGINT, signal.default_int_handler)

# The first call of a kernel compiles it, so the time of one example says nothing. The same examples are drawn
# each time, so that a failure is due to the change at hand; `--hypothesis-profile explore` draws new ones.
settings.register_profile("cutgap", deadline=None, derandomize=True)
settings.register_profile("explore", deadline=None)
settings.load_profile("cutgap")
