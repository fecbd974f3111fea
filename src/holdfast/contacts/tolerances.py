"""The tolerances of contact detection, which follow from the two bodies of each pair unless they are given."""

from __future__ import annotations

from dataclasses import dataclass, replace
from statistics import median
from typing import NamedTuple

import numpy as np

from holdfast.base.archive import archived
from holdfast.base.arrays import Bool, Float, checked_number
from holdfast.base.errors import HoldfastError, message
from holdfast.base.ranges import TOLERANCE
from holdfast.base.values import Value
from holdfast.scene.body import Body
from holdfast.scene.scene import Scene

RELATIVE_GAP = 1e-3  # plain gap over the usual size of the movable bodies
USUAL_OVER_SMALLEST = 5  # largest ratio of the usual size to the smallest size; up to it the usual size is the median
DEFAULT_ANGLE = 1.0  # [deg] plain angle tolerance
SIGMAS = 4  # number of standard deviations of a pose, or of rough surfaces, that the gap allows for
SLOPES = 2  # number of standard deviations of the facets of rough surfaces that the angle allows for
ROUGHEST_GAP = 0.01  # largest gap that follows from rough surfaces, relative to the size of the smaller body
ROUGHEST_ANGLE = 5.0  # [deg] largest angle that follows from rough surfaces
REACH, RELATIVE_REACH = 0.01, 0.1  # [m] and relative to the size of the smaller body: see ``reach``
THINNEST = 0.5  # limit of a capped gap and of the depth of contacts, relative to the thickness of the thinner body
STEEPEST = 45.0  # [deg] largest angle tolerance that follows from uncertain poses


