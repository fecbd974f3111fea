"""The elastic model of an assembly on plain arrays: bodies, flat sheets of nodes between them, and their units.

Units inside: forces in total weights, lengths in assembly sizes, displacements and clearances in weight per mean
stiffness. On ideal faces the law is positively homogeneous, so the absolute stiffness drops out; else stiffness and
clearance count by their product over the weight only.

Nodes that lie in one plane with one normal form a sheet: their displacements are those of a single twist (6,) of b
against a, in the sheet's own axes (normal, t1, t2) and about its own origin, and so are their forces a single wrench.
"""

from __future__ import annotations

from typing import NamedTuple

from holdfast.base.arrays import Float, Int
from holdfast.native import core


class Runs(NamedTuple):
    """R runs of a few nodes each, that lie together, of P sheets: where none of them presses, none is looked at.

    Those of sheet p are ``first[p]`` to ``first[p + 1] - 1``, and run k has nodes ``node[k]`` to ``node[k + 1] - 1``;
    ``box`` (R, 5): their least and largest x, least and largest y, and least clearance.
    """

    first: Int
    node: Int
    box: Float

    @classmethod
    def of(cls, first: Int, x: Float, y: Float, apart: Float) -> Runs:
        """Cut the sheets with nodes from ``first`` (P + 1,) on into runs."""
        return cls(*core.cut(first, x, y, apart))


class Elastic(NamedTuple):
    """P sheets of I nodes between J bodies, in the units of this module.

    ``first`` (P + 1,) where each sheet's nodes begin; ``x``, ``y`` (I,) along its tangents; ``k`` (I,) stiffness;
    ``apart`` (I,) clearance; ``mu`` (P,); ``rho`` tangential over normal stiffness; ``a``, ``b`` (P,) bodies (FIXED:
    -1); ``axes`` (P, 3, 3) normal and tangents of each sheet, as rows along the bodies' axes, which all bodies share;
    ``arm_a``, ``arm_b`` (P, 3) from the centre of a body to the origin of the sheet; ``wrench`` (6J,) what acts besides
    the contacts; ``scale`` (6J,) brings every body's equilibrium to order one; ``bonded`` (P, 6, 6) the stiffness with
    all nodes stuck, and ``unit`` (6J,) what brings that of every displacement to one; ``runs`` of the nodes; ``hold``
    (6J,) the stiffness of a regularisation spring of every body in its place, zero unless there are motions that no
    contact resists (sparse.py); ``still`` (6J,) the stiffness with which bonds hold each body to the world, zero but on
    ice (law.hpp).
    """

    first: Int
    x: Float
    y: Float
    k: Float
    apart: Float
    mu: Float
    rho: float
    a: Int
    b: Int
    axes: Float
    arm_a: Float
    arm_b: Float
    wrench: Float
    scale: Float
    bonded: Float
    unit: Float
    runs: Runs
    hold: Float
    still: Float
