"""Scenes whose contacts are known in closed form, and the yardstick that compares detected interfaces with them.

Nothing here knows how contacts are detected. Polygons come from intersecting bounding lines two by two and keeping the
points that satisfy every half-plane, rectangles from intervals of boxes along the axes, meshes from builders of their
own. A truth is one patch: corners of its convex hull, normal into the second body, area, holes. One corner is a point
contact, two are a line.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.optimize import linear_sum_assignment
from scipy.spatial.transform import Rotation

import holdfast as hf
from holdfast.base.arrays import Float, Int

Shape = hf.Box | hf.Cylinder | hf.Sphere | hf.Mesh
Pair = tuple[str, str]

UP = np.array([0.0, 0.0, 1.0])
STILL = np.zeros(3)


# --- truth ------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Truth:
    """One patch: hull corners (m, 3), unit normal (3,) into the second body, area [m²], rings of holes."""

    hull: Float
    normal: Float
    area: float
    holes: tuple[Float, ...] = ()

    @property
    def kind(self) -> str:
        return {1: "point", 2: "line"}.get(len(self.hull), "face")


@dataclass(frozen=True)
class Solid:
    """A body and ``step``: how it moves so that each of its contacts opens by one unit."""

    name: str
    shape: Shape
    pose: Float = field(default_factory=lambda: np.eye(4))
    fixed: bool = False
    step: Float = field(default_factory=lambda: STILL)

    @property
    def points(self) -> Float:
        """(V, 3) vertices in the world."""
        return np.asarray(self.shape.surface.vertices @ self.pose[:3, :3].T + self.pose[:3, 3])


@dataclass(frozen=True)
class Case:
    """Bodies and all patches between them, by pair; the normals point into the second body of the pair."""

    solids: tuple[Solid, ...]
    truth: Mapping[Pair, tuple[Truth, ...]]

    def scene(self, *, reverse: bool = False) -> hf.Scene:
        bodies = [
            hf.Body(s.name, s.shape, mass=None if s.fixed else 1.0, pose=s.pose, fixed=s.fixed) for s in self.solids
        ]
        return hf.Scene(bodies[::-1] if reverse else bodies, friction=0.5)

    def placed(self, pose: Float, scale: float = 1.0) -> Case:
        """Everything scaled about the origin, then moved; the motion's translation grows along."""
        shift = pose[:3, 3] * scale
        solids = []
        for solid in self.solids:
            there = pose @ solid.pose
            there[:3, 3] = pose[:3, :3] @ (solid.pose[:3, 3] * scale) + shift
            shape = scaled(solid.shape, scale)
            solids.append(replace(solid, shape=shape, pose=there, step=pose[:3, :3] @ solid.step))

        def carried(points: Float) -> Float:
            return np.asarray(points * scale @ pose[:3, :3].T + shift)

        truth = {
            pair: tuple(
                Truth(carried(t.hull), pose[:3, :3] @ t.normal, t.area * scale**2, tuple(carried(h) for h in t.holes))
                for t in patches
            )
            for pair, patches in self.truth.items()
        }
        return Case(tuple(solids), truth)

    def displaced(self, amount: float) -> Case:
        """Every contact opened by ``amount`` [m], or closed by it where negative; the truth stays that of before."""
        return self._with_poses(lambda s: _shifted(s.pose, amount * s.step))

    def tilted(self, degrees: float, seed: int) -> Case:
        """Every movable body turned about its middle, each about its own random axis."""
        rng = np.random.default_rng(seed)

        def turned(solid: Solid) -> Float:
            axis = rng.normal(size=3)
            turn = Rotation.from_rotvec(np.radians(degrees) * axis / np.linalg.norm(axis)).as_matrix()
            middle = (solid.points.min(0) + solid.points.max(0)) / 2
            pose = np.eye(4)
            pose[:3, :3] = turn @ solid.pose[:3, :3]
            pose[:3, 3] = middle + turn @ (solid.pose[:3, 3] - middle)
            return pose

        return self._with_poses(lambda s: s.pose if s.fixed else turned(s))

    def remeshed(self, how: Callable[[Float, Int], tuple[Float, Int]]) -> Case:
        """The same bodies with other triangles."""
        solids = []
        for solid in self.solids:
            surface = solid.shape.surface
            solids.append(replace(solid, shape=hf.Mesh(*how(surface.vertices, surface.faces))))
        return Case(tuple(solids), self.truth)

    def _with_poses(self, pose: Callable[[Solid], Float]) -> Case:
        return Case(tuple(replace(s, pose=pose(s)) for s in self.solids), self.truth)


def _shifted(pose: Float, by: Float) -> Float:
    moved = pose.copy()
    moved[:3, 3] += by
    return moved


def scaled(shape: Shape, scale: float) -> Shape:
    if scale == 1:
        return shape
    if isinstance(shape, hf.Box):
        return hf.Box(shape.size * scale)
    if isinstance(shape, hf.Cylinder):
        return hf.Cylinder(shape.radius * scale, shape.height * scale, shape.segments)
    if isinstance(shape, hf.Sphere):
        return hf.Sphere(shape.radius * scale, shape.subdivisions)
    return hf.Mesh(shape.vertices * scale, shape.faces)


