"""How contact nodes and their normals move when one of the two bodies moves: differences of the contacts as detected.

A corner of a patch is where edges of either body cross, between their two faces, and on a round side where the two
surfaces are nearest. Detection knows all of these kinds. So one body is moved by a small step either way, its contacts
are detected again, and every node is found again near its place. A step is far smaller than the gap, so that a face
that opens or overlaps by it still touches.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np
from scipy.spatial.transform import Rotation

from holdfast.assembly.assembly import Assembly
from holdfast.assembly.contact_nodes import contact_nodes
from holdfast.base.arrays import Bool, Float
from holdfast.base.rigid import cross
from holdfast.base.values import altered
from holdfast.geometry.spatial import search_tree

STEP = 1e-5  # of a motion, in sizes of the smaller body and in radians; a hundredth of the usual gap
NEAR = 20.0  # [steps] within which a node is found again

_Sides: TypeAlias = tuple[Float, Float]


@dataclass(frozen=True, eq=False)
class NodeMotion:
    """The motion of n nodes of two bodies per unit motion of the ``second`` body, on either side.

    ``shift`` (2, n, 3, 6) is that of the points and ``turn`` (2, n, 3, 6) the rotation of the normals, before and
    after, for velocities [m/m] and rotations [m/rad] of the second body along the world axes about ``origin`` (3,) [m].
    ``changed`` (6,) tells for which motions a node appears or is gone on one of the sides; they are 0 there.
    """

    origin: Float
    shift: Float
    turn: Float
    changed: Bool


def node_motion(assembly: Assembly, pair: tuple[str, str], points: Float, normals: Float) -> NodeMotion:
    """Return how the nodes at ``points`` (n, 3) [m] with ``normals`` (n, 3) move with the second body of a ``pair``."""
    size = min(assembly.scene.body(name).size for name in pair)
    origin, count = points.mean(axis=0), len(points)
    steps = STEP * np.array([size] * 3 + [1.0] * 3)
    shift, turn, changed = np.zeros((2, count, 3, 6)), np.zeros((2, count, 3, 6)), np.zeros(6, dtype=bool)
    moves = next(name for name in reversed(pair) if not assembly.scene.body(name).fixed)
    sign = 1.0 if moves == pair[1] else -1.0  # of the motion relative to the first body
    body, alone = assembly.scene.body(moves), _alone(assembly, pair, moves)
    for way in range(6):
        for side, step in enumerate((-steps[way], steps[way])):
            twist = np.zeros(6)
            twist[way] = step
            there = alone.moved({moves: displaced(body.pose, twist, origin)})
            found = _found_again(points, normals, there, pair, size)
            if found is None:
                changed[way] = True
                continue
            shift[side, :, :, way] = (found[0] - points) / step
            turn[side, :, :, way] = cross(normals, found[1] - normals) / step
    if sign < 0:  # the motion of both bodies together is rigid
        whole = np.concatenate([np.broadcast_to(np.eye(3), (count, 3, 3)), _spin(points - origin)], axis=2)
        across = np.eye(3) - normals[:, :, None] * normals[:, None, :]
        shift = whole - shift
        turn = np.concatenate([np.zeros((count, 3, 3)), across], axis=2) - turn
    shift[:, :, :, changed] = turn[:, :, :, changed] = 0.0
    return NodeMotion(origin, shift, turn, changed)


def displaced(pose: Float, twist: Float, origin: Float) -> Float:
    """Return a ``pose`` (4, 4) after the small motion ``twist`` (6,) [m, rad] about ``origin`` (3,), world axes."""
    found, turned = np.eye(4), Rotation.from_rotvec(twist[3:]).as_matrix()
    found[:3, :3] = turned @ pose[:3, :3]
    found[:3, 3] = origin + turned @ (pose[:3, 3] - origin) + twist[:3]
    return found


def _alone(assembly: Assembly, pair: tuple[str, str], moves: str) -> Assembly:
    """Return the two bodies alone, of which one ``moves``, with those that hide a part of their contact, if any do."""
    hidden = any("occluded" in one.flags for one in assembly.interfaces if set(one.bodies) == set(pair))
    touching = [one.bodies for one in assembly.interfaces if hidden and not set(pair).isdisjoint(one.bodies)]
    near = {*pair, *(name for bodies in touching for name in bodies)}
    bodies = tuple(altered(b, fixed=b.name != moves) for b in assembly.bodies if b.name in near)
    scene = altered(assembly.scene, bodies=bodies)
    return replace(assembly, scene=scene, interfaces=(), overlaps=(), occluded=())


def _found_again(points: Float, normals: Float, there: Assembly, pair: tuple[str, str], size: float) -> _Sides | None:
    """Return the places of the nodes (n, 3) in an assembly and their normals, or None if there are others."""
    numbers = [k for k, one in enumerate(there.interfaces) if set(one.bodies) == set(pair)]
    nodes = contact_nodes(there, 4, "corners", among=numbers)
    if len(nodes) != len(points):
        return None
    same_way = [1.0 if there.interfaces[k].bodies == pair else -1.0 for k in nodes.interface.tolist()]
    ways = np.array(same_way)[:, None] * nodes.normals
    away, found = search_tree(np.hstack([nodes.points / size, ways])).query(np.hstack([points / size, normals]))
    back, _ = search_tree(np.hstack([points / size, normals])).query(np.hstack([nodes.points / size, ways]))
    if max(away.max(), back.max()) > NEAR * STEP:
        return None
    return nodes.points[found], ways[found]


def _spin(arms: Float) -> Float:
    """Return the matrices (n, 3, 3) that map a rotation to the velocity at ``arms`` (n, 3)."""
    return np.stack([cross(axis, arms) for axis in np.eye(3)], axis=2)