class Angles(NamedTuple):
    """How far two faces may be from parallel [deg]: ``flat`` ones, and those of which one is ``curved``.

    A face is curved if it stands for a curved surface (``Surface.curved``).
    """

    flat: float
    curved: float

    def cosine(self, curved: Bool) -> Float:
        """Return the cosine that holds for each of some pairs of faces, where ``curved`` tells which kind they are."""
        flat, bent = np.cos(np.radians(self))
        return np.asarray(np.where(curved, bent, flat))


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
    - ``by_pair``: if True, no gap was given. The gap of a pair then follows from its two bodies alone (``plain_gap``,
      and the roughness of both), and ``gap`` is only the plain gap of a body of usual size. ``angle_by_pair`` says
      the same of the angle.
    - ``rough``: if False, the roughness of surfaces counts for nothing.
    - ``spread`` [m]: deviations of poses that are added to the gap, as independent of it.
    - ``curved`` [deg]: the angle of faces of which one stands for a curved surface, if it is not ``angle``. For a pair
      it leaves out ``tilt``: a curved surface that is turned touches elsewhere, but no wider.
    """

    gap: float
    angle: float
    tilt: float = 0.0
    capped: bool = False
    depth: float = np.inf
    by_pair: bool = False
    angle_by_pair: bool = False
    spread: float = 0.0
    rough: bool = True
    curved: float | None = None

    @classmethod
    def measured(cls, scene: Scene, angle: float | None = None) -> Tolerances:
        """Return tolerances by pair for a scene; an ``angle`` [deg] that is given holds for all pairs."""
        plain = DEFAULT_ANGLE if angle is None else angle
        return cls(default_gap(scene), plain, by_pair=True, angle_by_pair=angle is None)

    @property
    def text(self) -> str:
        """The gap in words, for headings."""
        return f"gap {'about ' if self.by_pair else ''}{self.gap * 1e3:.3g} mm{' by pair' if self.by_pair else ''}"

    def on(self, scene: Scene) -> Tolerances:
        """Return the same tolerances for another scene."""
        return replace(self, gap=default_gap(scene)) if self.by_pair else self

    @property
    def rule(self) -> Tolerances:
        """What the tolerances of every pair of bodies follow from: the same for all scenes where they go by pair."""
        return replace(self, gap=0.0) if self.by_pair else self

    def between(self, a: Body, b: Body) -> Tolerances:
        """Return the final gap, angle and depth of one pair of bodies. Nothing has to be added to them."""
        gap = self.base(a, b)
        plain = rough_angle(a, b) if self.angle_by_pair and self.rough else self.angle
        if self.tilt:
            gap += self._swing(max((body.size / 2 for body in (a, b) if not body.fixed), default=0.0))
        gap += a.shape.surface.sagitta + b.shape.surface.sagitta
        thin = _thin(a, b)
        if self.capped:
            gap = min(gap, thin)
        angle = min(plain + SIGMAS * self.tilt, STEEPEST) if self.tilt else plain
        return Tolerances(gap, angle, depth=min(gap, thin), curved=min(plain, angle))

    def base(self, a: Body, b: Body) -> float:
        """Return the gap of a pair [m] without what sagittas and rotations add to it."""
        gap = plain_gap(a, b) if self.by_pair else self.gap
        if self.by_pair and self.rough:
            gap = max(gap, rough_gap(a, b))
        return float(np.hypot(gap, self.spread)) if self.spread else gap

    @property
    def angles(self) -> Angles:
        """The angles of flat and of curved faces."""
        return Angles(self.angle, self.angle if self.curved is None else self.curved)

    def of(self, body: Body) -> float:
        """Return how far a point may be from the surface of a body and still count as on it [m], without sagitta."""
        surface = body.shape.surface
        return max(RELATIVE_GAP * surface.diagonal, SIGMAS * surface.roughness.height) if self.by_pair else self.gap

    def widened(self, metres: float, degrees: float) -> Tolerances:
        """Return tolerances that also allow for independent deviations between two bodies, of places and rotations."""
        tilt = float(np.hypot(self.tilt, degrees))
        return replace(self, spread=float(np.hypot(self.spread, SIGMAS * metres)), tilt=tilt, capped=True)

    def _swing(self, lever: float) -> float:
        """Return how far SIGMAS times ``tilt`` moves the end of a lever of this length, both [m]."""
        return SIGMAS * float(np.radians(self.tilt)) * lever

    def widest(self, scene: Scene) -> float:
        """Return an upper bound of the gaps of all pairs of bodies [m]."""
        surfaces = [body.shape.surface for body in scene.bodies]
        gap = self.gap
        if self.by_pair:
            size = max([body.shape.surface.diagonal for body in scene.movable], default=0.0)
            gap = max(RELATIVE_GAP * size, SIGMAS * 2 * max([surface.roughness.height for surface in surfaces]))
        swing = self._swing(max([body.size / 2 for body in scene.movable], default=0.0)) if self.tilt else 0.0
        return gap + self.spread + swing + 2 * max([surface.sagitta for surface in surfaces])


def default_gap(scene: Scene) -> float:
    """Return a thousandth of the usual bounding-box diagonal of the movable bodies [m].

    The usual diagonal is the median, limited by USUAL_OVER_SMALLEST, so a huge body does not raise it.
    """
    sizes = [body.shape.surface.diagonal for body in scene.movable or scene.bodies]
    return RELATIVE_GAP * min(median(sizes), USUAL_OVER_SMALLEST * min(sizes))


def plain_gap(a: Body, b: Body) -> float:
    """Return the gap of a pair of bodies with exact surfaces and poses [m], without sagittas.

    It is a thousandth of the mean bounding-box diagonal of those of the two that can move, limited by
    USUAL_OVER_SMALLEST times the smaller diagonal, and by half the thickness of the thinner body unless that has none.
    """
    both = [body.shape.surface.diagonal for body in (a, b)]
    sizes = [size for size, body in zip(both, (a, b), strict=True) if not body.fixed] or both
    size = min(sum(sizes) / len(sizes), USUAL_OVER_SMALLEST * min(both))
    return min(RELATIVE_GAP * size, _thin(a, b) or np.inf)


def rough_gap(a: Body, b: Body) -> float:
    """Return the distance that the scatter of two surfaces explains [m]: 0 for exact ones."""
    one, two = a.shape.surface.roughness, b.shape.surface.roughness
    if not one.height and not two.height:
        return 0.0
    most = ROUGHEST_GAP * min(a.shape.surface.diagonal, b.shape.surface.diagonal)
    return min(SIGMAS * float(np.hypot(one.height, two.height)), most, _thin(a, b) or np.inf)


def rough_angle(a: Body, b: Body) -> float:
    """Return the angle between facets that the scatter of two surfaces explains [deg]: the plain one for exact ones."""
    one, two = a.shape.surface.roughness, b.shape.surface.roughness
    if not one.slope and not two.slope:
        return DEFAULT_ANGLE
    angle = DEFAULT_ANGLE + SLOPES * float(np.degrees(np.hypot(one.slope, two.slope)))
    return min(angle, ROUGHEST_ANGLE)


def reach(a: Body, b: Body) -> float:
    """Return how far apart two bodies may be seen though they touch in truth [m]: 10 mm, or a tenth of the smaller one.

    Within it no fall is proved, because poses from cameras and simulations are off by millimetres. Nothing touches
    because of it.
    """
    return min(REACH, RELATIVE_REACH * min(a.shape.surface.diagonal, b.shape.surface.diagonal))


def _thin(a: Body, b: Body) -> float:
    return THINNEST * min(a.shape.surface.thickness, b.shape.surface.thickness)


def tolerances_of(
    scene: Scene, gap: float | None, angle: float | None, sigma: tuple[float, float] | None
) -> Tolerances:
    """Return the tolerances of a scene from what ``assemble`` was given, with what it was not given.

    ``sigma`` are the standard deviations of poses, [m] and [deg]. Raises HoldfastError if a number is out of range.
    """
    if angle is not None:
        angle = checked_number(angle, "assemble: angle_degrees", above=0)
        if angle >= 90:
            raise HoldfastError(message("assemble", f"angle_degrees = {angle:g}", "needs less than 90"))
    plain = DEFAULT_ANGLE if angle is None else angle
    if sigma is not None:
        metres, tilt = sigma
        return Tolerances(SIGMAS * metres, plain, tilt, capped=True)
    if gap is not None:
        return Tolerances(checked_number(gap, "assemble: gap", above=0, within=TOLERANCE), plain)
    return Tolerances.measured(scene, angle)