def motion(seed: int) -> Float:
    """A random rotation, and a translation of about a metre."""
    rng = np.random.default_rng(seed)
    pose = np.eye(4)
    pose[:3, :3] = Rotation.from_quat(rng.normal(size=4)).as_matrix()
    pose[:3, 3] = rng.uniform(-1, 1, 3)
    return pose


def frame(x: float = 0, y: float = 0, z: float = 0, turn: Rotation | None = None) -> Float:
    pose = np.eye(4)
    if turn is not None:
        pose[:3, :3] = turn.as_matrix()
    pose[:3, 3] = x, y, z
    return pose


def frame_at(place: Float, turn: Rotation) -> Float:
    return _shifted(frame(turn=turn), place)


def spin(degrees: float, axis: str = "z") -> Rotation:
    return Rotation.from_euler(axis, degrees, degrees=True)


# --- plane geometry ---------------------------------------------------------------------------------------------------


def common(*polygons: Float) -> Float:
    """Corners (k, 2), counter-clockwise, of the intersection of convex counter-clockwise polygons; (0, 2) if empty.

    All pairs of bounding lines are intersected; the points within every half-plane are the corners.
    """
    ring = np.vstack(polygons)
    after = np.vstack([np.roll(p, -1, axis=0) for p in polygons])
    side = after - ring
    inward = np.column_stack([-side[:, 1], side[:, 0]]) / np.linalg.norm(side, axis=1, keepdims=True)
    offset = np.einsum("ij,ij->i", inward, ring)
    size = float(np.ptp(ring, axis=0).max())
    corners = []
    for i, j in itertools.combinations(range(len(ring)), 2):
        lines = inward[[i, j]]
        if abs(np.linalg.det(lines)) < 1e-9:
            continue
        point = np.linalg.solve(lines, offset[[i, j]])
        if (inward @ point - offset > -1e-12 * size).all():
            corners.append(point)
    return hull_of(np.array(corners)) if corners else np.zeros((0, 2))


def hull_of(points: Float) -> Float:
    """Convex hull (k, 2), counter-clockwise, without repeated or collinear points (Andrew's chains)."""
    size = float(np.ptp(points, axis=0).max()) or 1.0
    order = points[np.lexsort(points.T[::-1])]

    def chain(run: Iterable[Float]) -> list[Float]:
        kept: list[Float] = []
        for p in run:
            if kept and np.linalg.norm(p - kept[-1]) < 1e-11 * size:
                continue
            while len(kept) > 1 and _left(kept[-2], kept[-1], p) < 1e-11 * size**2:
                kept.pop()
            kept.append(p)
        return kept

    there, back = chain(order), chain(order[::-1])
    return np.array(there[:-1] + back[:-1]) if len(there) > 1 else np.array(there)


def _left(a: Float, b: Float, c: Float) -> float:
    return float((b - a)[0] * (c - a)[1] - (b - a)[1] * (c - a)[0])


def shoelace(ring: Float) -> float:
    x, y = ring.T
    return float(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1))) / 2


def rectangle(width: float, depth: float, x: float = 0, y: float = 0, degrees: float = 0) -> Float:
    """Counter-clockwise corners (4, 2) of a rectangle about (x, y)."""
    corners = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) * [width / 2, depth / 2]
    return np.asarray(corners @ spin(degrees).as_matrix()[:2, :2].T + [x, y])


def ngon(radius: float, sides: int, x: float = 0, y: float = 0) -> Float:
    angle = 2 * np.pi * np.arange(sides) / sides
    return np.column_stack([x + radius * np.cos(angle), y + radius * np.sin(angle)])


def level(ring: Float, z: float) -> Float:
    """A ring (k, 2) at the height ``z``."""
    return np.column_stack([ring, np.full(len(ring), z)])


def horizontal(ring: Float, z: float) -> Truth:
    """A convex patch at the height ``z``, the second body above it."""
    return Truth(level(hull_of(ring), z), UP, shoelace(ring))


def line(a: Iterable[float], b: Iterable[float], normal: Float = UP) -> Truth:
    return Truth(np.array([tuple(a), tuple(b)]), normal / np.linalg.norm(normal), 0.0)


def point(p: Iterable[float], normal: Float = UP) -> Truth:
    return Truth(np.array([tuple(p)]), normal / np.linalg.norm(normal), 0.0)


# --- meshes -----------------------------------------------------------------------------------------------------------


