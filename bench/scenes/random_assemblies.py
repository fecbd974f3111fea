"""Fourteen families of random assemblies, as benchmarks and tests draw them.

A family is a function ``family(rng) -> Scene``. All lengths, masses, friction coefficients and turns come from the
generator that it is given, so the same seed gives the same scene. Bodies touch exactly, and most scenes of every family
stand. Each of them holds a fixed floor named "floor" whose top is at z = 0, and the whole scene is turned about the
vertical by a random angle. The functions ``with_...`` return a scene with something added that makes trouble.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType

import numpy as np
from numpy.random import Generator
from scipy.spatial import ConvexHull

from holdfast.assembly.assembly import Assembly, assemble
from holdfast.base.arrays import Float
from holdfast.base.errors import HoldfastError, message
from holdfast.base.rigid import tangents
from holdfast.engines.limit_engine import Limit
from holdfast.engines.verdict import Status
from holdfast.geometry.sweep import first_hit
from holdfast.scene.body import Body
from holdfast.scene.friction import Friction
from holdfast.scene.scene import Scene
from holdfast.scene.shapes import Box, Cylinder, Mesh, Sphere
from holdfast.scene.shipped.blocks import about_y, at, floor, prism

Family = Callable[[Generator], Scene]

ACROSS = 2.0  # [m] length and width of the floor
DENSITY = (300.0, 2500.0)  # [kg/m³] range from light wood to stone
FRICTION = (0.3, 0.9)  # the coefficient of a body; that of a pair is the smaller of its two
TRIES = 50  # draws after which a family counts as one that does not stand


def about_z(degrees: float) -> Float:
    """Return the quaternion (w, x, y, z) of a rotation about the z axis, counter-clockwise seen from above."""
    half = np.radians(degrees) / 2
    return np.array([np.cos(half), 0, 0, np.sin(half)])


def density(rng: Generator) -> float:
    """Return a random density [kg/m³]."""
    return float(rng.uniform(*DENSITY))


def resting(rng: Generator, name: str, size: Sequence[float] | Float, foot: Sequence[float], turn: float = 0) -> Body:
    """Return a box of random density; the middle of its lower face is at ``foot`` (3,) [m], turned by ``turn`` [°]."""
    x, y, z = foot
    return Body(name, Box(size), density=density(rng), pose=at(x, y, z + size[2] / 2, about_z(turn)))


def can(rng: Generator, name: str, radius: float, height: float, foot: Sequence[float]) -> Body:
    """Return an upright cylinder of random density; the middle of its lower face is at ``foot`` (3,) [m]."""
    x, y, z = foot
    return Body(name, Cylinder(radius, height, 32), density=density(rng), pose=at(x, y, z + height / 2))


def finished(rng: Generator, name: str, bodies: Iterable[Body], rough: float = FRICTION[0]) -> Scene:
    """Return the bodies on a floor, with random friction of at least ``rough``, all turned about the vertical."""
    turn = at(0, 0, 0, about_z(rng.uniform(0, 360)))
    turned = [body.moved(turn @ body.pose) for body in (floor(ACROSS, ACROSS), *bodies)]
    values = {body.name: float(rng.uniform(rough, FRICTION[1])) for body in turned}
    return Scene(turned, Friction(rough, values=values, combine="min"), name=name)


def block(rng: Generator) -> Scene:
    """A single box."""
    return finished(rng, "block", [resting(rng, "block", rng.uniform(0.05, 0.2, 3), (0, 0, 0))])


def tower(rng: Generator) -> Scene:
    """Two to four unlike boxes on each other, each turned and off the middle of the one below."""
    bodies: list[Body] = []
    height = 0.0
    for k in range(int(rng.integers(2, 5))):
        size = rng.uniform((0.08, 0.08, 0.04), 0.2)
        x, y = rng.uniform(-0.02, 0.02, 2)
        bodies.append(resting(rng, f"box{k + 1}", size, (x, y, height), rng.uniform(-20, 20)))
        height += size[2]
    return finished(rng, "tower", bodies)


def table(rng: Generator) -> Scene:
    """A slab on two legs as wide as itself, or on four legs near its corners."""
    length, width, thick = rng.uniform((0.3, 0.15, 0.02), (0.6, 0.3, 0.06))
    leg, height = rng.uniform((0.03, 0.1), (0.06, 0.3))
    x = length / 2 - leg * rng.uniform(0.5, 1.5)
    y = (width - leg) / 2
    if rng.random() < 0.5:
        feet, section = [(-x, 0.0), (x, 0.0)], (leg, width)
    else:
        feet, section = [(-x, -y), (x, -y), (-x, y), (x, y)], (leg, leg)
    legs = [resting(rng, f"leg{k + 1}", (*section, height), (*foot, 0)) for k, foot in enumerate(feet)]
    return finished(rng, "table", [*legs, resting(rng, "slab", (length, width, thick), (0, 0, height))])


def pyramid(rng: Generator) -> Scene:
    """Two or three courses of equal boxes, every box across the gap between two below it."""
    size = rng.uniform(0.06, 0.15, 3)
    step = size[0] * rng.uniform(1.05, 1.5)
    courses = int(rng.integers(2, 4))
    bodies = [
        resting(rng, f"box{row}_{k}", size, (step * (k - (courses - row - 1) / 2), 0, row * size[2]))
        for row in range(courses)
        for k in range(courses - row)
    ]
    return finished(rng, "pyramid", bodies)


def wall(rng: Generator) -> Scene:
    """Two or three courses of bricks with closed head joints, every other course shifted."""
    length, width, height = rng.uniform((0.15, 0.07, 0.05), (0.25, 0.12, 0.12))
    courses, bricks = (int(n) for n in rng.integers(2, 4, 2))
    shift = rng.uniform(0.15, 0.4)
    bodies = [
        resting(
            rng,
            f"brick{row}_{k}",
            (length, width, height),
            (length * (k + shift * (row % 2) - (bricks - 1) / 2), 0, row * height),
        )
        for row in range(courses)
        for k in range(bricks)
    ]
    return finished(rng, "wall", bodies)


def arch(rng: Generator) -> Scene:
    """A semicircular arch of three, five or seven voussoirs on the floor."""
    count = int(rng.choice([3, 5, 7]))
    inner, thick, depth = rng.uniform((0.15, 0.06, 0.1), (0.25, 0.12, 0.2))
    angles = np.pi * (1 - np.arange(count + 1) / count)
    ring = np.column_stack([np.cos(angles), np.sin(angles)])
    ring[[0, -1], 1] = 0  # the springers stand flat on the floor
    low, high = inner * ring, (inner + thick) * ring
    stone = density(rng)
    bodies = [
        prism(f"stone{k + 1}", np.array([low[k], low[k + 1], high[k + 1], high[k]]), depth, 1, density=stone)
        for k in range(count)
    ]
    return finished(rng, "arch", bodies, rough=0.6)


def leaning(rng: Generator) -> Scene:
    """A plank that stands on its lower edge and leans with its upper one against a heavy block."""
    length, width, thick = rng.uniform((0.2, 0.05, 0.01), (0.4, 0.15, 0.03))
    tilt = np.radians(rng.uniform(55, 75))
    along, across = np.array([np.cos(tilt), np.sin(tilt)]), np.array([-np.sin(tilt), np.cos(tilt)])
    foot, top = (sign * length / 2 * along - thick / 2 * across for sign in (-1, 1))
    middle = at(0, 0, -foot[1], about_y(-tilt))
    plank = Body("plank", Box((length, width, thick)), density=density(rng), pose=middle)
    size = (rng.uniform(0.1, 0.2), rng.uniform(0.15, 0.25), (top - foot)[1] + rng.uniform(0.01, 0.05))
    heavy = Body("block", Box(size), density=DENSITY[1], pose=at(top[0] + size[0] / 2, 0, size[2] / 2))
    return finished(rng, "leaning", [heavy, plank], rough=0.5)


def groove(rng: Generator) -> Scene:
    """A box with its lower edge in the right-angled groove between two fixed wedges of different slopes."""
    tilt = np.radians(rng.uniform(30, 60))
    high, wide, depth = rng.uniform(0.06, 0.15, 3)
    bottom, reach = 0.03, 0.3
    left, right = -reach * np.cos(tilt), reach * np.sin(tilt)
    slopes = {
        "left": [(left, 0), (0, 0), (0, bottom), (left, bottom + reach * np.sin(tilt))],
        "right": [(0, 0), (right, 0), (right, bottom + reach * np.cos(tilt)), (0, bottom)],
    }
    wedges = [prism(name, np.array(outline), 0.2, 1, fixed=True) for name, outline in slopes.items()]
    # one side of the box lies along each slope
    up_left, up_right = np.array([-np.cos(tilt), np.sin(tilt)]), np.array([np.sin(tilt), np.cos(tilt)])
    x, z = wide / 2 * up_left + high / 2 * up_right
    pose = at(x, 0, bottom + z, about_y(tilt))
    held = Body("box", Box((wide, depth, high)), density=density(rng), pose=pose)
    return finished(rng, "groove", [*wedges, held])


def bridge(rng: Generator) -> Scene:
    """A plank on two piers of one height, with a box somewhere on it."""
    length, width, thick = rng.uniform((0.3, 0.08, 0.01), (0.6, 0.15, 0.03))
    height = rng.uniform(0.08, 0.25)
    piers = [
        resting(
            rng, name, (*rng.uniform((0.05, 0.08), (0.1, 0.15)), height), (sign * length * rng.uniform(0.3, 0.4), 0, 0)
        )
        for name, sign in (("left", -1), ("right", 1))
    ]
    plank = resting(rng, "plank", (length, width, thick), (0, 0, height))
    place = (rng.uniform(-0.25, 0.25) * length, 0, height + thick)
    load = resting(rng, "load", rng.uniform(0.04, 0.08, 3), place, rng.uniform(-30, 30))
    return finished(rng, "bridge", [*piers, plank, load])


def shelf(rng: Generator) -> Scene:
    """A fixed board with two books on each other, a carton with a can on it, and a vase."""
    high = 0.4
    board = Body("board", Box((0.9, 0.3, 0.02)), pose=at(0, 0, high - 0.01), fixed=True)
    book, carton = (rng.uniform((0.15, 0.15, 0.02), (0.22, 0.22, 0.05)) for _ in range(2))
    x, y = rng.uniform(-0.03, 0.03, 2)
    bodies = [
        board,
        resting(rng, "book1", book, (-0.25, 0, high)),
        resting(rng, "book2", 0.9 * book, (x - 0.25, y, high + book[2]), rng.uniform(-20, 20)),
        resting(rng, "carton", carton, (0.05, 0, high), rng.uniform(-10, 10)),
        can(rng, "can", rng.uniform(0.02, 0.04), rng.uniform(0.05, 0.12), (x + 0.05, y, high + carton[2])),
        can(rng, "vase", rng.uniform(0.03, 0.06), rng.uniform(0.1, 0.25), (0.3, y, high)),
    ]
    return finished(rng, "shelf", bodies)


def cans(rng: Generator) -> Scene:
    """Two or three cylinders on each other, each off the middle of the one below."""
    bodies: list[Body] = []
    level = 0.0
    for k in range(int(rng.integers(2, 4))):
        radius, height = rng.uniform((0.04, 0.05), (0.08, 0.15))
        x, y = rng.uniform(-0.012, 0.012, 2)
        bodies.append(can(rng, f"can{k + 1}", radius, height, (x, y, level)))
        level += height
    return finished(rng, "cans", bodies)


def cantilever(rng: Generator) -> Scene:
    """A plank that overhangs a column, with a load on its far end and a counterweight that just balances them."""
    side, height, length = rng.uniform((0.08, 0.1, 0.35), (0.14, 0.3, 0.55))
    width, thick = side, rng.uniform(0.015, 0.03)
    plank, load = rng.uniform((0.3, 0.2), (1.5, 0.8))
    middle, far, near = 0.1 * length, 0.5 * length, -0.25 * length
    aim = rng.uniform(-0.2, 0.2) * side  # offset of the common centre of mass from the axis of the column
    counter = (plank * (middle - aim) + load * (far - aim)) / (aim - near)
    level = height + thick
    bodies = [
        resting(rng, "column", (side, side, height), (0, 0, 0)),
        Body("plank", Box((length, width, thick)), mass=plank, pose=at(middle, 0, height + thick / 2)),
        Body("load", Box((0.05, 0.05, 0.05)), mass=load, pose=at(far, 0, level + 0.025)),
        Body("counter", Box((0.08, 0.08, 0.08)), mass=counter, pose=at(near, 0, level + 0.04)),
    ]
    return finished(rng, "cantilever", bodies)


def row(rng: Generator) -> Scene:
    """Two to four unlike boxes side by side that touch."""
    bodies: list[Body] = []
    left = -0.3
    for k in range(int(rng.integers(2, 5))):
        size = rng.uniform(0.05, 0.2, 3)
        bodies.append(resting(rng, f"box{k + 1}", size, (left + size[0] / 2, rng.uniform(-0.02, 0.02), 0)))
        left += size[0]
    return finished(rng, "row", bodies)


def hull(rng: Generator) -> Scene:
    """The convex hull of random points, on the face nearest to its centre of mass: there it always stands."""
    points = rng.normal(size=(14, 3))
    points *= rng.uniform(0.05, 0.12, 3) / np.linalg.norm(points, axis=1)[:, None]
    found = ConvexHull(points)
    shape = Mesh(points, found.simplices)
    com = shape.mass_properties.com
    down = found.equations[np.argmax(found.equations @ np.append(com, 1)), :3]
    first, second = tangents(down)
    pose = np.eye(4)
    pose[:3, :3] = second, first, -down
    lowest = (points @ pose[:3, :3].T)[:, 2].min()
    pose[2, 3] = -lowest
    return finished(rng, "hull", [Body("hull", shape, density=density(rng), pose=pose)])


FAMILIES: Mapping[str, Family] = MappingProxyType(
    {
        family.__name__: family
        for family in (
            block,
            tower,
            table,
            pyramid,
            wall,
            arch,
            leaning,
            groove,
            bridge,
            shelf,
            cans,
            cantilever,
            row,
            hull,
        )
    }
)


def standing(family: Family, rng: Generator) -> Assembly:
    """Draw scenes of a family until engine ``limit`` says that one stands, and return its assembly.

    Raises HoldfastError if none of many draws stands.
    """
    for _ in range(TRIES):
        assembly = assemble(family(rng))
        if Limit().prepare(assembly).verdict().status is Status.STABLE:
            return assembly
    problem = f"none of {TRIES} draws stands"
    raise HoldfastError(message(f"family {family.__name__!r}", problem, "make most of its scenes stand"))


def with_ball(scene: Scene, rng: Generator) -> Scene:
    """Return the scene with a ball on the floor, beside everything else; it touches nothing but the floor."""
    radius = rng.uniform(0.02, 0.06)
    pose = _on_floor(scene, rng.uniform(0.75, 0.9), 0, radius)
    return scene.with_body(Body("ball", Sphere(radius), density=density(rng), pose=pose))


def with_ball_against(scene: Scene, rng: Generator) -> Scene:
    """Return the scene with a ball on the floor that touches the first body on its way to the middle.

    If nothing is in its way, it rests in the middle.
    """
    radius = rng.uniform(0.02, 0.06)
    way = rng.uniform(0, 2 * np.pi)
    towards = -np.array([np.cos(way), np.sin(way), 0.0])
    start = np.eye(4)
    start[:3, 3] = (0, 0, radius) - ACROSS * towards
    ball = Body("rolling", Sphere(radius), density=density(rng), pose=start)
    reach = min((first_hit(ball.surface_world, body.surface_world, towards) for body in scene.movable), default=np.inf)
    far = start.copy()
    far[:3, 3] += min(reach, ACROSS) * towards
    return scene.with_body(ball.moved(far))


def with_floating(scene: Scene, rng: Generator) -> Scene:
    """Return the scene with a box that hangs in the air, beside everything else."""
    size = rng.uniform(0.03, 0.1, 3)
    pose = _on_floor(scene, 0, rng.uniform(0.75, 0.9), rng.uniform(0.1, 0.3))
    return scene.with_body(Body("floating", Box(size), density=density(rng), pose=pose))


def with_falling(scene: Scene, rng: Generator) -> Scene:
    """Return the scene with a box that falls off the edge of the floor: its centre of mass lies beyond the edge."""
    size = rng.uniform(0.03, 0.1, 3)
    pose = _on_floor(scene, -ACROSS / 2 - rng.uniform(0.1, 0.4) * size[0], 0, size[2] / 2)
    return scene.with_body(Body("falling", Box(size), density=density(rng), pose=pose))


def with_frictionless_pair(scene: Scene, rng: Generator) -> Scene:
    """Return the scene without friction between two of its touching bodies, drawn at random; it may fall now.

    Raises HoldfastError if nothing touches.
    """
    touching = [interface.bodies for interface in assemble(scene).interfaces]
    if not touching:
        raise HoldfastError(message(f"scene {scene.name!r}", "no two bodies touch", "give one with contacts"))
    first, second = sorted(touching[int(rng.integers(len(touching)))])
    pairs = {**scene.friction.pairs, (first, second): 0.0}
    return replace(scene, friction=replace(scene.friction, pairs=pairs))


def _on_floor(scene: Scene, x: float, y: float, z: float) -> Float:
    """Return the pose (4, 4) at ``x`` and ``y`` [m] along the sides of the floor and ``z`` above it.

    All families keep within 0.65 m of the middle of the floor.
    """
    return np.asarray(scene.body("floor").pose @ at(x, y, z - floor().pose[2, 3]))
