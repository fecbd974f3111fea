"""The faces of a body, on which it stands or rolls, and all poses in which it rests on a level plane."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from holdfast.applications.hull_graph import HullGraph
from holdfast.base.arrays import Float, Int, checked_number, frozen, unit
from holdfast.base.errors import GeometryError, located, message
from holdfast.base.public import Pictured, PublicValue, Record, Summary, column, number
from holdfast.base.rigid import tangents
from holdfast.contacts.tolerances import DEFAULT_ANGLE, Tolerances
from holdfast.geometry.hull import convex_hull, smallest_rectangle
from holdfast.geometry.triangles import SMOOTH
from holdfast.scene.body import Body
from holdfast.scene.compound import Shape
from holdfast.scene.halfspace import HalfSpace
from holdfast.scene.round_shapes import Ellipsoid
from holdfast.scene.scene import Scene

if TYPE_CHECKING:
    import trimesh

COPLANAR = 1e-5  # [rad] neighbouring hull triangles whose normals differ by less are one facet
LEVEL = 0.02  # share of its height by which the centre of mass may rise between facets of one round side of a shape
STEADY = np.radians(1.0)  # [rad] a face that a smaller tilt ends is none: of 13,000 drops of scans, 11 ended on one
ROLLED = np.radians(10.0)  # a family of facets that spans more is a round side
ONE_FACE = np.radians(1.0)  # [rad] contact normals that differ by less belong to one face
UPRIGHT = np.cos(np.radians(15.0))  # of the largest angle between the object's third axis and up if it is upright
FLOOR = Body("floor", HalfSpace(), fixed=True)  # the contacts with which tell what is round
G = 9.81  # [m/s²]


@dataclass(frozen=True, eq=False)
class Face:
    """A face of the object's convex hull, in the body frame.

    ``normal`` (3,) points outwards. ``foot`` (3,) [m] is the centre of mass projected into the plane of the face, and
    ``corners`` (k, 3) [m] are the corners of the face. ``along`` (3,) is the direction of its longer side. ``tilt``
    [rad] is how far a plane can be tilted, in the worst direction, before the object leaves this face for another one;
    it is 0 if the object does not stand on it even on a horizontal plane. ``rolls`` is True for a facet of a round
    side, on which the real object would roll, because the height of its centre of mass stays the same.
    """

    normal: Float
    foot: Float
    corners: Float
    along: Float
    tilt: float
    rolls: bool

    @property
    def upright(self) -> bool:
        """Whether the object is upright on this face."""
        return bool(self.normal[2] <= -UPRIGHT)


@dataclass(frozen=True, eq=False)
class StandingFaces:
    """The facets of a body's convex hull in families: the body rests on one of each, and rolls on those that are round.

    A side of a mesh is round if no contact could tell its facets from a curve: if the centre of mass rises between them
    by no more than the gap up to which surfaces touch, over more than ROLLED. For a prism of n sides that is its
    sagitta, r (1 - cos π/n). Other facets are one face only if they are as nearly equally high and a tilt of STEADY
    leads from one to another. The facets of a shape that is known to be round belong together if the centre rises by no
    more than LEVEL. The body leaves a face where it goes to a facet of another one, even if it does not stop there.
    """

    body: Body

    @cached_property
    def graph(self) -> HullGraph:
        """The facets and ridges of the hull; raises scipy's QhullError if it has no volume."""
        return HullGraph.of(self.body.shape.surface.vertices, self.body.com_body, COPLANAR)

    @cached_property
    def smooth(self) -> bool:
        """Whether the surface is the tessellation of a shape that is round."""
        return self.body.shape.surface.sagitta > 0

    @cached_property
    def tilts(self) -> Float:
        """The tilt (R,) [rad] of the plane at which the body turns over each ridge; half of it before, if round."""
        turns = self.graph.turns
        return self.graph.tilts - (turns / 2 * (turns < SMOOTH) if self.smooth else 0.0)

    @cached_property
    def rolling(self) -> Int:
        """The family (F,) of each facet, of all on which the body rests."""
        if self.smooth:
            return self.graph.families(LEVEL, 0.0)
        gap = Tolerances(0.0, DEFAULT_ANGLE, by_pair=True, angle_by_pair=True).between(FLOOR, self.body).gap
        alike, apart = self.graph.families(0.0, gap), self.graph.steady(self.graph.rests, self.tilts, STEADY, gap)
        round_ = [number for number in np.unique(alike) if self._spans(self.graph.members(alike, number))]
        return np.where(np.isin(alike, round_), alike, apart)

    def _spans(self, facets: Int) -> bool:
        """Return whether facets, on which the centre of mass is about equally high, are those of a round side."""
        lowest = facets[np.argmin(self.graph.heights[facets])]
        return bool((self.graph.normals[facets] @ self.graph.normals[lowest]).min() < np.cos(ROLLED))

    @cached_property
    def family(self) -> Int:
        """The family (F,) of each facet, without those that a small tilt ends: they belong to where the body goes."""
        return self.graph.steady(self.rolling, self.tilts, STEADY)

    @cached_property
    def sides(self) -> dict[int, tuple[int, Int, bool]]:
        """By family: its lowest facet, all (n,) that are one side with that, and whether it is a round one."""
        lowest = [self.graph.lowest(self.family, number) for number in np.unique(self.family).tolist()]
        alike = [self.graph.members(self.rolling, self.rolling[k]) for k in lowest]
        every = zip(np.unique(self.family).tolist(), lowest, alike, strict=True)
        return {number: (k, facets, self._spans(facets)) for number, k, facets in every}

    def face(self, number: int) -> Face:
        """Return the face on which the body stands, or rolls, in a family: its lowest facet."""
        lowest, alike, rolls = self.sides[number]
        tilt = 0.0 if rolls else self.graph.way_out(self.rolling, lowest, self.tilts)[0]
        if rolls or not self.smooth:
            return self._facet(lowest, tilt, rolls=rolls)
        mean = unit(self.graph.normals[alike].mean(0))  # among the triangles of a round end
        return self._flat_end(mean) or self._facet(lowest, tilt, normal=mean)

    def faces(self) -> tuple[Face, ...]:
        """Return all faces of the hull, the steadiest first; facets of a round side are one each."""
        firm, others = np.arctan2(self.graph.margins, self.graph.heights), {*range(len(self.graph.heights))}
        found = []
        for family, (_, alike, rolls) in self.sides.items():
            facets = alike.tolist()
            found += [self._facet(k, firm[k], rolls=True) for k in facets] if rolls else [self.face(family)]
            others -= {*facets}
        found += [self._facet(k, 0.0) for k in sorted(others)]
        order = np.lexsort(np.array([face.normal for face in found]).T)
        return tuple(sorted([found[k] for k in order], key=lambda face: -round(face.tilt, 9)))

    def _facet(self, k: int, tilt: float, *, rolls: bool = False, normal: Float | None = None) -> Face:
        """Describe one facet, with its own normal unless another one is given."""
        points, com = self.graph.corners[k], self.body.com_body
        normal = self.graph.normals[k] if normal is None else normal
        frame = np.array(tangents(normal))
        level = float((points @ normal).max())
        ring = convex_hull(points @ frame.T, 1e-9 * float(np.ptp(points, axis=0).max()))
        foot = (com @ frame.T) @ frame + level * normal
        along = smallest_rectangle(ring)[0][0] @ frame
        return Face(normal, foot, ring @ frame + level * normal, along, min(max(tilt, 0.0), np.pi / 2), rolls)

    def _flat_end(self, near: Float) -> Face | None:
        """Return the end of the shortest axis of an ellipsoid whose normal is ``near`` (3,), exactly; None for others.

        With radii c < b < a and its centre of mass in the middle, it stands on planes tilted by up to
        atan((b² - c²) / (2 b c)), the largest angle in the ellipse (b, c) between the normal and the line to the
        middle.
        """
        shape = self.body.shape
        if not isinstance(shape, Ellipsoid):
            return None
        radii = np.asarray(shape.radii, dtype=float)
        short, middle, long = np.argsort(radii, kind="stable").tolist()
        c, b = radii[short], radii[middle]
        if np.abs(self.body.com_body).max() > LEVEL * c:
            return None
        end = np.eye(3)[short] * np.sign(near[short])
        tilt = float(np.arctan((b**2 - c**2) / (2 * b * c)))
        return Face(end, c * end, c * end[None], np.eye(3)[long], tilt, rolls=False)


