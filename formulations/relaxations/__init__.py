"""Relaxations, each with a bound that is safe whatever a solver did."""
