"""Our branch and cut over incremental linear programs."""