def rolls_on(faces: Sequence[Face], pose: Float, normals: Float) -> bool:
    """Return whether an object at ``pose`` (4, 4) has contacts on one facet of a round side only.

    ``normals`` (n, 3) are those of its contacts, which point into it, world frame.
    """
    if not len(normals):
        return False
    local = -normals @ pose[:3, :3]
    touching = faces[int(np.argmax([float(face.normal @ local[0]) for face in faces]))]
    return bool(touching.rolls) and bool((local @ local[0] > np.cos(ONE_FACE)).all())


class RestingPose(Record, kw_only=True):
    """One pose of rest, or one of a family: on a round side, where the body ``rolls``, others are as good.

    ``pose`` (4, 4) puts the body on the plane z = 0 with its centre of mass above the origin; about the vertical it may
    be turned as one likes. ``height`` [m] is that of the centre, and ``support`` (k, 3) [m] are the corners on which it
    stands, world frame, counter-clockwise. ``probability`` is the share of all directions from the centre of mass that
    lead here: from each, a body that is let go turns over its edges, slowly. A real drop has speed and bounces, so take
    it as an order of magnitude.

    ``least_push`` [N] is the least level force at the centre of mass that moves it: it slides, tips, or rocks on a face
    that is not quite flat. ``tipping_degrees`` is the tilt of the plane at which it leaves for another face, in the
    worst direction, if it does not slide before, and ``energy`` [J] lifts it over the lowest way there; rocking between
    facets whose heights are alike does not count. On a round side the first two are 0. Gravity is 9.81 m/s².
    """

    pose: Float = column("4 4")
    height: float
    support: Float = column("k 3")
    probability: float
    tipping_degrees: float
    least_push: float
    energy: float
    rolls: bool


