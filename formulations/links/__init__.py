"""Links, exactly: the cheapest even connected multigraph of links and rapids, by branch and cut."""
