"""Decide whether a load holds on its carrier during a given motion of the carrier."""
