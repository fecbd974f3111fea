"""Contact detection: finds the interfaces between bodies, within a gap and an angle tolerance."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from holdfast.base.archive import archived
from holdfast.base.progress import reported
from holdfast.base.values import Value
from holdfast.contacts.clipping import clip_faces
from holdfast.contacts.facing import facing_polygons
from holdfast.contacts.features import touching_features
from holdfast.contacts.flags import flags_of, is_certain
from holdfast.contacts.flush import lie_flat
from holdfast.contacts.interface import Interface, Patch
from holdfast.contacts.materials import by_material
from holdfast.contacts.occlusion import by_body, visible
from holdfast.contacts.patches import face_patches, line_patches, point_patches
from holdfast.contacts.round import feet, not_at, reach_of
from holdfast.contacts.skin import Skin, near_faces
from holdfast.scene.body import Body
from holdfast.scene.scene import Scene

RELATIVE_GAP = 1e-3  # default gap over the usual size of the movable bodies
USUAL_OVER_SMALLEST = 5  # largest ratio of the usual size to the smallest size; up to it the usual size is the median
DEFAULT_ANGLE = 1.0  # [deg] default angle tolerance
SIGMAS = 4  # number of standard deviations of a pose that the tolerances allow for
THINNEST = 0.5  # limit of a capped gap and of the depth of contacts, relative to the thickness of the thinner body
STEEPEST = 45.0  # [deg] largest angle tolerance that follows from uncertain poses
NEGLIGIBLE_WIDTH = 1e-6  # width, relative to the size of the smaller body, below which a patch is a rounding error
NOMINAL_BREADTH = 1e-3  # width of a line or a point in the weights of nodes, relative to the size of the smaller body


@archived
@dataclass(frozen=True, eq=False, repr=False)
class Tolerances(Value):
    """The tolerances of contact detection: which surfaces count as touching.

    - ``gap`` [m]: how far apart two surfaces may be, or how much they may overlap. For each pair of bodies, the
      sagittas of their surfaces are added, because the mesh of a round shape lies inside its true surface by that much.
    - ``angle`` [deg]: how far two faces may be from parallel.
    - ``tilt`` [deg]: the standard deviation of the rotations of the poses. It increases the angle, and the gap by the
      distance that the rotation moves the end of a body.
    - ``capped``: if True, the gap of a pair is at most half the thickness of the thinner body.
    - ``depth`` [m]: how much two surfaces may overlap. For a pair it is never more than half the thickness of the
      thinner body, so that the far side of a plate is not taken for its near side.
    - ``usual`` [m]: the default gap of the scene. Surfaces further apart than this are not certain to touch.
    """

    gap: float
    angle: float
    tilt: float = 0.0
    capped: bool = False
    depth: float = np.inf
    usual: float = field(default=np.inf, compare=False)  # follows from the scene that was assembled first

    def between(self, a: Body, b: Body) -> Tolerances:
        """Return the final gap, angle and depth of one pair of bodies. Nothing has to be added to them."""
        lever = max((body.size / 2 for body in (a, b) if not body.fixed), default=0.0)
        gap, angle = self.gap + self._swing(lever), self.angle + SIGMAS * self.tilt
        gap += a.shape.surface.sagitta + b.shape.surface.sagitta
        thin = THINNEST * min(a.shape.surface.thickness, b.shape.surface.thickness)
        if self.capped:
            gap = min(gap, thin)
        return Tolerances(gap, min(angle, STEEPEST) if self.tilt else angle, depth=min(gap, thin))

    def _swing(self, lever: float) -> float:
        """Return how far SIGMAS times ``tilt`` moves the end of a lever of this length, both [m]."""
        return SIGMAS * float(np.radians(self.tilt)) * lever

    def widest(self, scene: Scene) -> float:
        """Return an upper bound of the gaps of all pairs of bodies [m]."""
        lever = max((body.size / 2 for body in scene.movable), default=0.0)
        return self.gap + self._swing(lever) + 2 * max(body.shape.surface.sagitta for body in scene.bodies)


def default_gap(scene: Scene) -> float:
    """Return a thousandth of the usual bounding-box diagonal of the movable bodies [m].

    The usual diagonal is the median, limited by USUAL_OVER_SMALLEST, so a huge body does not raise it.
    """
    sizes = [body.size for body in scene.movable or scene.bodies]
    return RELATIVE_GAP * min(float(np.median(sizes)), USUAL_OVER_SMALLEST * min(sizes))


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


def find_contacts(scene: Scene, tolerances: Tolerances) -> Contacts:
    """Find all interfaces between bodies of which at least one is movable, in the order of the bodies.

    Where poses are uncertain, no interface is certain.
    """
    skins: dict[str, Skin] = {}
    found: dict[tuple[str, str], tuple[Patch, ...]] = {}
    for a, b in reported("contacts", list(neighbours(scene, tolerances.widest(scene)))):
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
            sagitta = a.shape.surface.sagitta + b.shape.surface.sagitta
            certain = not tolerances.capped and is_certain(
                left, flags, gap=tolerances.gap, usual=tolerances.usual, sagitta=sagitta
            )
            for mu, share in _by_friction(scene, a, b, left, gap).items():
                interfaces.append(Interface(pair, patches=share, flags=flags, certain=certain, mu=mu))
        else:
            occluded.append(pair)
    return Contacts(tuple(interfaces), tuple(occluded))


def _by_friction(scene: Scene, a: Body, b: Body, patches: list[Patch], gap: float) -> dict[float | None, list[Patch]]:
    """Share patches out by friction coefficient: None where it is that of the two bodies, whatever their parts."""
    if all({*body.materials} == {body.material} for body in (a, b)):
        return {None: patches}
    found: dict[float | None, list[Patch]] = {}
    for (of_a, of_b), piece in by_material(a, b, patches, gap).items():
        mu = scene.friction.between(a.name, b.name, {a.name: of_a, b.name: of_b})
        found.setdefault(mu, []).extend(piece)
    return found


def neighbours(scene: Scene, gap: float) -> Iterator[tuple[Body, Body]]:
    """Yield the pairs of bodies, neither both fixed nor excluded, whose bounding boxes come within ``gap`` [m]."""
    bodies, excluded = scene.bodies, frozenset(scene.excluded)
    low = np.array([body.box[0] for body in bodies]).reshape(-1, 3) - gap / 2
    high = np.array([body.box[1] for body in bodies]).reshape(-1, 3) + gap / 2
    fixed = np.array([body.fixed for body in bodies], dtype=bool)
    for i, body in enumerate(bodies):
        near = ((low[i] <= high[i + 1 :]) & (low[i + 1 :] <= high[i])).all(1) & ~(fixed[i + 1 :] & body.fixed)
        for j in np.flatnonzero(near):
            other = bodies[i + 1 + int(j)]
            if (min(body.name, other.name), max(body.name, other.name)) not in excluded:
                yield body, other


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
    found = faces
    if not lie_flat(skin_a, skin_b, pairs, faces, gap=gap, size=size):
        lines, points = touching_features(
            skin_a, skin_b, pairs, gap=gap, depth=depth, sin_angle=sin_angle, size=size, strict=negligible
        )
        along = line_patches(lines, faces, gap, negligible, breadth)
        found = [*faces, *along, *point_patches(points, [*faces, *along], gap, breadth)]
    exact = feet(a, b, gap=gap, depth=depth)
    if not exact:
        return tuple(found)
    true_gap = gap - a.shape.surface.sagitta - b.shape.surface.sagitta
    touching = [foot.patch(breadth) for foot in exact if foot.heights.min() <= max(true_gap, 0.0)]
    return (*touching, *not_at(exact, found, reach_of(a, b, gap)))
