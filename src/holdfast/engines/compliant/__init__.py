"""Elastic contacts with Coulomb friction: the assumptions of the graph method, solved as they stand."""
