"""All poses in which one body rests on a level plane."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from holdfast.applications.standing_faces import Standing
from holdfast.base.arrays import Float, checked_number, frozen
from holdfast.base.errors import GeometryError, located, message
from holdfast.base.public import Pictured, PublicValue, Record, Summary, column, number
from holdfast.base.rigid import tangents
from holdfast.scene.body import Body
from holdfast.scene.compound import Shape
from holdfast.scene.halfspace import HalfSpace
from holdfast.scene.scene import Scene

if TYPE_CHECKING:
    import trimesh

G = 9.81  # [m/s²]


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
    standing = _standing(body)
    found = [_pose(standing, mu, number) for number in standing.sides]
    return RestingPoses(body, mu, tuple(sorted(found, key=lambda pose: -pose.probability)))


def _standing(body: Body) -> Standing:
    """Return its faces; raise GeometryError if the hull of a body is flat, or its centre of mass is not inside."""
    from scipy.spatial import QhullError  # not for those who ask for no hull (geometry/spatial.py)

    where, standing = "resting_poses: shape", Standing(body)
    try:
        graph = standing.graph
    except QhullError:
        raise GeometryError(message(where, "is flat: its hull has no volume", "give a body with a thickness")) from None
    if graph.heights.min() <= 0:
        problem = f"its centre of mass {body.com_body.tolist()} is not inside its convex hull"
        raise GeometryError(message(where, problem, "give com= in the frame of the shape, in metres"))
    return standing


def _pose(standing: Standing, mu: float, number: int) -> RestingPose:
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
