"""Where the strongest points of each engine's map lead: placements on the top tenth of them that do not stand."""

SUITE = None
