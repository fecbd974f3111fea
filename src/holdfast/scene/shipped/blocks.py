"""Shipped scenes made of blocks: cubes, tables, walls, arches and wedges.

Scenes of the paper have its sizes where it gives them.
"""

from __future__ import annotations

import numpy as np

from holdfast.base.arrays import Float
from holdfast.base.rigid import pose_from
from holdfast.scene.body import Body
from holdfast.scene.scene import Scene
from holdfast.scene.shapes import Box, Mesh

UPRIGHT = np.array([1.0, 0, 0, 0])


def at(x: float, y: float, z: float, quaternion: Float = UPRIGHT) -> Float:
    """Return the pose (4, 4), body frame to world, at this position [m] with this quaternion (w, x, y, z)."""
    return pose_from(np.array([x, y, z]), quaternion)


def about_x(angle: float) -> Float:
    """Return the quaternion of a rotation by ``angle`` [rad] about the x axis."""
    return np.array([np.cos(angle / 2), np.sin(angle / 2), 0, 0])


def about_y(angle: float) -> Float:
    """Return the quaternion of a rotation by ``angle`` [rad] about the y axis."""
    return np.array([np.cos(angle / 2), 0, np.sin(angle / 2), 0])


def floor(x: float = 1.0, y: float = 1.0) -> Body:
    """Return a fixed slab of ``x`` by ``y`` metres with its top at z = 0."""
    return Body("floor", Box(np.array([x, y, 0.05])), pose=at(0, 0, -0.025), fixed=True)


def box(name: str, size: tuple[float, float, float], mass: float, centre: tuple[float, float, float]) -> Body:
    """Return an upright movable box; ``size`` and ``centre`` are in metres, ``mass`` in kilograms."""
    return Body(name, Box(np.array(size)), mass=mass, pose=at(*centre))


def prism(name: str, outline: Float, depth: float, axis: int, **body: object) -> Body:
    """Return a prism: a convex polygon (k, 2) [m], counter-clockwise, extruded by ``depth`` [m] along a world axis.

    ``axis`` is 0 for x or 1 for y, and the prism is centred on the origin along it. The coordinates of ``outline`` are
    (y, z) for axis 0, and (x, z) seen from -y for axis 1.
    """
    k = len(outline)
    near, far = np.full(k, -depth / 2), np.full(k, depth / 2)
    rings = []
    for level in (near, far):
        columns = [level, outline[:, 0], outline[:, 1]] if axis == 0 else [outline[:, 0], level, outline[:, 1]]
        rings.append(np.column_stack(columns))
    i = np.arange(k)
    j = (i + 1) % k
    fan = np.column_stack([np.zeros(k - 2, dtype=int), i[1:-1], i[2:]])
    sides = np.vstack([np.column_stack([i, j, j + k]), np.column_stack([i, j + k, i + k])])
    faces = np.vstack([fan[:, ::-1], fan + k, sides])
    if axis == 1:
        faces = faces[:, ::-1]
    return Body(name, Mesh(np.vstack(rings), faces, label=f"body {name!r}"), **body)  # type: ignore[arg-type]


def cube() -> Scene:
    """A cube of 0.1 m and 1 kg on the floor, with μ = 0.6."""
    return Scene([floor(), box("cube", (0.1, 0.1, 0.1), 1, (0, 0, 0.05))], 0.6, name="cube")


def stack() -> Scene:
    """A stack of three cubes of 0.1 m and 1 kg on the floor, with μ = 0.6."""
    cubes = [box(f"cube{k + 1}", (0.1, 0.1, 0.1), 1, (0, 0, 0.05 + 0.1 * k)) for k in range(3)]
    return Scene([floor(), *cubes], 0.6, name="stack")


def table(leg: float = 0.2, name: str = "table") -> Scene:
    """A slab of 0.5 x 0.2 x 0.05 m and 2 kg on two legs of 1 kg, which are 0.05 m from its ends, with μ = 0.5."""
    legs = [
        box(f"leg_{side}", (0.05, 0.2, leg), 1, (x, 0, leg / 2)) for side, x in (("left", -0.175), ("right", 0.175))
    ]
    return Scene([floor(), box("slab", (0.5, 0.2, 0.05), 2, (0, 0, leg + 0.025)), *legs], 0.5, name=name)


def tall_table() -> Scene:
    """The table with legs that are three times as high."""
    return table(0.6, "tall_table")


def wall(courses: int, bricks: int, shift: float, name: str) -> Scene:
    """A wall of bricks of 0.2 x 0.1 x 0.1 m and 4 kg, with closed head joints.

    Every other course is shifted by ``shift``, as a share of a brick's length.
    """
    bodies = [
        box(f"b{row}_{k}", (0.2, 0.1, 0.1), 4, (0.2 * (k + shift * (row % 2) - (bricks - 1) / 2), 0, 0.05 + 0.1 * row))
        for row in range(courses)
        for k in range(bricks)
    ]
    return Scene([floor(0.2 * bricks + 0.4, 0.5), *bodies], 0.6, name=name)


def wall2x2() -> Scene:
    """A wall of two courses of two bricks; the upper course is shifted by a quarter brick."""
    return wall(2, 2, 0.25, "wall2x2")


def bonded_wall() -> Scene:
    """A wall of ten courses of five bricks in quarter bond, with 126 interfaces."""
    return wall(10, 5, 0.25, "bonded_wall")


