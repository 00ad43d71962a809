"""Methods over suites, side by side."""
