"""Elastic contacts with Coulomb friction: the law, its linear systems, and the load path. Knows no assembly."""
