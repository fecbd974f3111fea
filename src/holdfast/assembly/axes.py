"""The frame of a group of bodies and their order in it, so that answers do not depend on the axes of the world."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from holdfast.base.arrays import Float, Int, frozen, unit
from holdfast.base.rigid import WORLD, Frame, cross, snapped, tangents
from holdfast.scene.body import Body

BITS = 40  # binary digits to which normals are rounded before tangents are chosen
MOST_CACHED = 1000  # largest number of rotations whose axes are cached
DIGITS = 9  # decimal digits to which relative lengths and masses are rounded before they are compared


def own_frame(bodies: Sequence[Body], up: Float) -> Frame:
    """Return the frame of the heaviest of the bodies, at its centre of mass; that of the world if there are none.

    Among equally heavy bodies, it is the lowest, then the one nearest to their common centre, then the first along the
    axes of the world. So the frame moves with the group as a whole, except when equal bodies are rotated in a way that
    exchanges them.
    """
    if not bodies:
        return WORLD
    com = np.array([body.com_world for body in bodies])
    mass = np.array([body.mass for body in bodies], dtype=np.float64)
    first = bodies[int(by_place(com, mass, up, heaviest=True)[0])]
    return Frame(frozen(np.array(first.com_world)), _axes_of(first.pose[:3, :3].tobytes()))


@lru_cache(maxsize=MOST_CACHED)
def _axes_of(rotation: bytes) -> Float:
    """Return the axes (3, 3), as rows, of a body with this rotation, made exactly orthonormal."""
    u, _, vt = np.linalg.svd(np.frombuffer(rotation).reshape(3, 3).T)
    return frozen(u @ vt)


def contact_axes(axes: Float, normals: Float) -> Float:
    """Return the axes (n, 3, 3) of contacts with these unit ``normals`` (n, 3): rows normal, t1 and t2, world frame.

    The tangents follow from the ``axes`` (3, 3) of the assembly in the world, so that they turn with it.
    """
    _, own = tangents(snapped(normals @ axes.T, 1.0, BITS))
    t1 = unit(cross(own @ axes, normals))
    return np.stack([normals, t1, cross(normals, t1)], axis=1)


def by_place(com: Float, mass: Float, up: Float, axes: Float = WORLD.axes, *, heaviest: bool = False) -> Int:
    """Return the order (n,) of bodies with centres of mass ``com`` (n, 3) [m] and ``mass`` (n,) [kg].

    They are sorted by height above their common centre, then by mass, by distance from the centre, and by coordinates
    along the rows of ``axes`` (3, 3), all rounded. With ``heaviest``, they are sorted by decreasing mass first.
    """
    arm = com - com.mean(0)
    arm = (arm / max(float(np.sqrt((arm * arm).sum(1).max())), 1e-300)) @ np.vstack([axes, up]).T
    far = np.sqrt((arm[:, :3] * arm[:, :3]).sum(1))
    x, y, z, height, far, weight = np.round([*arm.T, far, mass / mass.max()], DIGITS) + 0.0
    keys = (far, height, -weight) if heaviest else (far, weight, height)  # the last one counts most
    return np.asarray(np.lexsort((z, y, x, *keys)))
