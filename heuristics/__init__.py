"""The published heuristics, and a modern yardstick."""
