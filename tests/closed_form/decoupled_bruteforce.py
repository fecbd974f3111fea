"""Slow generic evaluator of the decoupled robustness, to check the hand-derived ``decoupled_truth``.

Written from Nadeau & Kelly (arXiv 2411.09810, eq. 8-27) alone: contact rectangles cut into equal cells, minimum-energy
forces, slip by the cheapest of all node subsets, topple by every feasible cut and every edge of the convex hull in
both senses. It knows no mechanism and no symmetry. SI units, world axes, z up; all interfaces are horizontal.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

Array = NDArray[np.float64]

FLOOR = "floor"
GRAVITY = 9.81  # [m/s2]
CELLS = 200  # cells along each side of a contact rectangle
PARALLEL = 1e-6  # |v.n| / |v| below which the motion at a point counts as sliding
NO_LEVER = 1e-12  # lever [m] below which a push has no moment about an axis


@dataclass(frozen=True)
class Box:
    """A box aligned with the world axes: ``centre`` and ``size`` [m], ``mass`` [kg]."""

    centre: tuple[float, float, float]
    size: tuple[float, float, float]
    mass: float


@dataclass(frozen=True)
class Scene:
    """Boxes by name, the (lower, upper) pairs that touch, and one coefficient of friction."""

    boxes: dict[str, Box]
    touching: tuple[tuple[str, str], ...]
    mu: float


@dataclass(frozen=True)
class Interface:
    """A horizontal contact rectangle: corners (4, 3), cell centres (k, 3) [m], forces on the upper body (k, 3) [N]."""

    lower: str
    upper: str
    corners: Array
    points: Array
    forces: Array


@dataclass(frozen=True)
class Axis:
    """One way to topple: bodies that move, a point o and direction a (3,) of the axis, the torque needed [N m]."""

    moving: frozenset[str]
    origin: Array
    direction: Array
    torque: float


_CUBE = (0.1, 0.1, 0.1)
_LEG = (0.05, 0.2, 0.2)
CUBE = Scene({"cube": Box((0, 0, 0.05), _CUBE, 1.0)}, ((FLOOR, "cube"),), 0.6)
STACK = Scene(
    {f"cube{i + 1}": Box((0, 0, 0.05 + 0.1 * i), _CUBE, 1.0) for i in range(3)},
    ((FLOOR, "cube1"), ("cube1", "cube2"), ("cube2", "cube3")),
    0.6,
)
TABLE = Scene(
    {
        "slab": Box((0, 0, 0.225), (0.5, 0.2, 0.05), 2.0),
        "leg_left": Box((-0.175, 0, 0.1), _LEG, 1.0),
        "leg_right": Box((0.175, 0, 0.1), _LEG, 1.0),
    },
    ((FLOOR, "leg_left"), (FLOOR, "leg_right"), ("leg_left", "slab"), ("leg_right", "slab")),
    0.5,
)


class BruteForce:
    """Decoupled robustness of one scene: every axis is listed once, then queries are looked up."""

    def __init__(self, scene: Scene, cells: int = CELLS) -> None:
        self.scene = scene
        self.interfaces = minimum_energy(scene, cells)
        self.axes = [axis for moving in self._cuts() for axis in self._axes(moving)]
        self._slip: dict[tuple[str, bytes], float] = {}

    def __call__(self, body: str, point: Array, direction: Array) -> float:
        """R [N] of a push at ``point`` (3,) on ``body`` along the unit vector ``direction`` (3,)."""
        key = (body, direction.tobytes())
        if key not in self._slip:
            self._slip[key] = self.slip(body, direction)
        return min(self._slip[key], self.topple(body, point, direction))

    def slip(self, body: str, direction: Array) -> float:
        """Cheapest set of bodies around ``body``: the minimum cut of directed arcs, by trying all subsets (eq. 22)."""
        capacity = {}
        for face in self.interfaces:
            for source, sink, normal, force in (
                (face.upper, face.lower, -1.0, -face.forces),
                (face.lower, face.upper, 1.0, face.forces),
            ):
                inward = np.array([0.0, 0.0, normal])
                capacity[source, sink] = float(slip_at_points(force, direction, inward, self.scene.mu).sum())
        others = [name for name in self.scene.boxes if name != body]
        subsets = ({body, *extra} for k in range(len(others) + 1) for extra in combinations(others, k))
        return min(sum(c for (a, b), c in capacity.items() if a in s and b not in s) for s in subsets)

    def topple(self, body: str, point: Array, direction: Array) -> float:
        """Smallest torque / lever over all axes of all cuts whose moving side holds ``body`` (eq. 27)."""
        best = np.inf
        for axis in self.axes:
            lever = float(np.cross(point - axis.origin, direction) @ axis.direction)
            if body in axis.moving and lever > NO_LEVER:
                best = min(best, axis.torque / lever)
        return best

    def _cuts(self) -> Iterator[frozenset[str]]:
        names = list(self.scene.boxes)
        for k in range(1, len(names) + 1):
            for chosen in combinations(names, k):
                rest = {*names, FLOOR} - set(chosen)
                if self._connected(set(chosen)) and self._connected(rest):
                    yield frozenset(chosen)

    def _connected(self, names: set[str]) -> bool:
        reached, grown = set[str](), {min(names)}
        while grown != reached:
            reached = set(grown)
            for a, b in self.scene.touching:
                if {a, b} <= names and {a, b} & reached:
                    grown |= {a, b}
        return reached == names

    def _axes(self, moving: frozenset[str]) -> Iterator[Axis]:
        cut = [face for face in self.interfaces if (face.upper in moving) != (face.lower in moving)]
        points = np.vstack([face.points for face in cut])
        # +1 where the moving side is the upper one: f becomes moving-on-stationary, n inward to the stationary side.
        above = np.concatenate([np.full(len(face.points), 1.0 if face.upper in moving else -1.0) for face in cut])
        forces = -above[:, None] * np.vstack([face.forces for face in cut])
        normals = above[:, None] * np.array([0.0, 0.0, -1.0])
        pressure = np.einsum("ij,ij->i", forces, normals)
        centre = pressure @ points / pressure.sum()
        edges = hull_edges(np.vstack([face.corners for face in cut]))
        for origin, line in [*edges, (centre, np.array([0.0, 0.0, 1.0]))]:
            for direction in (line, -line):
                v = np.cross(points - origin, direction)
                torque = float(torque_at_points(v, forces, normals, self.scene.mu).sum())
                if np.isfinite(torque):
                    yield Axis(moving, origin, direction, max(torque, 0.0))


def slip_at_points(f: Array, e: Array, normals: Array, mu: float) -> Array:
    """First s >= 0 at which f + s e leaves the friction cone (eq. 14-20), inf if never; (k,) for f (k, 3).

    ``f`` acts on the receiving body, ``normals`` point into it; ``e`` (3,) or (k, 3) is a unit vector.
    """
    e, normals = np.broadcast_to(e, f.shape), np.broadcast_to(normals, f.shape)
    f_n, e_n = np.einsum("ij,ij->i", f, normals), np.einsum("ij,ij->i", e, normals)
    f_t, e_t = f - f_n[:, None] * normals, e - e_n[:, None] * normals
    c = np.maximum(mu**2 * f_n**2 - np.einsum("ij,ij->i", f_t, f_t), 0.0)
    b = mu**2 * f_n * e_n - np.einsum("ij,ij->i", f_t, e_t)
    d = mu**2 * e_n**2 - np.einsum("ij,ij->i", e_t, e_t)
    root = np.sqrt(np.maximum(b**2 - d * c, 0.0))
    with np.errstate(divide="ignore", invalid="ignore"):
        near = c / (root - b)
        leaving = np.where(b > 0, (b + root) / -d, near)
        result: Array = np.where(d < 0, leaving, np.where(e_n < 0, near, np.inf))
    return result


def torque_at_points(v: Array, f: Array, normals: Array, mu: float) -> Array:
    """Torque (k,) each contact point opposes to the motion -v (k, 3) of the moving side (eq. 24, by virtual power)."""
    speed = np.linalg.norm(v, axis=1)
    along = np.einsum("ij,ij->i", v, normals)
    sliding = np.abs(along) <= PARALLEL * speed
    direction = -v / np.where(speed > 0, speed, 1.0)[:, None]
    resisted = np.where(speed > 0, slip_at_points(f, direction, normals, mu) * speed, 0.0)
    separating = np.where(along > 0, np.einsum("ij,ij->i", f, v), np.inf)
    result: Array = np.where(sliding, resisted, separating)
    return result


def minimum_energy(scene: Scene, cells: int = CELLS) -> list[Interface]:
    """Interfaces of a scene with the forces of least sum |f|^2 in equilibrium (eq. 8-9), equal cells.

    f = B^T (B B^T)^+ (-w) is the least-norm solution of the equilibrium equations; as it lies inside the friction
    cones (checked), it also solves the problem with eq. 10-11.
    """
    names = list(scene.boxes)
    rectangles = [_rectangle(scene, lower, upper) for lower, upper in scene.touching]
    grids = [_cell_centres(corners, cells) for corners in rectangles]
    blocks = []
    for (lower, upper), points in zip(scene.touching, grids, strict=True):
        block = np.zeros((6 * len(names), 3 * len(points)))
        for name, sense in ((lower, -1.0), (upper, 1.0)):
            if name != FLOOR:
                row = 6 * names.index(name)
                block[row : row + 6] = sense * _wrench_map(points - np.asarray(scene.boxes[name].centre))
        blocks.append(block)
    weight = np.zeros(6 * len(names))
    weight[2::6] = [-GRAVITY * scene.boxes[name].mass for name in names]
    gram = sum((block @ block.T for block in blocks), np.zeros((weight.size, weight.size)))
    multiplier = np.linalg.lstsq(gram, -weight, rcond=1e-12)[0]
    interfaces = []
    for (lower, upper), corners, points, block in zip(scene.touching, rectangles, grids, blocks, strict=True):
        forces = (block.T @ multiplier).reshape(-1, 3)
        if not np.all(np.hypot(forces[:, 0], forces[:, 1]) <= scene.mu * forces[:, 2]):
            raise ValueError(f"interface ({lower!r}, {upper!r}): least-norm forces leave the friction cone")
        interfaces.append(Interface(lower, upper, corners, points, forces))
    return interfaces


def hull_edges(points: Array) -> list[tuple[Array, Array]]:
    """Edges (point, unit direction) of the convex hull of ``points`` (k, 3), flat hulls included."""
    centred = points - points.mean(axis=0)
    _, extent, frame = np.linalg.svd(centred)
    if extent[2] < 1e-9 * extent[0]:
        flat = ConvexHull(centred @ frame[:2].T)
        pairs = {frozenset(map(int, edge)) for edge in flat.simplices}
    else:
        hull = ConvexHull(points)
        sides: dict[frozenset[int], list[Array]] = {}
        for triangle, equation in zip(hull.simplices, hull.equations, strict=True):
            for i, j in combinations(map(int, triangle), 2):
                sides.setdefault(frozenset((i, j)), []).append(equation[:3])
        pairs = {pair for pair, (m, n) in sides.items() if m @ n < 1 - 1e-9}  # else an inner line of one flat face
    ends = [(points[min(pair)], points[max(pair)]) for pair in sorted(pairs, key=sorted)]
    return [(a, (b - a) / np.linalg.norm(b - a)) for a, b in ends]


def random_pushes(
    scene: Scene, count: int, margin: float, rng: np.random.Generator
) -> tuple[Array, Array, Sequence[str]]:
    """Random points (n, 3) on the faces of random boxes, ``margin`` [m] off their edges, outward normals, names."""
    names = [str(name) for name in rng.choice(list(scene.boxes), size=count)]
    axis, sign = rng.integers(0, 3, size=count), rng.choice([-1.0, 1.0], size=count)
    normals = sign[:, None] * np.eye(3)[axis]
    half = np.array([scene.boxes[name].size for name in names]) / 2
    centre = np.array([scene.boxes[name].centre for name in names])
    inner = rng.uniform(-1.0, 1.0, size=(count, 3)) * (half - margin)
    return centre + np.where(normals != 0, normals * half, inner), normals, names


def _rectangle(scene: Scene, lower: str, upper: str) -> Array:
    """Corners (4, 3) of the overlap of the upper box's underside with what it stands on."""
    top = scene.boxes[upper]
    low, high = (np.asarray(top.centre) + k * np.asarray(top.size) / 2 for k in (-1.0, 1.0))
    height = low[2]
    if lower != FLOOR:
        base = scene.boxes[lower]
        low = np.maximum(low, np.asarray(base.centre) - np.asarray(base.size) / 2)
        high = np.minimum(high, np.asarray(base.centre) + np.asarray(base.size) / 2)
    return np.array([(x, y, height) for x in (low[0], high[0]) for y in (low[1], high[1])])


def _cell_centres(corners: Array, cells: int) -> Array:
    steps = (np.arange(cells) + 0.5) / cells
    u, v = (grid.ravel()[:, None] for grid in np.meshgrid(steps, steps))
    result: Array = corners[0] + u * (corners[2] - corners[0]) + v * (corners[1] - corners[0])
    return result


def _wrench_map(arm: Array) -> Array:
    """Map (6, 3k) from forces at ``arm`` (k, 3) to (force, torque)."""
    k = len(arm)
    x, y, z = arm.T
    result = np.zeros((6, k, 3))
    result[[0, 1, 2], :, [0, 1, 2]] = 1.0
    result[3, :, 1], result[3, :, 2] = -z, y
    result[4, :, 0], result[4, :, 2] = z, -x
    result[5, :, 0], result[5, :, 1] = -y, x
    return result.reshape(6, 3 * k)
