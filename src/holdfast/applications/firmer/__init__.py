"""Move bodies to where the least push that moves something is larger."""
