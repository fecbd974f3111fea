"""Trees: loads that go to the support from one plane contact to the next, for which equilibrium alone decides."""
