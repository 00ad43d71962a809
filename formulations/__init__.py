"""Models and bounds."""
