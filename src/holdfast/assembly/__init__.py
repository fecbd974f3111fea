"""The assembly of bodies and interfaces, its contact nodes and the equilibrium operator, on which engines work."""
