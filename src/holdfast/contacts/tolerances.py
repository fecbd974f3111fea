"""The tolerances of contact detection, which follow from the two bodies of each pair unless they are given."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from statistics import median
from typing import NamedTuple

import numpy as np

from holdfast.base.arrays import Bool, Float, checked_number
from holdfast.base.errors import HoldfastError, message
from holdfast.base.public import Record
from holdfast.base.ranges import TOLERANCE
from holdfast.scene.body import Body
from holdfast.scene.scene import Scene

RELATIVE_GAP = 1e-3  # plain gap, relative to the usual size of the movable bodies
USUAL_OVER_SMALLEST = 5  # the usual size is the median size, but at most this many times the smallest size
DEFAULT_ANGLE = 1.0  # [deg] plain angle tolerance
SIGMAS = 4  # number of standard deviations of a pose, or of rough surfaces, that the gap allows for
SLOPES = 2  # number of standard deviations of the facets of rough surfaces that the angle allows for
ROUGHEST_GAP = 0.01  # largest gap that follows from rough surfaces, relative to the size of the smaller body
ROUGHEST_ANGLE = 5.0  # [deg] largest angle that follows from rough surfaces
DOUBTFUL_GAP, RELATIVE_DOUBTFUL_GAP = 0.01, 0.1  # [m], and relative to the size of the smaller body
THINNEST = 0.5  # limit of a capped gap and of the depth of contacts, relative to the thickness of the thinner body
STEEPEST = 45.0  # [deg] largest angle tolerance that follows from uncertain poses


class Angles(NamedTuple):
    """The angle tolerance [deg] of two ``flat`` faces, and of two faces of which one is ``curved``.

    A face is curved if it represents a curved surface (``Surface.curved``).
    """

    flat: float
    curved: float

    def cosine(self, curved: Bool) -> Float:
        """Return the cosine of the angle tolerance for each pair of faces, of which ``curved`` tells the kind."""
        flat, bent = np.cos(np.radians(self))
        return np.asarray(np.where(curved, bent, flat))


class Tolerances(Record):
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
    - ``rough``: if False, the roughness of surfaces is ignored.
    - ``spread`` [m]: deviations of poses, which are added to the gap as independent deviations (root of squares).
    - ``curved`` [deg]: the angle for pairs of faces of which one represents a curved surface, if it is not ``angle``.
      For a pair of bodies it does not include ``tilt``, because a curved surface that is turned touches elsewhere, but
      on no larger area.
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
        about = "about " if self.by_pair else ""
        return f"gaps up to {about}{self.gap * 1e3:.3g} mm count as contact"

    def on(self, scene: Scene) -> Tolerances:
        """Return the same tolerances for another scene."""
        return replace(self, gap=default_gap(scene)) if self.by_pair else self

    @property
    def rule(self) -> Tolerances:
        """The values that determine the tolerances of every pair; by pair, they do not depend on the scene."""
        return replace(self, gap=0.0) if self.by_pair else self

    def between(self, a: Body, b: Body) -> Tolerances:
        """Return the final gap, angle and depth of one pair of bodies, with all additions included."""
        return self._between(a, b, self.base(a, b))

    def of_pairs(self, pairs: Iterable[tuple[Body, Body]]) -> list[OfPair]:
        """Return the tolerances of many pairs of bodies; those of bodies alike are found once."""
        known: dict[tuple[float, ...], OfPair] = {}
        limits = []
        for a, b in pairs:
            one, two = a.shape.surface, b.shape.surface
            sizes = (a.size, b.size) if self.tilt else ()
            key = (id(one), a.fixed, id(two), b.fixed, *sizes)
            limit = known.get(key)
            if limit is None:
                base = self.base(a, b)
                sagitta = one.sagitta + two.sagitta
                limit = known[key] = OfPair(self._between(a, b, base), base, plain_gap(a, b), sagitta)
            limits.append(limit)
        return limits

    def _between(self, a: Body, b: Body, gap: float) -> Tolerances:
        """Return what ``between`` does, from the ``gap`` [m] of the pair without additions (``base``)."""
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
        """Return the gap of a pair [m] without the additions for sagittas and rotations."""
        gap = plain_gap(a, b) if self.by_pair else self.gap
        if self.by_pair and self.rough:
            gap = max(gap, rough_gap(a, b))
        return float(np.hypot(gap, self.spread)) if self.spread else gap

    @property
    def angles(self) -> Angles:
        """The angles of flat and of curved faces."""
        return Angles(self.angle, self.angle if self.curved is None else self.curved)

    def of(self, body: Body) -> float:
        """Return the largest distance [m] at which a point counts as on the surface of a body, without its sagitta."""
        surface = body.shape.surface
        return max(RELATIVE_GAP * surface.diagonal, SIGMAS * surface.roughness.height) if self.by_pair else self.gap

    def widened(self, metres: float, degrees: float) -> Tolerances:
        """Return tolerances that also allow for independent deviations of positions [m] and rotations [deg].

        The deviations are given as standard deviations between two bodies.
        """
        tilt = float(np.hypot(self.tilt, degrees))
        return replace(self, spread=float(np.hypot(self.spread, SIGMAS * metres)), tilt=tilt, capped=True)

    def _swing(self, lever: float) -> float:
        """Return how far [m] a rotation by SIGMAS times ``tilt`` moves the end of a lever of this length [m]."""
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


class OfPair(NamedTuple):
    """The tolerances of one pair of bodies.

    ``own`` are the final ones, ``base`` [m] is the gap without additions for sagittas and rotations, ``usual`` [m] the
    plain gap, and ``sagitta`` [m] the sum of both.
    """

    own: Tolerances
    base: float
    usual: float
    sagitta: float


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


def doubtful_gap(a: Body, b: Body) -> float:
    """Return the distance [m] up to which two bodies may really touch: 10 mm, or a tenth of the smaller one's size.

    Poses from cameras and simulations are wrong by millimetres. So a body is not proved to fall if a contact within
    this distance could hold it. It does not make any bodies touch.
    """
    return min(DOUBTFUL_GAP, RELATIVE_DOUBTFUL_GAP * min(a.shape.surface.diagonal, b.shape.surface.diagonal))


def _thin(a: Body, b: Body) -> float:
    return THINNEST * min(a.shape.surface.thickness, b.shape.surface.thickness)


def tolerances_of(
    scene: Scene, gap: float | None, angle: float | None, sigma: tuple[float, float] | None
) -> Tolerances:
    """Return the tolerances of a scene from the arguments of ``assemble``, with defaults for those that are None.

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
