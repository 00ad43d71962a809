"""Dynamic programming over contours: one head, entry points to choose from, precedence, process rules."""
