"""How the load at which a tree gives way changes with all that it depends on (implicit function theorem).

A load gives way where F = 0: the friction asked for along the motion m less its power, or how far the centre of
pressure is beyond an edge of the hull. Both are functions of what the contact carries and of its faces, so the factor R
of the load changes by dR = -dF / (∂F/∂R). As a function of what acts on the bodies beyond, F changes like the power in
a ``twist`` of them, which is not their motion alone: the pressure, too, follows what is carried, and friction it.

The faces lie halfway between the two bodies: the plane moves with half the motion of each, and each edge of a face,
which is one of either body, with half the motion of that body against the other (node_motion.py says when).
"""

from __future__ import annotations

import numpy as np

from holdfast.assembly.assembly import Assembly
from holdfast.assembly.node_motion import edges_of_second
from holdfast.base.arrays import Float, Int
from holdfast.base.rigid import cross
from holdfast.engines.contract import Slope
from holdfast.engines.trees.forest import Bridge, Forest
from holdfast.native import core

GAUSS = np.polynomial.legendre.leggauss(12)  # along each edge
CORNER = 1e-6  # distance from an edge of the hull, in sizes of the contact, up to which a corner is on it


def slope_of(forest: Forest, load: Float) -> Slope | None:
    """Return the derivatives of the factor of ``load`` (6J,), which loads only bodies that are decided.

    None where they are not known: if nothing gives way, several contacts or edges do at once, or it lies between faces
    of several bodies or coefficients.
    """
    found = forest.exits(load[:, None])
    number, factor = int(found.bridge[0]), float(found.factor[0])
    if number < 0 or not 0 < factor < np.inf or found.tied[0]:
        return None
    bridge, assembly = forest.bridges[number], forest.assembly
    pairs = {assembly.interfaces[k].bodies for k in bridge.interfaces}
    if len(pairs) > 1 or not bridge.bed.size[1] > 0:
        return None
    owners = _owners(assembly, bridge)
    if owners is None:
        return None
    wrenches = np.stack([forest.wrench + factor * load, load]).reshape(2, -1, 6)
    limit, alone = bridge.carried(assembly.com, wrenches)
    law = _slides(bridge, limit) if found.slides[0] else _tips(bridge, limit)
    if law is None:
        return None
    by_carried, by_mu, edges, places, by_edges = law
    scale = float(by_carried @ alone)
    frame, g = bridge.frame, by_carried
    spin = np.array([-g[2], g[1], -g[5]]) @ frame
    velocity = np.array([-g[3], -g[4], -g[0]]) @ frame - cross(spin, bridge.origin)
    own, at = wrenches[0, bridge.beyond], assembly.com[bridge.beyond]
    force, torque = own[:, :3].sum(0), (own[:, 3:] + cross(at, own[:, :3])).sum(0)
    plane = np.concatenate([cross(spin, force), cross(velocity, force) + cross(spin, torque)])
    return Slope(
        factor=factor,
        assembly=assembly,
        pair=next(iter(pairs)),
        beyond=bridge.beyond,
        twist=np.concatenate([velocity, spin]) / scale,
        by_friction=-by_mu / scale,
        by_plane=-plane / scale,
        by_edges=-by_edges / scale,
        places=bridge.origin + places @ bridge.frame[:2],
        outward=_outward(bridge)[edges],
        owners=owners[edges],
    )


def _owners(assembly: Assembly, bridge: Bridge) -> Int | None:
    """Tell which edges (E,) of the bed are those of the second body, 1, the first, -1, or both, 0; None if of none."""
    contacts = [assembly.interfaces[k] for k in bridge.interfaces]
    middles = bridge.origin + (bridge.bed.edges[:, :2] + bridge.bed.edges[:, 2:4]) / 2 @ bridge.frame[:2]
    into = 1.0 if assembly.ends[bridge.interfaces[0]][0] == bridge.root else -1.0
    normals = np.broadcast_to(into * bridge.frame[2], middles.shape)
    of_second = edges_of_second(assembly, contacts, middles, _outward(bridge), normals)
    return None if of_second is None else of_second.sum(axis=0) - 1


# derivatives of F by what is carried (6,) and by μ; then numbers of edges (n,), places on them (n, 2), and the
# derivatives by how far these move outwards (n,)
Law = tuple[Float, float, Int, Float, Float]


def _slides(bridge: Bridge, limit: Float) -> Law | None:
    """Return the derivatives of the friction asked for less its power, where a contact slides under ``limit`` (6,)."""
    bed = bridge.bed
    found = core.sliding_under(bed, limit)
    if found is None:
        return None
    pressure_of, motion, by_carried, power = found
    mu, parts = float(bed.size[1]), core.pressed_parts(bed, pressure_of)
    share, heads, tails = (GAUSS[0][:, None, None] + 1) / 2, parts[:, :2], parts[:, 2:]
    x = heads + share * (tails - heads)  # (12, E, 2)
    length = np.linalg.norm(tails - heads, axis=1)
    pressure = np.maximum(pressure_of[0] + x @ pressure_of[1:], 0.0)
    speed = np.hypot(motion[0] - motion[2] * x[..., 1], motion[1] + motion[2] * x[..., 0])
    density = pressure * (by_carried[0] + x @ by_carried[1:] - mu * speed)
    weights = GAUSS[1][:, None] / 2 * density * length
    edges = np.tile(np.arange(len(heads)), len(x))
    return np.concatenate([-by_carried, motion]), -power / mu, edges, x.reshape(-1, 2), weights.ravel()


def _tips(bridge: Bridge, limit: Float) -> Law | None:
    """Return the derivatives of N times how far the centre of pressure is beyond the edge that it reaches."""
    bed = bridge.bed
    row = bed.hull[np.argmin(bed.hull @ limit[:3])]
    heads = bed.edges[:, :2]
    on = np.flatnonzero(row[0] + heads @ row[1:] <= CORNER * bed.size[0])
    along = heads[on] @ np.array([row[2], -row[1]])
    first, last = on[np.argmin(along)], on[np.argmax(along)]
    span = np.ptp(along)
    if not span > CORNER * bed.size[0]:
        return None
    place = (limit[1:3] / limit[0] @ np.array([row[2], -row[1]]) - along.min()) / span
    outward = _outward(bridge) @ bridge.frame[:2].T
    edges, weights = list[int](), list[float]()
    for corner, share in ((first, 1 - place), (last, place)):
        before = int(np.flatnonzero((bed.edges[:, 2:4] == heads[corner]).all(axis=1))[0])
        each = np.linalg.lstsq(outward[[before, corner]].T, -row[1:], rcond=1e-9)[0]
        edges += [before, int(corner)]
        weights += (-limit[0] * share * each).tolist()
    at = heads[[first, first, last, last]]
    return np.concatenate([-row, np.zeros(3)]), 0.0, np.array(edges), at, np.array(weights)


def _outward(bridge: Bridge) -> Float:
    """Return the normals (E, 3), in the plane, that point out of the faces at their edges."""
    along = bridge.bed.edges[:, 2:4] - bridge.bed.edges[:, :2]
    flat = np.column_stack([along[:, 1], -along[:, 0]]) / np.linalg.norm(along, axis=1)[:, None]
    return np.asarray(flat @ bridge.frame[:2])
