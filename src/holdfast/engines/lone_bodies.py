"""Bodies that touch nothing but fixed ones, on flat faces: their pressure is known from a formula, without any nodes.

On elastic contacts that press everywhere and slip nowhere, the stress on a face is linear in place (Navier's formula
for an eccentrically loaded footing, in any direction and with torsion). It follows from a stiffness matrix (6, 6) of
each body, which the area, the first and the second moments of its faces make up. If that stress presses at every corner
and stays within the friction cone there, it does so everywhere, and the body rests; else the formula says nothing.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from holdfast.assembly.assembly import FIXED, Assembly
from holdfast.assembly.strengths import strengths_of
from holdfast.base.arrays import Bool, Float, Int
from holdfast.base.rigid import cross
from holdfast.contacts.interface import Interface
from holdfast.engines.verdict import Look, Status, Verdict
from holdfast.scene.friction import NOTHING
from holdfast.scene.hold import held_names


@dataclass(frozen=True)
class _Faces:
    """The outlines and holes of faces on lone bodies, body by body: R rings with N corners in all.

    ``body`` (R,) is the place of the body among those asked about, ``normal`` (R, 3) points into it, and ``mu`` and
    ``stiffness`` (R,) belong to the interface. Ring r begins at corner ``first[r]`` of ``corners`` (N, 3) and has
    ``count[r]`` corners. ``outer`` (R,) tells outlines from holes.
    """

    body: Int
    normal: Float
    mu: Float
    stiffness: Float
    corners: Float
    first: Int
    count: Int
    outer: Bool


def firm_verdict(reason: str) -> Verdict:
    """Return the verdict, without forces, on a lone body that rests firmly, for the engine's own ``reason``."""
    at = "the stress under a lone body on flat faces, by a formula"
    steps = (Look(at, "every point presses, and friction is to spare"),)
    return Verdict(status=Status.STABLE, reason=reason, equilibrium_exists=True, self_stress=False, steps=steps)


def lone(assembly: Assembly) -> Int:
    """Return the numbers of the movable bodies that touch fixed bodies alone, certainly, and on flat faces alone.

    Nothing joins these faces, and nothing holds the bodies.
    """
    deep = {name for overlap in assembly.overlaps for name in overlap.bodies}
    deep |= held_names(assembly.scene.holds)
    found, strengths = [], strengths_of(assembly)
    for number, (body, contacts) in enumerate(zip(assembly.movable, assembly.interfaces_of, strict=True)):
        plain = all(FIXED in assembly.ends[k] and strengths[k] == NOTHING for k in contacts)
        if contacts and body.name not in deep and plain:
            found += [number] if all(_flat(assembly.interfaces[k]) for k in contacts) else []
    return np.array(found, dtype=np.int64)


def _flat(interface: Interface) -> bool:
    return interface.certain and all(len(p.polygon) > 2 and p.spots is None for p in interface.patches)


def rest_firmly(
    assembly: Assembly, bodies: Int, wrench: Float, *, spare: float, ratio: float = 1.0, stiffness: Float | None = None
) -> Bool:
    """Tell which of these lone ``bodies`` (n,) press on all of their faces and need less than their friction.

    ``wrench`` (6J,) [N, N m] acts on the assembly. The share ``spare`` of all friction is left alone, and every corner
    is pressed by more than that share of the greatest pressure on the body. Both also allow for nodes, which make the
    second moments of a face up to 2 % too small, 7 to a side: by 1 / 7². ``ratio`` is the
    tangential over the normal stiffness, and ``stiffness`` (interfaces,) the normal stiffness per area, 1 unless given.
    Where False, it is not known whether the body rests.
    """
    if not len(bodies):
        return np.zeros(0, dtype=bool)
    faces = _faces_of(assembly, bodies, np.ones(len(assembly.interfaces)) if stiffness is None else stiffness)
    ring = np.repeat(np.arange(len(faces.body)), faces.count)
    arms = faces.corners - assembly.com[bodies][faces.body][ring]
    size = np.zeros(len(bodies))
    np.maximum.at(size, faces.body[ring], np.linalg.norm(arms, axis=1))
    arms /= size[faces.body][ring, None]
    K = _stiffness(faces, arms, ratio, len(bodies))
    w = wrench.reshape(-1, 2, 3)[bodies] / np.stack([np.ones_like(size), size], axis=1)[:, :, None]
    try:
        q = np.linalg.solve(K, w.reshape(-1, 6, 1))[:, :, 0]
    except np.linalg.LinAlgError:  # of faces without any width
        return np.zeros(len(bodies), dtype=bool)
    outer = faces.outer[ring]
    ring, arms = ring[outer], arms[outer]
    own, normal = faces.body[ring], faces.normal[ring]
    moved: Float = q[own, :3] + cross(np.asarray(q[own, 3:]), arms)
    pressed = -(moved * normal).sum(axis=1)
    along = np.linalg.norm(moved + pressed[:, None] * normal, axis=1)
    most = np.zeros(len(bodies))
    np.maximum.at(most, own, faces.stiffness[ring] * pressed)
    firm = faces.stiffness[ring] * pressed > spare * most[own]
    firm &= ratio * along < (1 - spare) * faces.mu[ring] * pressed
    rests = most > 0
    np.logical_and.at(rests, own, firm)
    return rests