def outward(vertices: Float, faces: Int) -> hf.Mesh:
    """A closed, consistently wound mesh, turned so that its volume is positive."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    if np.einsum("ij,ij->", a, np.cross(b, c)) < 0:
        faces = faces[:, ::-1]
    return hf.Mesh(vertices, faces)


def cells(xs: Float, ys: Float, zs: Float, filled: Float) -> hf.Mesh:
    """The solid made of the filled cells (i, j, k) of a grid with these lines along the axes."""
    lines = [np.asarray(v, dtype=float) for v in (xs, ys, zs)]
    counts = tuple(len(v) for v in lines)
    full = np.pad(np.asarray(filled, dtype=bool), 1)
    faces = []
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        for cell in np.argwhere(full):
            for side in (0, 1):
                beside = cell.copy()
                beside[axis] += 2 * side - 1
                if full[tuple(beside)]:
                    continue
                ring = []
                for du, dv in ((0, 0), (1, 0), (1, 1), (0, 1)):
                    corner = cell - 1
                    corner[axis] += side
                    corner[u] += du
                    corner[v] += dv
                    ring.append(int(np.ravel_multi_index(tuple(corner), counts)))
                ring = ring if side else ring[::-1]
                faces += [(ring[0], ring[1], ring[2]), (ring[0], ring[2], ring[3])]
    grid = np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1).reshape(-1, 3)
    used, indices = np.unique(np.array(faces), return_inverse=True)
    return outward(grid[used], indices.reshape(-1, 3))


def revolved(profile: list[tuple[float, float]], sides: int, *, closed: bool = False) -> hf.Mesh:
    """The solid swept by a profile of (radius, height) about z: from axis to axis, or a closed loop away from it."""
    rings: list[Int] = []
    vertices: list[Float] = []
    for radius, z in profile:
        ring = ngon(radius, sides) if radius > 0 else np.zeros((1, 2))
        rings.append(len(vertices) + np.arange(len(ring)))
        vertices += list(level(ring, z))
    faces = []
    links = list(itertools.pairwise(rings)) + ([(rings[-1], rings[0])] if closed else [])
    for one, two in links:
        for k in range(sides):
            a, b = one[k % len(one)], one[(k + 1) % len(one)]
            c, d = two[(k + 1) % len(two)], two[k % len(two)]
            faces += [t for t in ((a, b, c), (a, c, d)) if len(set(t)) == 3]
    return outward(np.array(vertices), np.array(faces))


def extruded(outline: Float, low: float, high: float) -> hf.Mesh:
    """A convex outline (k, 2), counter-clockwise, in x and z, extruded along y."""
    k = len(outline)
    rings = [np.column_stack([outline[:, 0], np.full(k, y), outline[:, 1]]) for y in (low, high)]
    i, j = np.arange(k), (np.arange(k) + 1) % k
    fan = np.column_stack([np.zeros(k - 2, dtype=int), np.arange(1, k - 1), np.arange(2, k)])
    sides = np.vstack([np.column_stack([i, i + k, j]), np.column_stack([j, i + k, j + k])])
    return outward(np.vstack(rings), np.vstack([fan, fan[:, ::-1] + k, sides]))


def subdivided(vertices: Float, faces: Int, parts: int) -> tuple[Float, Int]:
    """Each triangle cut into parts² equal ones; neighbours share the vertices of their edge."""
    steps = [(i, j, parts - i - j) for i in range(parts + 1) for j in range(parts + 1 - i)]
    index = {s[:2]: n for n, s in enumerate(steps)}
    local = []
    for i, j, k in steps:
        if k > 0:
            local.append((index[i, j], index[i + 1, j], index[i, j + 1]))
        if k > 1:
            local.append((index[i + 1, j], index[i + 1, j + 1], index[i, j + 1]))
    weights = np.array(steps) / parts
    # two terms and a zero: the sum along a shared edge is the same, bit by bit, from either side
    a, b, c = (vertices[faces[:, n]][:, None] * weights[:, n, None] for n in range(3))
    points = (a + b + c).reshape(-1, 3) + 0.0
    shared, inverse = np.unique(points, axis=0, return_inverse=True)
    triangles = np.array(local)[None] + (np.arange(len(faces)) * len(steps))[:, None, None]
    return shared, inverse.reshape(-1)[triangles.reshape(-1, 3)]


def regular(vertices: Float, faces: Int) -> tuple[Float, Int]:
    """At least 20,000 triangles, all faces cut alike."""
    return subdivided(vertices, faces, int(np.ceil(np.sqrt(20_000 / len(faces)))))


def irregular(vertices: Float, faces: Int) -> tuple[Float, Int]:
    """At least 20,000 triangles: vertices wander within flat faces and along edges, then triangles are cut at will."""
    rng = np.random.default_rng(len(faces))
    parts = int(np.ceil(np.sqrt(20_000 / (9 * len(faces)))))
    vertices, faces = subdivided(vertices, faces, parts)
    vertices = _wandered(vertices, faces, rng)
    for _ in range(2):
        split = rng.dirichlet((2, 2, 2), len(faces))
        middle = np.einsum("fk,fkd->fd", split, vertices[faces])
        new = len(vertices) + np.arange(len(faces))
        a, b, c = faces.T
        faces = np.vstack([np.column_stack(t) for t in ((a, b, new), (b, c, new), (c, a, new))])
        vertices = np.vstack([vertices, middle])
    return vertices, faces


def _wandered(vertices: Float, faces: Int, rng: np.random.Generator) -> Float:
    """Vertices moved a little, in the plane of the flat face or along the straight edge that they lie on."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    cross = np.cross(b - a, c - a)
    twice = np.linalg.norm(cross, axis=1)
    normals = cross / twice[:, None]
    sides = np.stack([np.linalg.norm(p - q, axis=1) for p, q in ((a, b), (b, c), (c, a))])
    reach = np.full(len(vertices), np.inf)
    spread = np.zeros((len(vertices), 3, 3))
    for k in range(3):
        np.minimum.at(reach, faces[:, k], twice / sides.max(0))
        np.add.at(spread, faces[:, k], normals[:, :, None] * normals[:, None, :])
    weights, axes = np.linalg.eigh(spread)
    free = weights < 1e-9 * weights.max(1, keepdims=True)
    amounts = rng.uniform(-0.15, 0.15, weights.shape) * free * reach[:, None]
    return np.asarray(vertices + np.einsum("vdk,vk->vd", axes, amounts))


