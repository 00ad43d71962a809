"""Two heads: the methods ``split`` (no overlap, thresholds in x) and ``free`` (branch and cut)."""
