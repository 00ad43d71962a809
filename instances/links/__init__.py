"""Links: contours joined by straight cuts, so that one pierce serves several of them."""