# --- scenes with flat contacts ----------------------------------------------------------------------------------------


def floor(x: float = 1.0, y: float = 1.0) -> Solid:
    """A fixed slab with its top at z = 0."""
    return Solid("floor", hf.Box(np.array([x, y, 0.05])), frame(z=-0.025), fixed=True)


def block(
    name: str, size: tuple[float, float, float], at: tuple[float, float, float], step: Iterable[float] = UP
) -> Solid:
    """An upright box about ``at``."""
    return Solid(name, hf.Box(np.array(size)), frame(*at), step=np.array(tuple(step), dtype=float))


def aligned(solids: Iterable[Solid]) -> dict[Pair, tuple[Truth, ...]]:
    """The contacts of boxes along the axes: where intervals touch on one axis and overlap on the other two."""
    truth: dict[Pair, tuple[Truth, ...]] = {}
    for one, two in itertools.combinations(list(solids), 2):
        if one.fixed and two.fixed:
            continue
        low = np.maximum(one.points.min(0), two.points.min(0))
        high = np.minimum(one.points.max(0), two.points.max(0))
        extent = high - low
        if (extent < -1e-9).any() or (extent > 1e-9).sum() != 2:
            continue
        axis = int(np.argmin(np.abs(extent)))
        normal = np.zeros(3)
        normal[axis] = np.sign(two.points.mean(0)[axis] - one.points.mean(0)[axis])
        u, v = (k for k in range(3) if k != axis)
        hull = np.empty((4, 3))
        hull[:, axis] = (low + high)[axis] / 2
        hull[:, u] = np.array([low[u], high[u], high[u], low[u]])
        hull[:, v] = np.array([low[v], low[v], high[v], high[v]])
        truth[one.name, two.name] = (Truth(hull, normal, float(extent[u] * extent[v])),)
    return truth


def of_boxes(*solids: Solid) -> Case:
    return Case(solids, aligned(solids))


def turned_box() -> Case:
    """A box set down askew."""
    pose = frame(0.1, -0.05, 0.05, spin(25))
    cube = Solid("box", hf.Box(np.array([0.12, 0.08, 0.1])), pose, step=UP)
    return Case((floor(), cube), {("floor", "box"): (horizontal(rectangle(0.12, 0.08, 0.1, -0.05, 25), 0),)})


def turned_stack() -> Case:
    """Three boxes, each turned by its own angle: polygons of up to eight corners between them."""
    plan = [(0.14, 0.13, 0, 0, 11), (0.12, 0.13, 0.01, 0.005, 47), (0.11, 0.1, -0.005, 0.01, 80)]
    solids, outlines = [floor()], []
    for k, (x, y, u, v, angle) in enumerate(plan):
        pose = frame(u, v, 0.05 + 0.1 * k, spin(angle))
        solids.append(Solid(f"c{k}", hf.Box(np.array([x, y, 0.1])), pose, step=(k + 1) * UP))
        outlines.append(rectangle(x, y, u, v, angle))
    truth = {("floor", "c0"): (horizontal(outlines[0], 0),)}
    for k in (0, 1):
        truth[f"c{k}", f"c{k + 1}"] = (horizontal(common(outlines[k], outlines[k + 1]), 0.1 * (k + 1)),)
    return Case(tuple(solids), truth)


def table() -> Case:
    return of_boxes(
        floor(),
        block("left", (0.05, 0.2, 0.2), (-0.175, 0, 0.1)),
        block("right", (0.05, 0.2, 0.2), (0.175, 0, 0.1)),
        block("slab", (0.5, 0.2, 0.05), (0, 0, 0.225), 2 * UP),
    )


def bond(courses: int, bricks: int, shift: float) -> Case:
    """Bricks in courses with closed head joints, every other course moved by a share of a brick."""
    solids = [floor(0.2 * bricks + 0.4, 0.5)]
    for row, k in itertools.product(range(courses), range(bricks)):
        at = (0.2 * (k + shift * (row % 2) - (bricks - 1) / 2), 0.0, 0.05 + 0.1 * row)
        solids.append(block(f"b{row}_{k}", (0.2, 0.1, 0.1), at, (k, 0, row + 1)))
    return of_boxes(*solids)


def slope() -> Case:
    """A cube, askew, on the slant of a wedge of 20 degrees that stands on the floor."""
    rise = 0.4 * np.tan(np.radians(20))
    wedge = extruded(np.array([(-0.2, 0), (0.2, 0), (0.2, rise)]), -0.15, 0.15)
    tilt = spin(-20, "y")
    middle = np.array([0, 0, rise / 2])
    normal = tilt.apply(UP)
    seat = level(rectangle(0.1, 0.1, degrees=30), 0)
    cube = Solid(
        "cube",
        hf.Box(np.full(3, 0.1)),
        frame_at(middle + 0.05 * normal, tilt * spin(30)),
        step=UP + normal,
    )
    truth = {
        ("floor", "wedge"): (horizontal(rectangle(0.4, 0.3), 0),),
        ("wedge", "cube"): (Truth(tilt.apply(seat) + middle, normal, 0.01),),
    }
    return Case((floor(), Solid("wedge", wedge, step=UP), cube), truth)


