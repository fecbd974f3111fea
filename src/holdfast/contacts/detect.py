"""Contact detection: from bodies to interfaces, within a gap and an angle."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from holdfast.arrays import Float, frozen, unit
from holdfast.contacts import polygon as flat
from holdfast.contacts.clipping import Pieces, clip_surfaces
from holdfast.contacts.interface import Interface, Patch
from holdfast.rigid import tangents
from holdfast.scene.body import Body
from holdfast.scene.scene import Scene

RELATIVE_GAP = 1e-3  # default gap over the usual size of the movable bodies
USUAL_OVER_SMALLEST = 5  # the usual size is the median, but not more than this times the smallest
DEFAULT_ANGLE = 1.0  # [deg]
NEGLIGIBLE_WIDTH = 1e-6  # patches narrower than this, relative to the smaller body, are rounding
HAIRLINE = 1e-3  # of that width: gaps between pieces that belong together


@dataclass(frozen=True)
class Tolerances:
    """How far apart, or into each other, two surfaces may be and still touch: ``gap`` [m] and ``angle`` [deg]."""

    gap: float
    angle: float


def default_gap(scene: Scene) -> float:
    """A thousandth of the usual bounding-box diagonal of the movable bodies [m]; a huge one does not raise it."""
    sizes = [body_size(body) for body in scene.movable or scene.bodies]
    return RELATIVE_GAP * min(float(np.median(sizes)), USUAL_OVER_SMALLEST * min(sizes))


def body_size(body: Body) -> float:
    """Diagonal of the world bounding box [m]."""
    return float(np.linalg.norm(np.ptp(body.surface_world.vertices, axis=0)))


def box_distance(a: Body, b: Body) -> float:
    """Distance of the world bounding boxes [m]: never more than that of the bodies."""
    va, vb = a.surface_world.vertices, b.surface_world.vertices
    return float(np.linalg.norm(np.maximum(np.maximum(va.min(0) - vb.max(0), vb.min(0) - va.max(0)), 0)))


def find_interfaces(scene: Scene, tolerances: Tolerances) -> tuple[Interface, ...]:
    """All interfaces between bodies of which at least one can move, in the order of the bodies."""
    interfaces = []
    for a, b in neighbours(scene, tolerances.gap):
        patches = find_patches(a, b, tolerances)
        if patches:
            slim = all(patch.width < tolerances.gap for patch in patches)
            interfaces.append(Interface((a.name, b.name), patches=patches, flags=("sliver",) if slim else ()))
    return tuple(interfaces)


def neighbours(scene: Scene, gap: float) -> Iterator[tuple[Body, Body]]:
    """Pairs of bodies, not both fixed, whose bounding boxes come within ``gap``."""
    bodies = scene.bodies
    low = np.array([body.surface_world.vertices.min(0) for body in bodies]) - gap / 2
    high = np.array([body.surface_world.vertices.max(0) for body in bodies]) + gap / 2
    for i, j in itertools.combinations(range(len(bodies)), 2):
        if bodies[i].fixed and bodies[j].fixed:
            continue
        if (low[i] <= high[j]).all() and (low[j] <= high[i]).all():
            yield bodies[i], bodies[j]


def find_patches(a: Body, b: Body, tolerances: Tolerances) -> tuple[Patch, ...]:
    """Flat patches where ``a`` and ``b`` face each other; normals point into ``b``."""
    surface_a, surface_b = a.surface_world, b.surface_world
    pieces = clip_surfaces(
        surface_a.vertices[surface_a.faces],
        surface_a.normals,
        surface_b.vertices[surface_b.faces],
        surface_b.normals,
        gap=tolerances.gap,
        cos_angle=float(np.cos(np.radians(tolerances.angle))),
    )
    if not len(pieces.counts):
        return ()
    size = min(body_size(a), body_size(b))
    return _merged(pieces, tolerances, NEGLIGIBLE_WIDTH * size)


def _merged(pieces: Pieces, tolerances: Tolerances, negligible: float) -> tuple[Patch, ...]:
    """Pieces of one plane grow together: the largest piece left names the plane, its kin join it."""
    used = np.arange(pieces.corners.shape[1]) < pieces.counts[:, None]
    centres = np.where(used[..., None], pieces.corners, 0).sum(1) / pieces.counts[:, None]
    spread = np.where(used[..., None], pieces.corners - centres[:, None], 0)
    extent = np.abs(spread).max((1, 2))
    cos_angle = np.cos(np.radians(tolerances.angle))
    left = np.flatnonzero(extent > negligible / 2)
    patches: list[Patch] = []
    while len(left):
        seed = left[np.argmax(extent[left])]
        normal = pieces.normals[seed]
        offset = np.abs((centres[left] - centres[seed]) @ normal)
        kin = (pieces.normals[left] @ normal >= cos_angle) & (offset <= max(tolerances.gap, negligible))
        patches += _plane_patches(pieces, left[kin], centres[seed], negligible)
        left = left[~kin]
    return tuple(sorted(patches, key=lambda patch: -patch.area))


def _plane_patches(
    pieces: Pieces, members: np.ndarray[tuple[int], np.dtype[np.intp]], origin: Float, negligible: float
) -> list[Patch]:
    polygons = [pieces.polygon(int(i)) - origin for i in members]
    if len(members) == 1:
        normal = pieces.normals[members[0]]
    else:
        areas = np.array([np.linalg.norm(np.cross(p, np.roll(p, -1, axis=0)).sum(0)) for p in polygons])
        normal = unit((areas[:, None] * pieces.normals[members]).sum(0))
    frame = np.array(tangents(normal))
    level = float(np.mean([(p @ normal).mean() for p in polygons]))
    base = origin + level * normal
    corners = [p @ frame.T for p in polygons]
    patches = []
    for rings in flat.union(corners, HAIRLINE * negligible, negligible):
        outline, *holes = (frozen(base + ring @ frame) for ring in rings)
        patch = Patch(outline, frozen(normal.copy()), tuple(holes))
        if patch.width > negligible:
            patches.append(patch)
    return patches
