"""Contact detection: the interfaces between bodies, within a gap and an angle tolerance."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass
from typing import NamedTuple, TypeVar

import numpy as np

from holdfast.base.archive import archived
from holdfast.base.progress import reported
from holdfast.base.values import Value, made
from holdfast.contacts.clipping import clip_faces
from holdfast.contacts.compound_parts import cuboid_towards
from holdfast.contacts.cuboids import Cuboids, patches_of
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
    SearchMesh,
    in_common_box,
    near_but_facets,
    near_faces,
    near_facets,
)
from holdfast.contacts.tolerances import OfPair, Tolerances
from holdfast.native import core
from holdfast.scene.body import Body, place_cuboids
from holdfast.scene.compound import Compound
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

    ``parts`` holds the patches of each pair from ``Scene.touching``, ``patches`` all of them together, and ``limits``
    the tolerances of the two.
    """

    parts: tuple[tuple[Body, Body, tuple[Patch, ...]], ...]
    patches: tuple[Patch, ...]
    limits: OfPair


class Near(NamedTuple):
    """Two bodies, or some parts of them, that are near each other, and the tolerances of the whole bodies.

    ``shared`` [m] is how far their bounding boxes overlap (``shared_length``).
    """

    a: Body
    b: Body
    shared: float
    limits: OfPair


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
    near: Sequence[Near] | None = None,
) -> dict[Pair, Touching]:
    """Find where all pairs of bodies would touch if there were no third bodies, in the order of the bodies.

    Between bodies named in ``same``, the result is taken from ``known``. ``near`` can pass all other pairs that are
    near enough to touch.
    """
    near = near_pairs(scene, tolerances, tolerances.widest(scene), same) if near is None else near
    result = {pair: touching for pair, touching in (known or {}).items() if pair[0] in same and pair[1] in same}
    for one, patches in _patches_between(near):
        if patches:
            pair = one.a.name, one.b.name
            parts, others = ((), ()) if (first := result.get(pair)) is None else (first.parts, first.patches)
            result[pair] = Touching((*parts, (one.a, one.b, patches)), (*others, *patches), one.limits)
    return in_order(result, scene) if known else result


def near_pairs(scene: Scene, tolerances: Tolerances, gap: float, same: Collection[str] = ()) -> list[Near]:
    """Return the pairs of ``neighbours``."""
    found = list(_near(scene, gap, same))
    limits = tolerances.of_pairs([(scene.body(a.name), scene.body(b.name)) for a, b, _ in found])
    return [Near(*each, own) for each, own in zip(found, limits, strict=True)]


def _patches_between(near: Sequence[Near]) -> Iterator[tuple[Near, tuple[Patch, ...]]]:
    """Yield each of the pairs of bodies with the patches where they touch.

    Pairs of cuboids, and of round bodies on them, come first; triangles are searched only for the remaining pairs.
    """
    meshes: dict[int, SearchMesh] = {}
    as_cuboids = of_cuboids([(one.a, one.b) for one in near], [one.limits.own for one in near])
    known = [
        of_round(one.a, one.b, one.limits.own) if found is None else found
        for one, found in zip(near, as_cuboids, strict=True)
    ]
    uses = Counter(id(body) for k, one in enumerate(near) if known[k] is None for body in (one.a, one.b))
    for k, one in enumerate(reported("contacts", near)):
        patches = known[k]
        if patches is None:
            a, b, _, limits = one
            for body in (a, b):
                if id(body) not in meshes:
                    meshes[id(body)] = SearchMesh.of(body)
            patches = find_patches(a, b, meshes[id(a)], meshes[id(b)], limits.own)
            for body in (a, b):
                uses[id(body)] -= 1
                if not uses[id(body)]:
                    del meshes[id(body)]  # free the memory
        yield one, patches


def of_cuboids(pairs: Sequence[tuple[Body, Body]], tolerances: Sequence[Tolerances]) -> list[tuple[Patch, ...] | None]:
    """Return the patches of each pair that meets as cuboids in closed form, and None for all other pairs."""
    numbers, near = [], []
    for k, ((a, b), own) in enumerate(zip(pairs, tolerances, strict=True)):
        one, two = cuboid_towards(a, b, own.gap), cuboid_towards(b, a, own.gap)
        if one is not None and two is not None:
            size = min(a.size, b.size)
            numbers.append(k)
            near.append(Cuboids(one, two, own.gap, size, NEGLIGIBLE_WIDTH * size))
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
        a, b = scene.body(pair[0]), scene.body(pair[1])
        gap, width = touching.limits.own.gap, NEGLIGIBLE_WIDTH * min(a.size, b.size)
        left = tuple([fronts.visible(patches, pair, gap, width) for *_, patches in touching.parts])
        if before is not None and left == before.left:
            result[pair] = before
        else:
            found_now = _interfaces(scene, (a, b), touching, left, posed=not tolerances.capped, merge=merge)
            result[pair] = Shown(touching, left, found_now)
    return result


