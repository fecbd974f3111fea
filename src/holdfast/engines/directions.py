"""Groups of pushes on one body, and of those that share their direction: affine functions of points in one plane."""

from __future__ import annotations

import numpy as np

from holdfast.base.arrays import Float, Int
from holdfast.base.rigid import tangents

FLAT_GROUP = 12  # smallest number of pushes along one direction for which a triangulation pays off


def by_body(W: Float, least: int) -> list[tuple[int, Int]]:
    """Group columns of W (6J, n) that load a single body each: the number of the body, and those of its columns.

    Columns that load several bodies, or none, are in no group, nor are fewer than ``least`` columns of a body.
    """
    loaded = (W.reshape(len(W) // 6, 6, W.shape[1]) != 0).any(1)
    single = loaded & (loaded.sum(0) == 1)
    return [(int(body), np.flatnonzero(single[body])) for body in np.flatnonzero(single.sum(1) >= least)]


def flat_groups(loads: Float) -> tuple[list[Int], Int]:
    """Group loads (n, 6) by their force.

    Returns the numbers of the members of each group of at least FLAT_GROUP loads, and the numbers of all other loads.
    """
    _, group, size = np.unique(np.round(loads[:, :3], 9) + 0.0, axis=0, return_inverse=True, return_counts=True)
    group = group.reshape(-1)
    groups = [np.flatnonzero(group == number) for number in np.flatnonzero(size >= FLAT_GROUP)]
    return groups, np.flatnonzero(size[group] < FLAT_GROUP)


def moment_frame(force: Float) -> Float:
    """Return two unit axes (2, 3) normal to ``force`` (3,). They span the moments of all pushes along the force."""
    return np.array(tangents(force / np.linalg.norm(force)))
