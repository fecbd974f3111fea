"""How contact nodes and their normals move when one of the two bodies moves.

Between flat faces this is closed form: a patch lies halfway between the two faces, and each of its edges is one of
either body, with which it moves. A corner on two edges with outward normals o1, o2, on a patch with normal n, moves by
the dp with o1·dp = o1·v1, o2·dp = o2·v2 and n·dp = n·(va + vb)/2, where v are the velocities of the bodies at the
corner and v1, v2 those of the bodies of the edges. The normal turns with half the rotation of each.

For all other contacts, one body is moved by a small step either way, its contacts are detected again, and every node is
found again near its place. A step is far smaller than the gap, so that a face that opens by it still touches.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from holdfast.assembly.assembly import Assembly
from holdfast.assembly.contact_nodes import contact_nodes
from holdfast.assembly.on_surface import INSIDE
from holdfast.base.arrays import Bool, Float
from holdfast.base.rigid import cross
from holdfast.base.values import altered
from holdfast.contacts.interface import Interface, Patch
from holdfast.geometry import polygon as flat
from holdfast.geometry.distance import winding_number
from holdfast.geometry.hull import search_tree

STEP = 1e-5  # of a motion, in sizes of the smaller body and in radians; a hundredth of the usual gap
NEAR = 20.0  # [steps] within which a node is found again
FLUSH = 1e-4  # [sizes of the smaller body] within which edges of both bodies count as the same place
SHALLOW = 0.01  # tangent of the angle at an edge, from which on a body is seen to end there


@dataclass(frozen=True, eq=False)
class NodeMotion:
    """The motion of n nodes of two bodies per unit motion of the second body: two alternatives, which differ at kinks.

    ``shift`` (2, n, 3, 6) is that of the points and ``turn`` (2, n, 3, 6) the rotation of the normals, for velocities
    [m/m] and rotations [m/rad] of the second body along the world axes about ``origin`` (3,) [m]. Where edges of both
    bodies are flush, the alternatives are those of the one and of the other body; where one is round, they are those
    before and after. ``changed`` (6,) tells for which motions a node appears or is gone; all is 0 there.
    """

    origin: Float
    shift: Float
    turn: Float
    changed: Bool


def node_motion(assembly: Assembly, contacts: Sequence[Interface], points: Float, normals: Float) -> NodeMotion:
    """Return how the corners of all ``contacts`` of two bodies move with the second one.

    The corners are at ``points`` (n, 3) [m] with ``normals`` (n, 3). All contacts name the bodies in the same order.
    """
    found = _of_faces(assembly, contacts, points)
    return _of_differences(assembly, contacts[0].bodies, points, normals) if found is None else found


def displaced(pose: Float, twist: Float, origin: Float) -> Float:
    """Return a ``pose`` (4, 4) after the small motion ``twist`` (6,) [m, rad] about ``origin`` (3,), world axes."""
    from scipy.spatial.transform import Rotation  # only here, as it takes long to import

    found, turned = np.eye(4), Rotation.from_rotvec(twist[3:]).as_matrix()
    found[:3, :3] = turned @ pose[:3, :3]
    found[:3, 3] = origin + turned @ (pose[:3, 3] - origin) + twist[:3]
    return found


def _of_faces(assembly: Assembly, contacts: Sequence[Interface], points: Float) -> NodeMotion | None:
    """Return the motion in closed form, or None if a patch is not flat or has an edge of neither body."""
    patches = [patch for contact in contacts for patch in contact.patches]
    if any(patch.kind != "face" or patch.spots is not None for patch in patches):
        return None
    if sum(len(patch.corners) for patch in patches) != len(points):
        return None
    edges = [_edges(patch) for patch in patches]
    middles, outward = (np.concatenate([edge[k] for edge in edges]) for k in (0, 1))  # (n, 2, 3), before and after
    normal = np.concatenate([np.tile(patch.normal, (len(patch.corners), 1)) for patch in patches])
    flat_edges = (middles.reshape(-1, 3), outward.reshape(-1, 3), np.repeat(normal, 2, axis=0))
    owners = edges_of_second(assembly, contacts, *flat_edges)
    if owners is None:
        return None
    of_second = owners.reshape(2, -1, 2)
    rows = np.concatenate([outward, normal[:, None]], axis=1)
    if (np.abs(np.linalg.det(rows)) < 1e-9).any():
        return None
    share = np.concatenate([of_second, np.full((2, len(points), 1), 0.5)], axis=2)
    origin = points.mean(axis=0)
    velocity = _rigid(points - origin)
    shift = np.linalg.inv(rows) @ (share[..., None] * (rows @ velocity))
    across = 0.5 * (np.eye(3) - normal[:, :, None] * normal[:, None, :])
    turn = np.concatenate([np.zeros_like(across), across], axis=2)
    return NodeMotion(origin, shift, np.broadcast_to(turn, shift.shape), np.zeros(6, dtype=bool))


def edges_of_second(
    assembly: Assembly, contacts: Sequence[Interface], middles: Float, outward: Float, normals: Float
) -> Bool | None:
    """Tell which edges (2, n) of flat ``contacts`` of two bodies are of the second one; None if some are of neither.

    Edges are told by their ``middles`` [m], the ``outward`` normals in the plane, and ``normals``, from the first body
    into the second, all (n, 3). Flush ones count first as edges of the first body, and then as edges of the second.
    """
    a, b = (assembly.scene.body(name) for name in contacts[0].bodies)
    near, patches = FLUSH * min(a.size, b.size), [patch for contact in contacts for patch in contact.patches]
    off = max(SHALLOW * near, *(2 * max(map(abs, patch.separation or (0.0,))) for patch in patches))
    in_a, in_b = (
        winding_number(middles + near * outward + sign * off * normals, body.surface_world) > INSIDE
        for body, sign in ((a, -1.0), (b, 1.0))
    )
    return None if (in_a & in_b).any() else np.array([in_a, ~in_b])


def _edges(patch: Patch) -> tuple[Float, Float]:
    """Return the middles (n, 2, 3) [m] of the edges before and after each corner of the hull, and their normals."""
    ring = patch.rings[0]
    at = np.asarray(search_tree(ring).query(patch.corners)[1])
    before, after = flat.turned(ring, -1), flat.turned(ring, 1)
    middles = patch.lifted(np.vstack([(ring + before)[at], (ring + after)[at]]) / 2)
    along = np.vstack([(ring - before)[at], (after - ring)[at]]) @ patch.frame
    outward = cross(along / np.linalg.norm(along, axis=1)[:, None], patch.normal)
    return tuple(np.stack(np.split(each, 2), axis=1) for each in (middles, outward))  # type: ignore[return-value]


def _of_differences(assembly: Assembly, pair: tuple[str, str], points: Float, normals: Float) -> NodeMotion:
    """Return the motion from contacts that are detected again."""
    size = min(assembly.scene.body(name).size for name in pair)
    origin, count = points.mean(axis=0), len(points)
    steps = STEP * np.array([size] * 3 + [1.0] * 3)
    shift, turn, changed = np.zeros((2, count, 3, 6)), np.zeros((2, count, 3, 6)), np.zeros(6, dtype=bool)
    moves = next(name for name in reversed(pair) if not assembly.scene.body(name).fixed)
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
    if moves != pair[1]:  # the motion of both bodies together is rigid
        across = np.eye(3) - normals[:, :, None] * normals[:, None, :]
        shift = _rigid(points - origin) - shift
        turn = np.concatenate([np.zeros((count, 3, 3)), across], axis=2) - turn
    shift[:, :, :, changed] = turn[:, :, :, changed] = 0.0
    return NodeMotion(origin, shift, turn, changed)


def _alone(assembly: Assembly, pair: tuple[str, str], moves: str) -> Assembly:
    """Return the two bodies alone, of which one ``moves``, with those that hide a part of their contact, if any do."""
    hidden = any("occluded" in one.flags for one in assembly.interfaces if set(one.bodies) == set(pair))
    touching = [one.bodies for one in assembly.interfaces if hidden and not set(pair).isdisjoint(one.bodies)]
    near = {*pair, *(name for bodies in touching for name in bodies)}
    bodies = tuple(altered(b, fixed=b.name != moves) for b in assembly.bodies if b.name in near)
    scene = altered(assembly.scene, bodies=bodies)
    return replace(assembly, scene=scene, interfaces=(), overlaps=(), occluded=())


def _found_again(
    points: Float, normals: Float, there: Assembly, pair: tuple[str, str], size: float
) -> tuple[Float, Float] | None:
    """Return the places of the nodes (n, 3) in an assembly and their normals, or None if there are others."""
    numbers = [k for k, one in enumerate(there.interfaces) if set(one.bodies) == set(pair)]
    nodes = contact_nodes(there, 4, "corners", among=numbers)
    if len(nodes) != len(points):
        return None
    same_way = [1.0 if there.interfaces[k].bodies == pair else -1.0 for k in nodes.interface.tolist()]
    ways = np.array(same_way)[:, None] * nodes.normals
    here, seen = np.hstack([points / size, normals]), np.hstack([nodes.points / size, ways])
    away, found = search_tree(seen).query(here)
    if max(np.max(away), np.max(search_tree(here).query(seen)[0])) > NEAR * STEP:
        return None
    return nodes.points[found], ways[found]


def _rigid(arms: Float) -> Float:
    """Return the matrices (n, 3, 6) that map a twist to the velocities at ``arms`` (n, 3)."""
    spins = np.stack([cross(axis, arms) for axis in np.eye(3)], axis=2)
    return np.concatenate([np.broadcast_to(np.eye(3), spins.shape), spins], axis=2)