def _faces_of(assembly: Assembly, bodies: Int, stiffness: Float) -> _Faces:
    rings, normals, about, outer = [], [], [], []
    mu = assembly.mu
    for place, number in enumerate(bodies.tolist()):
        for k in assembly.interfaces_of[number]:
            into = assembly.ends[k][1] == number
            for patch in assembly.interfaces[k].patches:
                normal = patch.normal if into else -patch.normal
                for ring in (patch.polygon, *patch.holes):
                    rings.append(ring if into else ring[::-1])
                    normals.append(normal)
                    about.append((place, mu[k], stiffness[k]))
                    outer.append(ring is patch.polygon)
    count = np.array([len(ring) for ring in rings])
    body, own_mu, own_stiffness = np.array(about).T
    return _Faces(
        body=body.astype(np.int64),
        normal=np.array(normals),
        mu=own_mu,
        stiffness=own_stiffness,
        corners=np.concatenate(rings),
        first=np.cumsum(count) - count,
        count=count,
        outer=np.array(outer),
    )


def _stiffness(faces: _Faces, arms: Float, ratio: float, bodies: int) -> Float:
    """Return the stiffness matrices (bodies, 6, 6) about the origin of ``arms`` (N, 3), the corners of all rings.

    Rings are split into triangles around their first corners. Those that run the other way, as holes do, have negative
    areas. The integrals of 1, x and x xᵀ over a triangle are exact.
    """
    ring = np.repeat(np.arange(len(faces.count)), faces.count - 2)
    second = faces.first[ring] + 1 + np.arange(len(ring)) - (np.cumsum(faces.count - 2) - (faces.count - 2))[ring]
    v = np.stack([arms[faces.first[ring]], arms[second], arms[second + 1]])
    n = faces.normal[ring]
    area = 0.5 * (cross(v[1] - v[0], v[2] - v[0]) * n).sum(axis=1) * faces.stiffness[ring]
    total = v.sum(axis=0)
    first = area[:, None] / 3 * total
    squares = np.einsum("kti,ktj->tij", v, v) + total[:, :, None] * total[:, None, :]
    squares *= area[:, None, None] / 12
    unit, turn = np.eye(3), _matrix(n)
    K = np.empty((len(ring), 6, 6))
    normal_part = 1 - ratio
    along = n[:, :, None] * n[:, None, :]
    K[:, :3, :3] = area[:, None, None] * (normal_part * along + ratio * unit)
    lever = normal_part * cross(first, n)[:, :, None] * n[:, None, :] + ratio * _matrix(first)
    K[:, 3:, :3], K[:, :3, 3:] = lever, lever.transpose(0, 2, 1)
    inertia = np.trace(squares, axis1=1, axis2=2)[:, None, None] * unit - squares
    K[:, 3:, 3:] = normal_part * turn @ squares @ turn.transpose(0, 2, 1) + ratio * inertia
    own = faces.body[ring]  # in ascending order, and every body has a ring
    return np.add.reduceat(K, np.searchsorted(own, np.arange(bodies)))


def _matrix(a: Float) -> Float:
    """Return the matrices (n, 3, 3) of the cross products of a (n, 3) with what follows."""
    M = np.zeros((len(a), 3, 3))
    M[:, 0, 1], M[:, 0, 2], M[:, 1, 2] = -a[:, 2], a[:, 1], -a[:, 0]
    return M - M.transpose(0, 2, 1)