def overhang() -> Case:
    return of_boxes(
        floor(),
        block("a", (0.1, 0.1, 0.1), (0, 0, 0.05)),
        block("b", (0.16, 0.1, 0.1), (0.06, -0.03, 0.15), 2 * UP),
        block("c", (0.1, 0.3, 0.1), (0.1, 0.1, 0.25), 3 * UP),
    )


def cans() -> Case:
    """A cylinder standing on the floor and a second one on it, off centre: a disc and a lens of many corners."""
    below, above = ngon(0.05, 64), ngon(0.04, 64, 0.03, 0.0137)
    solids = (
        floor(),
        Solid("can", hf.Cylinder(0.05, 0.2), frame(z=0.1), step=UP),
        Solid("lid", hf.Cylinder(0.04, 0.1), frame(0.03, 0.0137, 0.25), step=2 * UP),
    )
    return Case(
        solids,
        {("floor", "can"): (horizontal(below, 0),), ("can", "lid"): (horizontal(common(below, above), 0.2),)},
    )


def ring(outer: Float, inner: Float, z: float) -> Truth:
    return Truth(level(hull_of(outer), z), UP, shoelace(outer) - shoelace(inner), (level(inner, z),))


BOWL = [(0, 0.01), (0.03, 0.01), (0.03, 0), (0.05, 0), (0.1, 0.06), (0.094, 0.06), (0.045, 0.02), (0.0, 0.02)]


def bowl() -> Case:
    """A bowl on its ring-shaped foot."""
    solids = (floor(), Solid("bowl", revolved(BOWL, 48), frame(0.1, 0.2, 0), step=UP))
    return Case(solids, {("floor", "bowl"): (ring(ngon(0.05, 48, 0.1, 0.2), ngon(0.03, 48, 0.1, 0.2), 0),)})


def tube(inner: float, outer: float, low: float, high: float, sides: int) -> hf.Mesh:
    return revolved([(inner, low), (outer, low), (outer, high), (inner, high)], sides, closed=True)


MUG = [(0, 0.008), (0.03, 0.008), (0.03, 0), (0.04, 0), (0.04, 0.1), (0.036, 0.1), (0.036, 0.014), (0, 0.014)]


def mug_on_ring() -> Case:
    """A mug, its foot wider inside than a ring-shaped coaster is, which again is narrower outside: ring on ring."""
    solids = (
        floor(),
        Solid("coaster", tube(0.025, 0.035, 0, 0.01, 60), step=UP),
        Solid("mug", revolved(MUG, 60), frame(z=0.01), step=2 * UP),
    )
    seat = ring(ngon(0.035, 60), ngon(0.03, 60), 0.01)
    truth = {("floor", "coaster"): (ring(ngon(0.035, 60), ngon(0.025, 60), 0),), ("coaster", "mug"): (seat,)}
    return Case(solids, truth)


def mug_on_rim() -> Case:
    """A mug half over the rim of a table: a ring cut open, so neither convex nor holed."""
    top = block("table", (0.4, 0.4, 0.1), (0.021 - 0.2, 0, 0.05))
    mug = Solid("mug", revolved(MUG, 48), frame(z=0.1), step=2 * UP)
    half = rectangle(0.4, 0.4, 0.021 - 0.2)
    outer, inner = common(ngon(0.04, 48), half), common(ngon(0.03, 48), half)
    seat = Truth(level(outer, 0.1), UP, shoelace(outer) - shoelace(inner))
    return Case((floor(), top, mug), {**aligned((floor(), top)), ("table", "mug"): (seat,)})


def interlock() -> Case:
    """An L hooked over and into one arm of a U: three patches of one pair, with two normals."""
    u = cells(
        np.array([-0.15, -0.1, 0.1, 0.15]),
        np.array([-0.06, 0.06]),
        np.array([0, 0.05, 0.2]),
        np.array([[[1, 1]], [[1, 0]], [[1, 1]]]),
    )
    hook = cells(
        np.array([-0.18, -0.1, -0.02]),
        np.array([-0.03, 0.05]),
        np.array([0.05, 0.2, 0.26]),
        np.array([[[0, 1]], [[1, 1]]]),
    )
    wall = np.array([(-0.1, y, z) for y, z in ((-0.03, 0.05), (0.05, 0.05), (0.05, 0.2), (-0.03, 0.2))])
    solids = (floor(), Solid("u", u, step=UP), Solid("l", hook, step=np.array([1.0, 0, 2])))
    truth = {
        ("floor", "u"): (horizontal(rectangle(0.3, 0.12), 0),),
        ("u", "l"): (
            horizontal(rectangle(0.08, 0.08, -0.06, 0.01), 0.05),
            horizontal(rectangle(0.05, 0.08, -0.125, 0.01), 0.2),
            Truth(wall, np.array([1.0, 0, 0]), 0.08 * 0.15),
        ),
    }
    return Case(solids, truth)