def slope(second: bool = False) -> Scene:
    """The slope of the paper's Fig. 15: a cube on a movable 1:2 wedge on a fixed platform, with μ = 1.2.

    The slope rises towards +y, and the cube lies in its middle. With ``second``, another cube touches the first on the
    uphill side, and the pair lies in the middle.
    """
    outline = np.array([[-0.15, 0.0], [0.15, 0.0], [0.15, 0.15]])
    wedge = prism("wedge", outline, 0.1, 0, mass=1.0)
    tilt = np.arctan(0.5)
    along, up = np.array([0, np.cos(tilt), np.sin(tilt)]), np.array([0, -np.sin(tilt), np.cos(tilt)])
    bodies = [floor(0.6, 0.6), wedge]
    count = 2 if second else 1
    for k in range(count):
        place = np.hypot(0.3, 0.15) / 2 + 0.1 * (k + 0.5 - count / 2)
        centre = np.array([0, -0.15, 0]) + place * along + 0.05 * up
        pose = pose_from(centre, about_x(tilt))
        bodies.append(Body(f"cube{k + 1}", Box(np.full(3, 0.1)), mass=1.0, pose=pose))
    return Scene(bodies, 1.2, name="slope_two" if second else "slope")


def slope_two() -> Scene:
    """The slope with the second cube (Fig. 15b)."""
    return slope(second=True)


def cantilever() -> Scene:
    """The cantilever of the paper's Fig. 16.

    Plank B lies across column A; load C lies on one end and counterweight D on the other.
    """
    bodies = [
        box("A", (0.1, 0.1, 0.3), 2, (0, 0, 0.15)),
        box("B", (0.5, 0.1, 0.02), 1, (0.04, 0, 0.31)),
        box("C", (0.05, 0.05, 0.05), 0.5, (0.25, 0, 0.345)),
        box("D", (0.1, 0.1, 0.1), 1.5, (-0.1, 0, 0.37)),
    ]
    return Scene([floor(), *bodies], 0.6, name="cantilever")


def arch() -> Scene:
    """A semicircular arch of five voussoirs on the floor, with radii of 0.2 m and 0.3 m and μ = 0.7."""
    bodies = [floor()]
    for k in range(5):
        angle = np.pi * (1 - (k + np.linspace(0, 1, 5)) / 5)
        inner = 0.2 * np.column_stack([np.cos(angle), np.sin(angle)])
        outer = 0.3 * np.column_stack([np.cos(angle), np.sin(angle)])
        inner[np.abs(inner) < 1e-12] = outer[np.abs(outer) < 1e-12] = 0.0
        bodies.append(_voussoir(f"v{k + 1}", inner, outer))
    return Scene(bodies, 0.7, name="arch")


def _voussoir(name: str, inner: Float, outer: Float) -> Body:
    """Return a curved block between two polylines (n, 2) [m] in x and z, 0.15 m deep along y."""
    n = len(inner)
    flat = np.vstack([inner, outer])
    vertices = np.vstack([np.column_stack([flat[:, 0], np.full(2 * n, y), flat[:, 1]]) for y in (-0.075, 0.075)])
    faces = []
    back = 2 * n
    for i in range(n - 1):
        a, b, c, d = i, i + 1, n + i + 1, n + i
        faces += [(a, c, b), (a, d, c), (a + back, b + back, c + back), (a + back, c + back, d + back)]
        faces += [(a, b, b + back), (a, b + back, a + back), (d, c + back, c), (d, d + back, c + back)]
    for a, d, sign in ((0, n, 1), (n - 1, 2 * n - 1, -1)):
        quad = [(a, a + back, d + back), (a, d + back, d)]
        faces += quad if sign > 0 else [q[::-1] for q in quad]
    return Body(name, Mesh(vertices, np.array(faces), label=f"body {name!r}"), density=2000)


def v_groove() -> Scene:
    """A cube that stands on its edge in a fixed groove of 90 degrees, with μ = 0.5."""
    left = np.array([[-0.15, 0.0], [0.0, 0.0], [-0.15, 0.15]])
    right = np.array([[0.0, 0.0], [0.15, 0.0], [0.15, 0.15]])
    bodies = [
        prism("left", left, 0.2, 1, fixed=True),
        prism("right", right, 0.2, 1, fixed=True),
        Body("cube", Box(np.full(3, 0.1)), mass=1.0, pose=at(0, 0, 0.05 * np.sqrt(2), about_y(np.pi / 4))),
    ]
    return Scene(bodies, 0.5, name="v_groove")


def wedged(with_floor: bool = False) -> Scene:
    """A cube between two fixed walls that it touches without being pressed against them, with μ = 0.6."""
    walls = [
        Body(name, Box(np.array([0.05, 0.2, 0.2])), pose=at(x, 0, 0.15), fixed=True)
        for name, x in (("wall_left", -0.075), ("wall_right", 0.075))
    ]
    height = 0.05 if with_floor else 0.15
    bodies = [*walls, box("cube", (0.1, 0.1, 0.1), 1, (0, 0, height))]
    if with_floor:
        bodies.insert(0, floor())
    return Scene(bodies, 0.6, name="wedged_floor" if with_floor else "wedged")


def wedged_floor() -> Scene:
    """The cube between two walls, with a floor under it."""
    return wedged(with_floor=True)
