"""Pushes that share their direction: their wrenches are affine in the points of one plane."""

from __future__ import annotations

import numpy as np

from holdfast.base.arrays import Float, Int
from holdfast.base.rigid import tangents

FLAT_GROUP = 12  # pushes along one direction that are worth a triangulation


def flat_groups(loads: Float) -> tuple[list[Int], Int]:
    """Members of the groups of loads (n, 6) with one force that are large enough, and all others."""
    _, group, size = np.unique(np.round(loads[:, :3], 9) + 0.0, axis=0, return_inverse=True, return_counts=True)
    group = group.reshape(-1)
    groups = [np.flatnonzero(group == number) for number in np.flatnonzero(size >= FLAT_GROUP)]
    return groups, np.flatnonzero(size[group] < FLAT_GROUP)


def moment_frame(force: Float) -> Float:
    """(2, 3): two axes across ``force`` (3,), in whose plane lie the moments of all pushes along it."""
    return np.array(tangents(force / np.linalg.norm(force)))
