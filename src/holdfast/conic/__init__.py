"""Cone programs as values and their solution with certificates. Knows no physics."""