def stack_bond(keep: Callable[[int, int, int], bool] = lambda i, j, k: True) -> Case:
    """Bricks right beside, behind and above each other: those across share an edge or a corner, which is no contact."""
    solids = [
        block(f"b{i}{j}{k}", (0.2, 0.1, 0.1), (0.2 * i - 0.2, 0.1 * j - 0.05, 0.05 + 0.1 * k), (i, j, k + 1))
        for i, j, k in itertools.product(range(3), range(2), range(3))
        if keep(i, j, k)
    ]
    return of_boxes(floor(), *solids)


def chequered() -> Case:
    """Only every other brick of the stack bond: nothing touches but edges, and the floor below."""
    return stack_bond(lambda i, j, k: (i + j + k) % 2 == 0)


def peg(clearance: float = 0.0) -> Case:
    """A peg of 24 sides in a hole of as many, deeper than the hole."""
    inner, outline = 0.02 + clearance, ngon(0.02, 24)
    after = np.roll(outline, -1, axis=0)
    walls = []
    for p, q in zip(outline, after, strict=True):
        normal = np.array([*(-(p + q) / np.linalg.norm(p + q)), 0])
        away = -normal * (clearance * np.cos(np.pi / 24)) / 2
        corners = np.array([(*p, 0), (*q, 0), (*q, 0.05), (*p, 0.05)]) + away
        walls.append(Truth(corners, normal, float(np.linalg.norm(q - p)) * 0.05))
    solids = (
        floor(),
        Solid("sleeve", tube(inner, 0.06, 0, 0.05, 24), fixed=True),
        Solid("peg", extruded_up(outline, 0, 0.1), step=UP),
    )
    return Case(solids, {("floor", "peg"): (horizontal(outline, 0),), ("sleeve", "peg"): tuple(walls)})


def extruded_up(outline: Float, low: float, high: float) -> hf.Mesh:
    """A convex outline (k, 2) in x and y, extruded along z."""
    mesh = extruded(outline, low, high)
    return outward(mesh.vertices[:, [0, 2, 1]], mesh.faces)


FLAT: dict[str, Callable[[], Case]] = {
    "turned box": turned_box,
    "turned stack": turned_stack,
    "table": table,
    "half bond": lambda: bond(10, 5, 0.5),
    "slope": slope,
    "overhang": overhang,
    "cans": cans,
    "bowl": bowl,
    "mug on ring": mug_on_ring,
    "mug on rim": mug_on_rim,
    "interlock": interlock,
    "stack bond": stack_bond,
    "chequered": chequered,
}


# --- scenes with lines and points -------------------------------------------------------------------------------------


def edge_on_floor() -> Case:
    """A cube on one of its edges."""
    pose = frame(z=0.05 * (np.sin(np.radians(30)) + np.cos(np.radians(30))), turn=spin(30, "x"))
    y = spin(30, "x").apply([0, -0.05, -0.05])[1]
    return Case(
        (floor(), Solid("cube", hf.Box(np.full(3, 0.1)), pose, step=UP)),
        {("floor", "cube"): (line((-0.05, y, 0), (0.05, y, 0)),)},
    )


def corner_on_floor() -> Case:
    turn = Rotation.from_euler("zyx", (20, 35, 40), degrees=True)
    corner = np.array([-0.05, -0.05, -0.05])
    lowest = min((turn.apply(corner * s) for s in itertools.product((-1, 1), repeat=3)), key=lambda p: float(p[2]))
    pose = frame(z=-lowest[2], turn=turn)
    cube = Solid("cube", hf.Box(np.full(3, 0.1)), pose, step=UP)
    return Case((floor(), cube), {("floor", "cube"): (point((lowest[0], lowest[1], 0)),)})


ROOF = np.array([(-0.06, -0.05), (0.08, -0.05), (0, 0)])


def ridges_cross() -> Case:
    """The ridge of a roof across that of another one, upside down, at 60 degrees."""
    below = Solid("below", extruded(ROOF, -0.1, 0.12), fixed=True)
    above = Solid("above", extruded(ROOF, -0.09, 0.1), frame(0, 0.02, 0, spin(60) * spin(180, "y")), step=UP)
    return Case((below, above), {("below", "above"): (point((0, 0.02, 0)),)})


def box_edges_cross() -> Case:
    """The edge of a tilted box on the edge of a fixed one, askew: the normal is the cross product of the two."""
    normal = np.array([np.sin(np.radians(35)), 0, np.cos(np.radians(35))])
    side = np.cross([0.0, 1, 0], normal)
    edge = np.cos(np.radians(50)) * np.array([0, 1, 0]) + np.sin(np.radians(50)) * side
    across = np.cross(normal, edge)
    # the box lies on the normal's side of its edge: its faces rise at 35 and 55 degrees from the common tangent plane
    one = np.cos(np.radians(35)) * across + np.sin(np.radians(35)) * normal
    two = np.cross(edge, one)
    two *= np.sign(two @ normal)
    axes = np.column_stack([one, two, edge])
    if np.linalg.det(axes) < 0:
        axes[:, 2] *= -1
    pose = np.eye(4)
    pose[:3, :3] = axes
    pose[:3, 3] = 0.05 * one + 0.04 * two + 0.01 * edge
    support = Solid("support", hf.Box(np.array([0.2, 0.3, 0.2])), frame(-0.1, 0.02, -0.1), fixed=True)
    leaning = Solid("box", hf.Box(np.array([0.1, 0.08, 0.2])), pose, step=normal)
    return Case((support, leaning), {("support", "box"): (point((0, 0, 0), normal),)})


