"""Independent ways to the same figures: slow, plain, and sharing no code with what they test."""
