"""Contact detection: finds the interfaces between bodies, within a gap and an angle tolerance."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from holdfast.base.archive import archived
from holdfast.base.progress import reported
from holdfast.base.values import Value
from holdfast.contacts.clipping import clip_faces
from holdfast.contacts.facing import facing_polygons
from holdfast.contacts.features import touching_features
from holdfast.contacts.flags import flags_of, is_certain
from holdfast.contacts.interface import Interface, Patch
from holdfast.contacts.materials import by_material
from holdfast.contacts.merging import merged
from holdfast.contacts.occlusion import by_body, visible
from holdfast.contacts.patches import face_patches, line_patches, point_patches
from holdfast.contacts.round import feet, not_at
from holdfast.contacts.skin import Skin, near_faces
from holdfast.contacts.tolerances import Tolerances, plain_gap
from holdfast.scene.body import Body
from holdfast.scene.scene import Scene

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


def find_contacts(scene: Scene, tolerances: Tolerances, *, merge: bool = True) -> Contacts:
    """Find all interfaces between bodies of which at least one is movable, in the order of the bodies.

    Where poses are uncertain, no interface is certain. Many patches between two bodies are merged into few, unless
    ``merge`` is False.
    """
    skins: dict[int, Skin] = {}
    touching: dict[tuple[str, str], list[tuple[Body, Body, tuple[Patch, ...]]]] = {}
    for a, b in reported("contacts", list(neighbours(scene, tolerances.widest(scene)))):
        for body in (a, b):
            if id(body) not in skins:
                skins[id(body)] = Skin.of(body)
        between = tolerances.between(scene.body(a.name), scene.body(b.name))
        patches = find_patches(a, b, skins[id(a)], skins[id(b)], between)
        if patches:
            touching.setdefault((a.name, b.name), []).append((a, b, patches))
    found = {pair: [patch for *_, patches in each for patch in patches] for pair, each in touching.items()}
    interfaces, occluded = [], []
    of_body = by_body(found)
    for pair, each in touching.items():
        a, b = (scene.body(name) for name in pair)
        own, width = tolerances.between(a, b), NEGLIGIBLE_WIDTH * min(a.size, b.size)
        gap = own.gap
        seen = [(one, two, visible(patches, pair, found, of_body, gap, width)) for one, two, patches in each]
        left = [patch for *_, patches in seen for patch in patches]
        if not left:
            occluded.append(pair)
            continue
        flags = flags_of(a, b, left, gap, hidden=left != found[pair])
        sagitta = a.shape.surface.sagitta + b.shape.surface.sagitta
        certain = not tolerances.capped and is_certain(
            left, flags, gap=tolerances.base(a, b), usual=plain_gap(a, b), sagitta=sagitta
        )
        shares: dict[float | None, list[Patch]] = {}
        for one, two, rest in seen:
            for mu, piece in by_friction(scene, one, two, rest, gap).items():
                shares.setdefault(mu, []).extend(piece)
        for mu, share in shares.items():
            few = merged(share, gap, own.angle) if merge else tuple(share)
            said = (*flags, "merged") if any(patch.spots is not None for patch in few) else flags
            interfaces.append(Interface(pair, patches=few, flags=said, certain=certain, mu=mu))
    return Contacts(tuple(interfaces), tuple(occluded))


def by_friction(
    scene: Scene, a: Body, b: Body, patches: Sequence[Patch], gap: float
) -> dict[float | None, list[Patch]]:
    """Share patches out by friction coefficient: None where it is that of the two bodies, whatever their parts."""
    if not patches or all({*body.materials} == {body.material} for body in (a, b)):
        return {None: list(patches)} if patches else {}
    found: dict[float | None, list[Patch]] = {}
    for (of_a, of_b), piece in by_material(a, b, patches, gap).items():
        mu = scene.friction.between(a.name, b.name, {a.name: of_a, b.name: of_b})
        found.setdefault(mu, []).extend(piece)
    return found


def neighbours(scene: Scene, gap: float) -> Iterator[tuple[Body, Body]]:
    """Yield the pairs of bodies, neither both fixed nor excluded, whose bounding boxes come within ``gap`` [m].

    Of two bodies of which some parts alone may touch, only these are yielded, as bodies with fewer parts; where several
    sets of parts may touch each other, a pair for each (``Scene.touching``).
    """
    bodies = scene.bodies
    low = np.array([body.box[0] for body in bodies]).reshape(-1, 3) - gap / 2
    high = np.array([body.box[1] for body in bodies]).reshape(-1, 3) + gap / 2
    fixed = np.array([body.fixed for body in bodies], dtype=bool)
    for i, body in enumerate(bodies):
        near = ((low[i] <= high[i + 1 :]) & (low[i + 1 :] <= high[i])).all(1) & ~(fixed[i + 1 :] & body.fixed)
        for j in np.flatnonzero(near):
            yield from scene.touching(body, bodies[i + 1 + int(j)])


def find_patches(a: Body, b: Body, skin_a: Skin, skin_b: Skin, tolerances: Tolerances) -> tuple[Patch, ...]:
    """Find the patches where two bodies touch, with normals that point into ``b``.

    Faces come first, then lines where no face touches, then points where neither touches.
    """
    gap, depth, size = tolerances.gap, tolerances.depth, min(a.size, b.size)
    negligible, breadth = NEGLIGIBLE_WIDTH * size, NOMINAL_BREADTH * size
    pairs = near_faces(skin_a, skin_b, gap)
    if not len(pairs):
        return ()
    cos_angle, sin_angle = (float(f(np.radians(tolerances.angle))) for f in (np.cos, np.sin))
    locals_ = a.shape.surface.reduced, b.shape.surface.reduced
    large, small = facing_polygons(skin_a, skin_b, *locals_, pairs, gap=gap, depth=depth, cos_angle=cos_angle)
    pieces = [*large, *clip_faces(skin_a, skin_b, small, gap=gap, depth=depth, cos_angle=cos_angle)]
    faces = face_patches(pieces, gap, cos_angle, negligible)
    lines, points = touching_features(
        skin_a, skin_b, pairs, gap=gap, depth=depth, sin_angle=sin_angle, size=size, strict=negligible
    )
    along = line_patches(lines, faces, gap, negligible, breadth)
    found = [*faces, *along, *point_patches(points, [*faces, *along], gap, breadth)]
    exact = feet(a, b, gap=gap, depth=depth, breadth=breadth)
    if not exact:
        return tuple(found)
    true_gap = gap - a.shape.surface.sagitta - b.shape.surface.sagitta
    touching = [foot.patch(breadth) for foot in exact if foot.heights.min() <= max(true_gap, 0.0)]
    return (*touching, *not_at(exact, found))