def plank(width: float) -> Case:
    """A plank with an edge on the floor, its underside on the edge of a box of 0.12 m across."""
    tilt = np.radians(40)
    along, normal = np.array([np.cos(tilt), 0, np.sin(tilt)]), np.array([-np.sin(tilt), 0, np.cos(tilt)])
    foot = np.array([-0.15 / np.tan(tilt), 0, 0])
    pose = np.eye(4)
    pose[:3, :3] = np.column_stack([along, [0, 1, 0], normal])
    pose[:3, 3] = foot + 0.2 * along + 0.01 * normal
    lean = Solid("plank", hf.Box(np.array([0.4, width, 0.02])), pose, step=np.array([-1 / np.sin(tilt), 0, 1]))
    support = block("box", (0.1, 0.12, 0.15), (0.05, 0, 0.075))
    half, wide = min(width, 0.12) / 2, width / 2
    truth = {
        ("floor", "box"): (horizontal(rectangle(0.1, 0.12, 0.05), 0),),
        ("floor", "plank"): (line((foot[0], -wide, 0), (foot[0], wide, 0)),),
        ("box", "plank"): (line((0, -half, 0.15), (0, half, 0.15), normal),),
    }
    return Case((floor(), support, lean), truth)


def ladder() -> Case:
    """A board between floor and wall: two edges, each on a face."""
    tilt = np.radians(65)
    along, back = np.array([np.cos(tilt), 0, np.sin(tilt)]), np.array([-np.sin(tilt), 0, np.cos(tilt)])
    # the board's lower right edge stands on the floor, its upper right... whichever corner is lowest and rightmost
    outline = np.array([-0.2 * along, 0.2 * along, 0.2 * along + 0.02 * back, -0.2 * along + 0.02 * back])
    low, right = outline[:, 2].min(), outline[:, 0].max()
    foot = outline[outline[:, 2].argmin()] - [0, 0, low]
    head = outline[outline[:, 0].argmax()] - [0, 0, low]
    pose = np.eye(4)
    pose[:3, :3] = np.column_stack([along, [0, 1, 0], back])
    pose[:3, 3] = 0.01 * back - np.array([0, 0, low])
    board = Solid("board", hf.Box(np.array([0.4, 0.1, 0.02])), pose, step=np.array([-1.0, 0, 1]))
    wall = Solid("wall", hf.Box(np.array([0.05, 0.4, 0.6])), frame(right + 0.025, 0, 0.3), fixed=True)
    truth = {
        ("floor", "board"): (line((foot[0], -0.05, 0), (foot[0], 0.05, 0)),),
        ("wall", "board"): (line((right, -0.05, head[2]), (right, 0.05, head[2]), np.array([-1.0, 0, 0])),),
    }
    return Case((floor(), wall, board), truth)


LYING = spin(90, "y")  # the cylinder's axis along x, a corner of its outline below


def lying_on_edge() -> Case:
    """A lying cylinder that touches with an edge of its outline: nothing but a line."""
    can = Solid("can", hf.Cylinder(0.05, 0.2), frame(z=0.05, turn=LYING), step=UP)
    return Case((floor(), can), {("floor", "can"): (line((-0.1, 0, 0), (0.1, 0, 0)),)})


def lying_on_facet() -> Case:
    """A lying cylinder, given as a mesh, that touches with one flat side of its outline: a strip just as wide."""
    half = np.pi / 64
    drawn = hf.Cylinder(0.05, 0.2).surface
    can = Solid(
        "can",
        hf.Mesh(drawn.vertices, drawn.faces),
        frame(z=0.05 * np.cos(half), turn=Rotation.from_rotvec([half, 0, 0]) * LYING),
        step=UP,
    )
    return Case((floor(), can), {("floor", "can"): (horizontal(rectangle(0.2, 0.1 * np.sin(half)), 0),)})


def lying_between_edges() -> Case:
    """A lying cylinder whose outline has neither an edge nor the middle of a side below: a line all the same."""
    can = Solid("can", hf.Cylinder(0.05, 0.2), frame(z=0.05, turn=Rotation.from_rotvec([0.02, 0, 0]) * LYING), step=UP)
    return Case((floor(), can), {("floor", "can"): (line((-0.1, 0, 0), (0.1, 0, 0)),)})


def groove() -> Case:
    """A cylinder in a V of 90 degrees, longer than the V: a line on each side."""
    walls = []
    truth: dict[Pair, tuple[Truth, ...]] = {}
    for name, sign in (("left", -1), ("right", 1)):
        outline = np.array([(0, 0), (sign * 0.1, 0), (sign * 0.1, 0.1)])[:: int(sign)]
        walls.append(Solid(name, turned_mesh(extruded(outline, -0.06, 0.09)), fixed=True))
        normal = np.array([0, -sign, 1]) / np.sqrt(2)
        y = sign * 0.05 / np.sqrt(2)
        truth[name, "can"] = (line((-0.09, y, abs(y)), (0.06, y, abs(y)), normal),)
    can = Solid("can", hf.Cylinder(0.05, 0.3), frame(z=0.05 * np.sqrt(2), turn=LYING), step=np.sqrt(2) * UP)
    return Case((*walls, can), truth)


