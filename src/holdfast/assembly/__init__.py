"""The contact interface graph and the equilibrium operator: the one object that engines take."""