def _interfaces(
    scene: Scene,
    bodies: tuple[Body, Body],
    touching: Touching,
    left: tuple[tuple[Patch, ...], ...],
    *,
    posed: bool,
    merge: bool,
) -> tuple[Interface, ...]:
    """Return the interfaces of two ``bodies`` that are ``touching``; ``left`` are the patches that are not hidden.

    ``posed`` says that the poses are as given.
    """
    rest = left[0] if len(left) == 1 else tuple(patch for patches in left for patch in patches)
    if not rest:
        return ()
    a, b = bodies
    own, base, usual, sagitta = touching.limits
    flags = flags_of(a, b, rest, own.gap, hidden=rest != touching.patches)
    certain = posed and is_certain(rest, flags, gap=base, usual=usual, sagitta=sagitta)
    shares: dict[float | None, list[Patch]] = {}
    if _mixed(a) or _mixed(b):
        for (one, two, _), patches in zip(touching.parts, left, strict=True):
            for mu, piece in by_friction(scene, one, two, patches, own.gap).items():
                shares.setdefault(mu, []).extend(piece)
    else:
        shares[None] = list(rest)
    pair = a.name, b.name
    interfaces = []
    for mu, share in shares.items():
        few = merged(share, own.gap, own.angle) if merge else tuple(share)
        more = (*flags, "merged") if any(patch.spots is not None for patch in few) else flags
        found = made(Interface, bodies=pair, patches=few, status="touching", flags=more, certain=certain, mu=mu)
        interfaces.append(found)
    return tuple(interfaces)


def by_friction(
    scene: Scene, a: Body, b: Body, patches: Sequence[Patch], gap: float
) -> dict[float | None, list[Patch]]:
    """Return the patches by friction coefficient; the key is None where the coefficient of the two bodies holds."""
    if not patches or not (_mixed(a) or _mixed(b)):
        return {None: list(patches)} if patches else {}
    found: dict[float | None, list[Patch]] = {}
    for (of_a, of_b), piece in by_material(a, b, patches, gap).items():
        mu = scene.friction.between(a.name, b.name, {a.name: of_a, b.name: of_b})
        found.setdefault(mu, []).extend(piece)
    return found


def _mixed(body: Body) -> bool:
    """Tell whether a part of a body is not of its material."""
    return isinstance(body.shape, Compound) and {*body.materials} != {body.material}


def in_order(by_pair: Mapping[Pair, T], scene: Scene) -> dict[Pair, T]:
    """Return a dict by pairs of bodies, sorted by the order of the bodies in the scene."""
    place = {body.name: k for k, body in enumerate(scene.bodies)}
    return {pair: by_pair[pair] for pair in sorted(by_pair, key=lambda pair: (place[pair[0]], place[pair[1]]))}


def neighbours(scene: Scene, gap: float, same: Collection[str] = ()) -> Iterator[tuple[Body, Body]]:
    """Yield the pairs of bodies, neither both fixed nor excluded, whose bounding boxes come within ``gap`` [m].

    Pairs of two bodies named in ``same`` are left out. If only some parts of two bodies may touch, bodies with only
    these parts are yielded, one pair for each set of parts that may touch each other (``Scene.touching``).
    """
    for a, b, _ in _near(scene, gap, same):
        yield a, b


def _near(scene: Scene, gap: float, same: Collection[str]) -> Iterator[tuple[Body, Body, float]]:
    """Yield the pairs of ``neighbours``, and how far [m] their bounding boxes overlap, negative if they are apart."""
    bodies = scene.bodies
    place_cuboids(bodies)
    boxes = np.array([body.box for body in bodies]).reshape(-1, 2, 3)
    fixed = np.array([body.fixed for body in bodies], dtype=bool)
    asked = np.array([body.name not in same for body in bodies], dtype=bool)
    pairs, shared = core.near_bodies(boxes, fixed, asked, gap)
    for (i, j), along in zip(pairs.tolist(), shared.tolist(), strict=True):
        a, b = bodies[i], bodies[j]
        for one, two in scene.touching(a, b):
            whole = one is a and two is b
            yield one, two, along if whole else shared_length(one, two)


def shared_length(a: Body, b: Body) -> float:
    """Return how far [m] the bounding boxes of two bodies overlap, along the axis of least overlap."""
    (low_a, high_a), (low_b, high_b) = a.box, b.box
    return float((np.minimum(high_a, high_b) - np.maximum(low_a, low_b)).min())


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
    lines, points = features_on_planes(a, b, lines, points, tolerances)
    along = line_patches(lines, faces, gap, negligible, breadth)
    return [*faces, *along, *point_patches(points, [*faces, *along], gap, breadth)]