class RestingPoses(Pictured, PublicValue, Sequence[RestingPose], kw_only=False):
    """The poses in which ``body`` rests on a level plane with friction ``mu``, the most probable first: a sequence.

    Its picture shows all poses; of many, the most probable ones.
    """

    body: Body
    mu: float
    poses: tuple[RestingPose, ...]

    def __getitem__(self, k: int) -> RestingPose:  # type: ignore[override]
        return self.poses[k]

    def __len__(self) -> int:
        return len(self.poses)

    def scene(self, row: int) -> Scene:
        """Return the scene with the body in one of the poses on the half space below z = 0, for further questions."""
        return Scene([Body("floor", HalfSpace(), fixed=True), self.body.moved(self.poses[row].pose)], self.mu)

    def summary(self) -> Summary:
        """Summarise the poses, one a row."""
        rows = []
        for k, one in enumerate(self.poses):
            figures = map(number, (one.tipping_degrees, one.least_push, one.energy))
            rows.append([str(k), f"{one.probability:.1%}", *figures, words(one)])
        heads = ("pose", "probability", "tips at [deg]", "least push [N]", "energy [J]", "")
        return Summary(f"rests in {len(self)} poses", (), heads, rows)


def words(pose: RestingPose) -> str:
    """Say on how many corners a body stands, or that it rolls."""
    return "rolls" if pose.rolls else f"on {len(pose.support)} corners"


def resting_poses(
    shape: Shape | trimesh.Trimesh, mass: float = 1.0, mu: float = 0.5, com: ArrayLike | None = None
) -> RestingPoses:
    """Return all poses in which one body rests on a level plane, the most probable first.

    ``shape`` has ``mass`` [kg], spread evenly or with its centre at ``com`` (3,) [m], and the coefficient of friction
    ``mu`` with the plane. The body rests on the facets of its convex hull over which its centre of mass lies: on each
    the height of the centre is a local minimum. The facets of a round side count as one pose, and those of a mesh do if
    the centre rises between them by no more than the gap up to which surfaces count as touching, a thousandth of the
    size of the body: a prism of 16 sides stands on each. A pose that ends if the plane tilts by 1° is left out, since
    what falls hardly ever stops there: its probability counts to the one where the body goes from it.

    Raises SceneError or GeometryError if the shape has no volume, its centre of mass is not inside its hull, or a value
    is malformed.
    """
    mu = checked_number(mu, "resting_poses: mu", minimum=0)
    with located("resting_poses"):
        body = Body("body", shape, mass=mass, com=com)
    from scipy.spatial import QhullError  # not for those who ask for no hull (geometry/hull.py)

    where, standing = "resting_poses: shape", StandingFaces(body)
    try:
        graph = standing.graph
    except QhullError:
        raise GeometryError(message(where, "is flat: its hull has no volume", "give a body with a thickness")) from None
    if graph.heights.min() <= 0:
        problem = f"its centre of mass {body.com_body.tolist()} is not inside its convex hull"
        raise GeometryError(message(where, problem, "give com= in the frame of the shape, in metres"))
    found = [_pose(standing, mu, number) for number in standing.sides]
    return RestingPoses(body, mu, tuple(sorted(found, key=lambda pose: -pose.probability)))


def _pose(standing: StandingFaces, mu: float, number: int) -> RestingPose:
    body, graph, face = standing.body, standing.graph, standing.face(number)
    assert body.mass is not None
    lowest, _, _ = standing.sides[number]
    height = float((face.foot - body.com_body) @ face.normal)
    rise, _ = graph.way_out(standing.rolling, lowest, graph.passes)
    firm = 0.0 if face.rolls else max(float(standing.tilts[graph.ridges[:, 0] == lowest].min()), 0.0)
    x, y = tangents(-face.normal)
    turn = np.array([x, y, -face.normal])
    pose = np.eye(4)
    pose[:3, :3] = turn
    pose[:3, 3] = np.array([0, 0, height]) - turn @ body.com_body
    weight = body.mass * G
    return RestingPose(
        pose=frozen(pose),
        height=height,
        support=frozen((face.corners @ turn.T + pose[:3, 3])[::-1] * [1, 1, 0]),
        probability=float(graph.solid[standing.family == number].sum()),
        tipping_degrees=float(np.degrees(face.tilt)),
        least_push=weight * min(mu, float(np.tan(min(face.tilt, firm)))),
        energy=weight * (rise - height),
        rolls=face.rolls,
    )
