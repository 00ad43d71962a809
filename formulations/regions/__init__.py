"""Shortest tours through convex regions in any order, by branch and bound over sequences."""
