"""Surfaces, polygons, distances and sweeps: geometry without bodies and without physics."""
