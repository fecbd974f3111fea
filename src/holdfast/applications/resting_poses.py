"""All poses in which one body rests on a level plane."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from holdfast.base.archive import archived
from holdfast.base.arrays import Float, Int, checked_number, frozen, unit
from holdfast.base.errors import GeometryError, located, message
from holdfast.base.kinds import shaped
from holdfast.base.painters import paint
from holdfast.base.public import PublicValue, Summary, number
from holdfast.base.rigid import tangents
from holdfast.base.values import Value
from holdfast.geometry.hull import convex_hull
from holdfast.geometry.hull_graph import HullGraph
from holdfast.geometry.topology import SMOOTH
from holdfast.scene.body import Body
from holdfast.scene.compound import Shape
from holdfast.scene.halfspace import HalfSpace
from holdfast.scene.scene import Scene

if TYPE_CHECKING:
    import trimesh

COPLANAR = 1e-5  # [rad] neighbouring hull triangles whose normals differ by less are one facet
LEVEL = 0.02  # share of its height by which the centre of mass may rise between facets of one round side
STEADY, SELDOM = np.radians(1.0), 0.005  # [rad], share: a pose that a smaller tilt ends, and less probable, is none
ROLLED = np.radians(10.0)  # a family of facets that spans more is a round side
G = 9.81  # [m/s²]


@archived
@shaped(pose="4 4", support="k 3")
@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class RestingPose(Value):
    """One pose of rest, or one of a family: on a round side, where the body ``rolls``, others are as good.

    ``pose`` (4, 4) puts the body on the plane z = 0 with its centre of mass above the origin; about the vertical it may
    be turned as one likes. ``height`` [m] is that of the centre, and ``support`` (k, 3) [m] are the corners on which it
    stands, world frame, counter-clockwise. ``probability`` is the share of all directions from the centre of mass that
    lead here: from each, a body that is let go turns over its edges, slowly. A real drop has speed and bounces, so take
    it as an order of magnitude.

    ``least_push`` [N] is the least level force at the centre of mass that moves it: it slides, tips, or rocks on a face
    that is not quite flat. ``tipping_degrees`` is the tilt of the plane at which it leaves for another pose, in the
    worst direction, if it does not slide before, and ``energy`` [J] lifts it over the lowest way there; rocking between
    facets whose heights are alike does not count. On a round side the first two are 0. Gravity is 9.81 m/s².
    """

    pose: Float
    height: float
    support: Float
    probability: float
    tipping_degrees: float
    least_push: float
    energy: float
    rolls: bool


@archived
@dataclass(frozen=True, eq=False, repr=False)
class RestingPoses(PublicValue, Sequence[RestingPose]):
    """The poses in which ``body`` rests on a level plane with friction ``mu``, the most probable first: a sequence."""

    body: Body
    mu: float
    poses: tuple[RestingPose, ...]

    def __getitem__(self, k: int) -> RestingPose:  # type: ignore[override]
        return self.poses[k]

    def __len__(self) -> int:
        return len(self.poses)

    def __iter__(self) -> Iterator[RestingPose]:
        return iter(self.poses)

    def scene(self, row: int) -> Scene:
        """Return the scene with the body in one of the poses on the half space below z = 0, for further questions."""
        return Scene([Body("floor", HalfSpace(), fixed=True), self.body.moved(self.poses[row].pose)], self.mu)

    def save_png(self, path: str | os.PathLike[str]) -> None:
        """Draw all poses as one PNG; of many, the most probable ones."""
        paint(self, path, ".png")

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
    the height of the centre is a local minimum. Facets of a round side count as one pose. A pose that ends if the plane
    tilts by 1° is left out if its probability is below 0.5 %: it counts to the one where the body goes from it.

    Raises SceneError or GeometryError if the shape has no volume, its centre of mass is not inside its hull, or a value
    is malformed.
    """
    mu = checked_number(mu, "resting_poses: mu", minimum=0)
    with located("resting_poses"):
        body = Body("body", shape, mass=mass, com=com)
    graph = _hull_graph(body)
    # a round surface has no edges between its triangles: the body turns while the plane tilts, half of it before
    smooth = body.shape.surface.sagitta > 0
    tilts = graph.tilts - (graph.turns / 2 * (graph.turns < SMOOTH) if smooth else 0.0)
    rolling = graph.families(LEVEL)
    family = graph.steady(rolling, tilts, STEADY, 1.0 if smooth else SELDOM)
    found = [_pose(body, mu, graph, tilts, family, rolling, k) for k in np.unique(family).tolist()]
    return RestingPoses(body, mu, tuple(sorted(found, key=lambda pose: -pose.probability)))


def _hull_graph(body: Body) -> HullGraph:
    """Return that of a body; raise GeometryError if its hull has no volume, or its centre of mass is not inside."""
    from scipy.spatial import QhullError  # not for those who ask for no hull (geometry/spatial.py)

    where = "resting_poses: shape"
    try:
        graph = HullGraph.of(body.shape.surface.vertices, body.com_body, COPLANAR)
    except QhullError:
        raise GeometryError(message(where, "is flat: its hull has no volume", "give a body with a thickness")) from None
    if graph.heights.min() <= 0:
        problem = f"its centre of mass {body.com_body.tolist()} is not inside its convex hull"
        raise GeometryError(message(where, problem, "give com= in the frame of the shape, in metres"))
    return graph


def _pose(body: Body, mu: float, graph: HullGraph, tilts: Float, family: Int, rolling: Int, number: int) -> RestingPose:
    assert body.mass is not None
    lowest = graph.lowest(family, number)
    normal, alike = graph.normals[lowest], graph.members(rolling, rolling[lowest])
    rolls = bool((graph.normals[alike] @ normal).min() < np.cos(ROLLED))
    if not rolls and body.shape.surface.sagitta:
        normal = unit(graph.normals[alike].mean(0))  # among the triangles of a round end
    height = float(((graph.corners[lowest] - body.com_body) @ normal).max())
    rise, _ = graph.way_out(family, lowest, graph.passes)
    tilt = 0.0 if rolls else max(graph.way_out(family, lowest, tilts)[0], 0.0)
    firm = 0.0 if rolls else max(float(tilts[graph.ridges[:, 0] == lowest].min()), 0.0)
    x, y = tangents(-normal)
    turn = np.array([x, y, -normal])
    pose = np.eye(4)
    pose[:3, :3] = turn
    pose[:3, 3] = np.array([0, 0, height]) - turn @ body.com_body
    corners = graph.corners[lowest] @ turn.T + pose[:3, 3]
    ring = convex_hull(corners[:, :2], 1e-9 * body.size)
    weight = body.mass * G
    return RestingPose(
        pose=frozen(pose),
        height=height,
        support=frozen(np.column_stack([ring, np.zeros(len(ring))])),
        probability=float(graph.solid[family == number].sum()),
        tipping_degrees=float(np.degrees(tilt)),
        least_push=weight * min(mu, float(np.tan(min(tilt, firm)))),
        energy=weight * (rise - height),
        rolls=rolls,
    )
