"""Contact detection: the interfaces between bodies, within a gap and an angle tolerance."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass
from statistics import median
from typing import NamedTuple, TypeVar

import numpy as np

from holdfast.base.archive import archived
from holdfast.base.progress import reported
from holdfast.base.values import Value
from holdfast.contacts.clipping import clip_faces
from holdfast.contacts.compound_parts import cuboid_towards
from holdfast.contacts.cuboids import Near, patches_of
from holdfast.contacts.facing_polygons import facing_pairs, facing_polygons
from holdfast.contacts.features import touching_features
from holdfast.contacts.flags import flags_of, is_certain
from holdfast.contacts.flat_ends import on_end
from holdfast.contacts.flush import lie_flat
from holdfast.contacts.interface import Interface, Patch
from holdfast.contacts.known_planes import features_on_planes, pieces_on_planes
from holdfast.contacts.materials import by_material
from holdfast.contacts.merging import merged
from holdfast.contacts.occlusion import Fronts, Pair
from holdfast.contacts.patches import face_patches, line_patches, point_patches
from holdfast.contacts.round_contacts import feet, meet_smoothly, not_at
from holdfast.contacts.round_on_plane import on_plane
from holdfast.contacts.search_mesh import (
    LARGE,
    SearchMesh,
    in_common_box,
    near_but_facets,
    near_faces,
    near_facets,
)
from holdfast.contacts.tolerances import Tolerances, plain_gap
from holdfast.native import core
from holdfast.scene.body import Body
from holdfast.scene.scene import Scene

T = TypeVar("T")
NEGLIGIBLE_WIDTH = 1e-6  # width, relative to the size of the smaller body, below which a patch is a rounding error
NOMINAL_BREADTH = 1e-3  # width of a line or a point in the weights of nodes, relative to the size of the smaller body


def box_distance(a: Body, b: Body) -> float:
    """Return the distance of the world bounding boxes [m], which is a lower bound of the distance of the bodies."""
    (low_a, high_a), (low_b, high_b) = a.box, b.box
    return float(np.linalg.norm(np.maximum(np.maximum(low_a - high_b, low_b - high_a), 0)))


@archived
@dataclass(frozen=True, eq=False, repr=False)
class Contacts(Value):
    """The interfaces of a scene, and the ``occluded`` pairs, which would touch if no third body lay between them."""

    interfaces: tuple[Interface, ...]
    occluded: tuple[tuple[str, str], ...]


class Touching(NamedTuple):
    """Where two bodies would touch if there were no third bodies.

    ``parts`` holds the patches of each pair from ``Scene.touching``, and ``patches`` all of them together.
    """

    parts: tuple[tuple[Body, Body, tuple[Patch, ...]], ...]
    patches: tuple[Patch, ...]


class Shown(NamedTuple):
    """Where two bodies are ``touching``, what third bodies have ``left`` of that, and the resulting ``interfaces``.

    ``left`` holds the remaining patches of each of ``touching.parts``. If nothing is left, there are no interfaces.
    """

    touching: Touching
    left: tuple[tuple[Patch, ...], ...]
    interfaces: tuple[Interface, ...]


def find_contacts(scene: Scene, tolerances: Tolerances, *, merge: bool = True) -> Contacts:
    """Find all interfaces between bodies of which at least one is movable, in the order of the bodies.

    If poses are uncertain, no interface is certain. Many patches between two bodies are merged into few, unless
    ``merge`` is False.
    """
    shown = show(scene, tolerances, find_all_patches(scene, tolerances), merge=merge)
    return Contacts(
        tuple(interface for each in shown.values() for interface in each.interfaces),
        tuple(pair for pair, each in shown.items() if not each.interfaces),
    )


def find_all_patches(
    scene: Scene,
    tolerances: Tolerances,
    known: Mapping[Pair, Touching] | None = None,
    same: Collection[str] = (),
    near: Sequence[tuple[Body, Body]] | None = None,
) -> dict[Pair, Touching]:
    """Find where all pairs of bodies would touch if there were no third bodies, in the order of the bodies.

    Between bodies named in ``same``, the result is taken from ``known``. ``near`` can pass all other pairs that are
    near enough to touch, as ``neighbours`` yields them.
    """
    pairs = list(neighbours(scene, tolerances.widest(scene), same)) if near is None else near
    found: dict[Pair, list[tuple[Body, Body, tuple[Patch, ...]]]] = {}
    for a, b, patches in _patches_between(scene, tolerances, pairs):
        if patches:
            found.setdefault((a.name, b.name), []).append((a, b, patches))
    result = {pair: touching for pair, touching in (known or {}).items() if pair[0] in same and pair[1] in same}
    for pair, parts in found.items():
        result[pair] = Touching(tuple(parts), tuple(patch for *_, patches in parts for patch in patches))
    return in_order(result, scene)


def _patches_between(
    scene: Scene, tolerances: Tolerances, pairs: Sequence[tuple[Body, Body]]
) -> Iterator[tuple[Body, Body, tuple[Patch, ...]]]:
    """Yield each of the pairs of bodies with the patches where they touch.

    Pairs of cuboids, and of round bodies on them, come first; triangles are searched only for the remaining pairs.
    """
    meshes: dict[int, SearchMesh] = {}
    own = [tolerances.between(scene.body(a.name), scene.body(b.name)) for a, b in pairs]
    known = [
        of_round(a, b, near) if found is None else found
        for (a, b), near, found in zip(pairs, own, of_cuboids(pairs, own), strict=True)
    ]
    uses = Counter(id(body) for k, pair in enumerate(pairs) if known[k] is None for body in pair)
    for k, (a, b) in enumerate(reported("contacts", pairs)):
        patches = known[k]
        if patches is None:
            for body in (a, b):
                if id(body) not in meshes:
                    meshes[id(body)] = SearchMesh.of(body)
            patches = find_patches(a, b, meshes[id(a)], meshes[id(b)], own[k])
            for body in (a, b):
                uses[id(body)] -= 1
                if not uses[id(body)]:
                    del meshes[id(body)]  # free the memory
        yield a, b, patches


def of_cuboids(pairs: Sequence[tuple[Body, Body]], tolerances: Sequence[Tolerances]) -> list[tuple[Patch, ...] | None]:
    """Return the patches of each pair that meets as cuboids in closed form, and None for all other pairs."""
    numbers, near = [], []
    for k, ((a, b), own) in enumerate(zip(pairs, tolerances, strict=True)):
        one, two = cuboid_towards(a, b, own.gap), cuboid_towards(b, a, own.gap)
        if one is not None and two is not None:
            size = min(a.size, b.size)
            numbers.append(k)
            near.append(Near(one, two, own.gap, size, NEGLIGIBLE_WIDTH * size))
    found: list[tuple[Patch, ...] | None] = [None] * len(pairs)
    for k, patches in zip(numbers, patches_of(near), strict=True):
        found[k] = patches
    return found


def of_round(a: Body, b: Body, tolerances: Tolerances) -> tuple[Patch, ...] | None:
    """Return the patches of a round body on a plane face in closed form, and None for all other pairs."""
    gap, depth, size = tolerances.gap, tolerances.depth, min(a.size, b.size)
    breadth = NOMINAL_BREADTH * size
    found = on_plane(a, b, tolerances, breadth)
    if found is None:
        face = on_end(a, b, tolerances, NEGLIGIBLE_WIDTH * size)
        if face is not None and not feet(a, b, gap=gap, depth=depth, breadth=breadth, angles=tolerances.angles):
            found = (face,)
    return found


def show(
    scene: Scene,
    tolerances: Tolerances,
    found: Mapping[Pair, Touching],
    known: Mapping[Pair, Shown] | None = None,
    changed: Set[str] = frozenset(),
    *,
    merge: bool = True,
) -> dict[Pair, Shown]:
    """Return the interfaces of pairs of bodies that touch, without what third bodies hide.

    ``known`` can pass an earlier result; only bodies named in ``changed`` have other patches than then. If the visible
    patches of a pair are the same as before, its interfaces are the same objects. ``merge`` is as in ``find_contacts``.
    """
    result: dict[Pair, Shown] = {}
    fronts = Fronts({pair: touching.patches for pair, touching in found.items()})
    for pair, touching in found.items():
        before = None if known is None else known.get(pair)
        if before is None or before.touching is not touching:
            before = None
        elif pair[0] not in changed and pair[1] not in changed:
            result[pair] = before
            continue
        a, b = (scene.body(name) for name in pair)
        gap, width = tolerances.between(a, b).gap, NEGLIGIBLE_WIDTH * min(a.size, b.size)
        left = tuple(tuple(fronts.visible(patches, pair, gap, width)) for *_, patches in touching.parts)
        if before is not None and left == before.left:
            result[pair] = before
        else:
            result[pair] = Shown(touching, left, _interfaces(scene, tolerances, (a, b), touching, left, merge=merge))
    return result


def _interfaces(
    scene: Scene,
    tolerances: Tolerances,
    bodies: tuple[Body, Body],
    touching: Touching,
    left: tuple[tuple[Patch, ...], ...],
    *,
    merge: bool,
) -> tuple[Interface, ...]:
    """Return the interfaces of two ``bodies`` that are ``touching``; ``left`` are the patches that are not hidden."""
    rest = tuple(patch for patches in left for patch in patches)
    if not rest:
        return ()
    a, b = bodies
    own = tolerances.between(a, b)
    flags = flags_of(a, b, rest, own.gap, hidden=rest != touching.patches)
    sagitta = a.shape.surface.sagitta + b.shape.surface.sagitta
    certain = not tolerances.capped and is_certain(
        rest, flags, gap=tolerances.base(a, b), usual=plain_gap(a, b), sagitta=sagitta
    )
    shares: dict[float | None, list[Patch]] = {}
    for (one, two, _), patches in zip(touching.parts, left, strict=True):
        for mu, piece in by_friction(scene, one, two, patches, own.gap).items():
            shares.setdefault(mu, []).extend(piece)
    interfaces = []
    for mu, share in shares.items():
        few = merged(share, own.gap, own.angle) if merge else tuple(share)
        all_flags = (*flags, "merged") if any(patch.spots is not None for patch in few) else flags
        interfaces.append(Interface((a.name, b.name), patches=few, flags=all_flags, certain=certain, mu=mu))
    return tuple(interfaces)


def by_friction(
    scene: Scene, a: Body, b: Body, patches: Sequence[Patch], gap: float
) -> dict[float | None, list[Patch]]:
    """Return the patches by friction coefficient; the key is None where the coefficient of the two bodies holds."""
    if not patches or all({*body.materials} == {body.material} for body in (a, b)):
        return {None: list(patches)} if patches else {}
    found: dict[float | None, list[Patch]] = {}
    for (of_a, of_b), piece in by_material(a, b, patches, gap).items():
        mu = scene.friction.between(a.name, b.name, {a.name: of_a, b.name: of_b})
        found.setdefault(mu, []).extend(piece)
    return found


def in_order(by_pair: Mapping[Pair, T], scene: Scene) -> dict[Pair, T]:
    """Return a dict by pairs of bodies, sorted by the order of the bodies in the scene."""
    place = {body.name: k for k, body in enumerate(scene.bodies)}
    return {pair: by_pair[pair] for pair in sorted(by_pair, key=lambda pair: (place[pair[0]], place[pair[1]]))}


def neighbours(scene: Scene, gap: float, same: Collection[str] = ()) -> Iterator[tuple[Body, Body]]:
    """Yield the pairs of bodies, neither both fixed nor excluded, whose bounding boxes come within ``gap`` [m].

    Pairs of two bodies named in ``same`` are left out. If only some parts of two bodies may touch, bodies with only
    these parts are yielded, one pair for each set of parts that may touch each other (``Scene.touching``).
    """
    bodies = scene.bodies
    low = np.array([body.box[0] for body in bodies]).reshape(-1, 3) - gap / 2
    high = np.array([body.box[1] for body in bodies]).reshape(-1, 3) + gap / 2
    axis = int(np.argmax(np.ptp(low, axis=0)))
    length = high[:, axis] - low[:, axis]
    asked = np.array([body.name not in same for body in bodies], dtype=bool)
    order = np.argsort(low[:, axis], kind="stable")
    order = order[asked[order]]
    if not len(order):
        return
    # a floor is near to everything, so large bodies are searched separately
    wide = length[order] > LARGE * median(length.tolist())
    found = []
    for part in (order[~wide], order[wide]):
        if not len(part):
            continue
        near = core.near_boxes(low, high, low[part], high[part], axis, 0.0)
        found.append(np.column_stack([near[:, 0], part[near[:, 1]]]))
    pairs = np.concatenate(found)
    fixed = np.array([body.fixed for body in bodies], dtype=bool)
    once = (pairs[:, 0] < pairs[:, 1]) | ~asked[pairs[:, 0]]
    pairs = np.sort(pairs[once & ~fixed[pairs].all(1)], axis=1)
    for i, j in pairs[np.lexsort(pairs.T[::-1])].tolist():
        yield from scene.touching(bodies[i], bodies[j])


class TooFineError(Exception):
    """The faces of two bodies meet in more pieces than ``find_patches`` was allowed to join."""


def find_patches(
    a: Body, b: Body, mesh_a: SearchMesh, mesh_b: SearchMesh, tolerances: Tolerances, most: float = np.inf
) -> tuple[Patch, ...]:
    """Find the patches where two bodies touch, with normals that point into ``b``.

    Faces come first, then lines where no face touches, then points where neither touches. Raises TooFineError if
    more than ``most`` pairs of triangles meet: to join the pieces costs far more than to find them.
    """
    gap, depth, size = tolerances.gap, tolerances.depth, min(a.size, b.size)
    breadth = NOMINAL_BREADTH * size
    found = [] if meet_smoothly(a, b) else _on_triangles(a, b, mesh_a, mesh_b, tolerances, most)
    if found is None:
        return ()
    exact = feet(a, b, gap=gap, depth=depth, breadth=breadth, angles=tolerances.angles)
    if not exact:
        return tuple(found)
    true_gap = gap - a.shape.surface.sagitta - b.shape.surface.sagitta
    touching = [foot.patch(breadth) for foot in exact if foot.heights.min() <= max(true_gap, 0.0)]
    return (*touching, *not_at(exact, found))


def _on_triangles(
    a: Body, b: Body, mesh_a: SearchMesh, mesh_b: SearchMesh, tolerances: Tolerances, most: float
) -> list[Patch] | None:
    """Find the patches of two tessellated bodies; None if no faces are near each other.

    Bodies of many triangles usually rest on each other with large flat faces. If these account for the whole contact,
    no triangles have to be searched.
    """
    gap, depth, size = tolerances.gap, tolerances.depth, min(a.size, b.size)
    negligible, breadth = NEGLIGIBLE_WIDTH * size, NOMINAL_BREADTH * size
    angles = tolerances.angles
    locals_ = a.shape.surface.reduced, b.shape.surface.reduced
    facets = near_facets(mesh_a, mesh_b, gap)
    facing, left = facing_polygons(mesh_a, mesh_b, *locals_, facets, gap=gap, depth=depth, angles=angles)
    of_facets = tuple(
        np.isin(mesh.facet, sorted({two[k] for two in facets})) for k, mesh in enumerate((mesh_a, mesh_b))
    )
    if any(facing.values()) and not left:
        large = [piece for pieces in facing.values() for piece in pieces]
        faces = face_patches(pieces_on_planes(a, b, large, tolerances), gap, angles, negligible)
        near_a, near_b = (one | two for one, two in zip(in_common_box(mesh_a, mesh_b, gap), of_facets, strict=True))
        if lie_flat(mesh_a, mesh_b, near_a, near_b, faces, gap=gap, size=size, by_large=True):
            return faces
    pairs = near_but_facets(mesh_a, mesh_b, gap)
    if not len(pairs) and not facets:
        return None
    mixed, small = facing_pairs(mesh_a, mesh_b, pairs, cos_angle=float(np.cos(np.radians(angles.flat))))
    also, _ = facing_polygons(mesh_a, mesh_b, *locals_, mixed, gap=gap, depth=depth, angles=angles)
    large = [piece for _, pieces in sorted({**facing, **also}.items()) for piece in pieces]
    pairs = np.concatenate([pairs, *(near_faces(mesh_a, mesh_b, gap, two) for two in left)])
    pieces = [*large, *clip_faces(mesh_a, mesh_b, small, gap=gap, depth=depth, angles=angles)]
    if len(pieces) > most:
        raise TooFineError
    faces = face_patches(pieces_on_planes(a, b, pieces, tolerances), gap, angles, negligible)
    near_a, near_b = of_facets
    near_a[pairs[:, 0]] = near_b[pairs[:, 1]] = True
    if lie_flat(mesh_a, mesh_b, near_a, near_b, faces, gap=gap, size=size):
        return faces
    lines, points = touching_features(
        mesh_a, mesh_b, pairs, gap=gap, depth=depth, angles=angles, size=size, strict=negligible
    )
    lines, points = (features_on_planes(a, b, each, tolerances) for each in (lines, points))
    along = line_patches(lines, faces, gap, negligible, breadth)
    return [*faces, *along, *point_patches(points, [*faces, *along], gap, breadth)]
