"""Cone programs and their solution with certificates. This package knows no physics."""