def turned_mesh(mesh: hf.Mesh) -> hf.Mesh:
    """A quarter turn about z: (x, y) becomes (-y, x)."""
    return hf.Mesh(mesh.vertices[:, [1, 0, 2]] * [-1, 1, 1], mesh.faces)


def rails() -> Case:
    """A lying cylinder across two rails: a short line on each."""
    can = Solid("can", hf.Cylinder(0.05, 0.3), frame(z=0.15, turn=LYING), step=2 * UP)
    bars = [block(name, (0.03, 0.3, 0.1), (x, 0, 0.05)) for name, x in (("one", -0.1), ("two", 0.12))]
    lines: dict[Pair, tuple[Truth, ...]] = {
        (name, "can"): (line((x - 0.015, 0, 0.1), (x + 0.015, 0, 0.1)),) for name, x in (("one", -0.1), ("two", 0.12))
    }
    return Case((floor(), *bars, can), {**aligned((floor(), *bars)), **lines})


def sphere_on_vertex() -> Case:
    ball = Solid("ball", hf.Sphere(0.05), frame(0.02, -0.03, 0.05), step=UP)
    return Case((floor(), ball), {("floor", "ball"): (point((0.02, -0.03, 0)),)})


CRISP: dict[str, Callable[[], Case]] = {
    "edge on floor": edge_on_floor,
    "corner on floor": corner_on_floor,
    "ridges cross": ridges_cross,
    "box edges cross": box_edges_cross,
    "narrow plank": lambda: plank(0.08),
    "wide plank": lambda: plank(0.2),
    "ladder": ladder,
    "lying on edge": lying_on_edge,
    "lying on facet": lying_on_facet,
    "lying between edges": lying_between_edges,
    "groove": groove,
    "rails": rails,
    "sphere on vertex": sphere_on_vertex,
}


# --- the yardstick ----------------------------------------------------------------------------------------------------


def by_pair(interfaces: Iterable[hf.answers.Interface]) -> dict[frozenset[str], hf.answers.Interface]:
    found: dict[frozenset[str], hf.answers.Interface] = {}
    for interface in interfaces:
        key = frozenset(interface.bodies)
        assert key not in found, f"{interface.bodies} has two interfaces"
        found[key] = interface
    return found


def apart(one: Float, two: Float) -> float:
    """Hausdorff distance of two point sets."""
    gaps = np.linalg.norm(one[:, None] - two[None], axis=2)
    return float(max(gaps.min(0).max(), gaps.min(1).max()))


def same_pairs(interfaces: Iterable[hf.answers.Interface], case: Case) -> dict[frozenset[str], hf.answers.Interface]:
    """Exactly the pairs of the truth have an interface; they are returned by pair."""
    found = by_pair(interfaces)
    wanted = {frozenset(pair) for pair in case.truth}
    missed = sorted(tuple(sorted(p)) for p in wanted - set(found))
    invented = sorted(tuple(sorted(p)) for p in set(found) - wanted)
    assert not missed, f"missed {missed}"
    assert not invented, f"invented {invented}"
    return found


def agree(interfaces: Iterable[hf.answers.Interface], case: Case, length: float, relative: float) -> None:
    """The interfaces are those of the truth: pairs, patches, normals, hulls within ``length`` [m], relative areas."""
    found = same_pairs(interfaces, case)
    for pair, truths in case.truth.items():
        interface = found[frozenset(pair)]
        sense = 1 if interface.bodies == pair else -1
        summary = [(p.kind, float(p.area), np.round(p.normal, 3).tolist()) for p in interface.patches]
        assert len(interface.patches) == len(truths), f"{pair}: {summary}"
        unlike = np.array(
            [
                [
                    np.linalg.norm(p.centroid - t.hull.mean(0)) + np.linalg.norm(sense * p.normal - t.normal)
                    for t in truths
                ]
                for p in interface.patches
            ]
        )
        for i, j in zip(*linear_sum_assignment(unlike), strict=True):
            patch, truth = interface.patches[i], truths[j]
            where = f"{pair}, patch {i}"
            assert patch.kind == truth.kind, f"{where}: {summary}"
            np.testing.assert_allclose(sense * patch.normal, truth.normal, atol=max(relative, 1e-9), err_msg=where)
            if relative <= 1e-8:  # coarser: corners of the outline may come in pairs closer than that
                assert len(patch.hull) == len(truth.hull), f"{where}: {patch.hull.tolist()}"
            assert apart(patch.hull, truth.hull) < length, f"{where}: hull"
            assert apart(patch.polygon, truth.hull) < (length if truth.kind != "face" else np.inf), f"{where}: polygon"
            height = (patch.polygon - truth.hull[0]) @ truth.normal
            assert np.abs(height).max() < length, f"{where}: out of plane"
            assert abs(patch.area - truth.area) <= relative * truth.area, f"{where}: {patch.area} for {truth.area}"
            assert len(patch.holes) == len(truth.holes), f"{where}: holes"
            for hole, known in zip(patch.holes, truth.holes, strict=True):
                assert apart(hole, known) < length, f"{where}: hole"
        total = sum(t.area for t in truths)
        assert abs(interface.area - total) <= relative * total, f"{pair}: {interface.area} for {total}"
