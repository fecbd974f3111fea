"""Contact detection: from bodies to interfaces, within a gap and an angle."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from holdfast.base.archive import archived
from holdfast.base.values import Value
from holdfast.contacts.clipping import clip_faces
from holdfast.contacts.facing import facing_polygons
from holdfast.contacts.features import touching_features
from holdfast.contacts.flags import flags_of
from holdfast.contacts.interface import Interface, Patch
from holdfast.contacts.occlusion import by_body, visible
from holdfast.contacts.patches import face_patches, line_patches, point_patches
from holdfast.contacts.skin import Skin, near_faces
from holdfast.scene.body import Body
from holdfast.scene.scene import Scene

RELATIVE_GAP = 1e-3  # default gap over the usual size of the movable bodies
USUAL_OVER_SMALLEST = 5  # the usual size is the median, but not more than this times the smallest
DEFAULT_ANGLE = 1.0  # [deg]
SIGMAS = 4  # standard deviations of a pose that the tolerances allow for
THINNEST = 0.5  # of the thinner body's thickness: the largest gap that uncertain poses give, and the deepest contact
STEEPEST = 45.0  # [deg] the largest angle that uncertain poses give
NEGLIGIBLE_WIDTH = 1e-6  # patches narrower than this, relative to the smaller body, are rounding
NOMINAL_BREADTH = 1e-3  # of the smaller body: the width that a line or a point is given in weights


@archived
@dataclass(frozen=True, eq=False, repr=False)
class Tolerances(Value):
    """How far apart, or into each other, two surfaces may be and still touch: ``gap`` [m] and ``angle`` [deg].

    Round shapes lie inside their true surface by their sagitta: between two bodies it is added to the gap. ``tilt``
    [deg] is the standard deviation of the poses' rotation: it adds to the gap what it moves at the end of a body, and
    to the angle. With ``capped`` no pair's gap exceeds half the thickness of the thinner body; ``depth`` [m], how far
    into each other, never does either: the far side of a plate is not its near side.
    """

    gap: float
    angle: float
    tilt: float = 0.0
    capped: bool = False
    depth: float = np.inf

    def between(self, a: Body, b: Body) -> Tolerances:
        """The tolerances of one pair of bodies: its gap, angle and depth, with nothing left to add."""
        lever = max((body.size / 2 for body in (a, b) if not body.fixed), default=0.0)
        gap, angle = self.gap + self._swing(lever), self.angle + SIGMAS * self.tilt
        gap += a.shape.surface.sagitta + b.shape.surface.sagitta
        thin = THINNEST * min(a.shape.surface.thickness, b.shape.surface.thickness)
        if self.capped:
            gap = min(gap, thin)
        return Tolerances(gap, min(angle, STEEPEST) if self.tilt else angle, depth=min(gap, thin))

    def _swing(self, lever: float) -> float:
        """How far the rotation moves the end of a lever [m]."""
        return SIGMAS * float(np.radians(self.tilt)) * lever

    def widest(self, scene: Scene) -> float:
        """An upper bound on the gap of every pair of bodies [m]."""
        lever = max((body.size / 2 for body in scene.movable), default=0.0)
        return self.gap + self._swing(lever) + 2 * max(body.shape.surface.sagitta for body in scene.bodies)


def default_gap(scene: Scene) -> float:
    """A thousandth of the usual bounding-box diagonal of the movable bodies [m]; a huge one does not raise it."""
    sizes = [body.size for body in scene.movable or scene.bodies]
    return RELATIVE_GAP * min(float(np.median(sizes)), USUAL_OVER_SMALLEST * min(sizes))


def box_distance(a: Body, b: Body) -> float:
    """Distance of the world bounding boxes [m]: never more than that of the bodies."""
    (low_a, high_a), (low_b, high_b) = a.box, b.box
    return float(np.linalg.norm(np.maximum(np.maximum(low_a - high_b, low_b - high_a), 0)))


@archived
@dataclass(frozen=True, eq=False, repr=False)
class Contacts(Value):
    """The interfaces of a scene, and the pairs that would touch if no third body lay between them."""

    interfaces: tuple[Interface, ...]
    occluded: tuple[tuple[str, str], ...]


def find_contacts(scene: Scene, tolerances: Tolerances) -> Contacts:
    """All interfaces between bodies of which at least one can move, in the order of the bodies."""
    skins: dict[str, Skin] = {}
    found: dict[tuple[str, str], tuple[Patch, ...]] = {}
    for a, b in neighbours(scene, tolerances.widest(scene)):
        for body in (a, b):
            if body.name not in skins:
                skins[body.name] = Skin.of(body)
        patches = find_patches(a, b, skins[a.name], skins[b.name], tolerances.between(a, b))
        if patches:
            found[a.name, b.name] = patches
    interfaces, occluded = [], []
    of_body = by_body(found)
    for pair, patches in found.items():
        a, b = (scene.body(name) for name in pair)
        gap = tolerances.between(a, b).gap
        left = visible(pair, found, of_body, gap, NEGLIGIBLE_WIDTH * min(a.size, b.size))
        if left:
            flags = flags_of(a, b, left, gap, hidden=left != list(patches))
            interfaces.append(Interface(pair, patches=left, flags=flags))
        else:
            occluded.append(pair)
    return Contacts(tuple(interfaces), tuple(occluded))


def neighbours(scene: Scene, gap: float) -> Iterator[tuple[Body, Body]]:
    """Pairs of bodies, not both fixed, whose bounding boxes come within ``gap``."""
    bodies = scene.bodies
    low = np.array([body.box[0] for body in bodies]).reshape(-1, 3) - gap / 2
    high = np.array([body.box[1] for body in bodies]).reshape(-1, 3) + gap / 2
    fixed = np.array([body.fixed for body in bodies], dtype=bool)
    for i, body in enumerate(bodies):
        near = ((low[i] <= high[i + 1 :]) & (low[i + 1 :] <= high[i])).all(1) & ~(fixed[i + 1 :] & body.fixed)
        for j in np.flatnonzero(near):
            yield body, bodies[i + 1 + int(j)]


def find_patches(a: Body, b: Body, skin_a: Skin, skin_b: Skin, tolerances: Tolerances) -> tuple[Patch, ...]:
    """Patches where two bodies touch, normals into ``b``: faces, edges where no face touches, points where neither."""
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
    return (*faces, *along, *point_patches(points, [*faces, *along], gap, breadth))
