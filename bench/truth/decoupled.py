"""Hand-derived decoupled truth of normal pushes on three scenes: cube, stack, table.

"Decoupled" is the reasoning of Nadeau & Kelly (arXiv 2411.09810, Sec. V and VI-A4): R = min(R_slip, R_top),
slipping and toppling examined apart, contact pressure from the minimum-energy distribution. They print no values;
here they are derived again. It is a truth about their method, not about cubes and tables: how far it is wrong as
physics is told in bench/notes/table1.md.

Cuts and axes are not enumerated here: each formula belongs to the mechanism that was found to govern on paper. The
tests compare it with an evaluator that enumerates all of them on 200 x 200 cells a rectangle (tests/closed_form).
On 2,000 random pushes a scene the two differ by 1e-5 at most, the error of its torsion levers. SI units, z up,
floor top at z = 0, g = 9.81 m/s2. Faces in contact have values as well, as if one could push there.

Scenes: a cube of side L = 0.1 and 1 kg, mu 0.6; three of them, cube1 at the bottom; a slab 0.5 x 0.2 x 0.05 of 2 kg
at z = 0.225 on two legs 0.05 x 0.2 x 0.2 of 1 kg at x = -+0.175, mu 0.5.

**Rules**

- Forces: least sum |f|^2 in equilibrium. On one rectangle with a load N through its centre that is the pressure
  N / A without friction (Cauchy-Schwarz), and by symmetry the legs share the slab equally. N [N] is 29.43, 19.62, 9.81
  under the cubes of the stack, 9.81 between slab and leg, 19.62 between leg and floor.
- Slip: the maximum flow from the pushed body to the floor. An arc from a to b carries mu N for level e, without
  bound where b is pressed, and N where it is pulled off. It is one arc for each direction, in the frame of the
  receiving body: "minimum traction of the two objects" would make pressing on a cube finite.
- Topple: a set S of bodies turns about an axis through o along a, R = torque / ((p - o) x e)·a. All S that contain
  the pushed body, are connected and leave the rest connected; all axes in both senses. About an edge of the convex
  hull of the cut interfaces every point must open, and the torque is the moment of the contact forces. About the
  upright axis through the centre of friction, or an upright hull edge, every point slides, and the torque is mu N
  times the mean distance from the axis, its lever. Hull edges are those in three dimensions; taken in the plane of
  each joint only, the leg faces would have min(14.715, 0.78047 / |y|) and the leg ends 14.715.
- Levers: the integral of the distance over [0, a] x [0, b] with D = sqrt(a^2 + b^2) is
  a b D / 3 + (a^3 asinh(b / a) + b^3 asinh(a / b)) / 6. Cube about its centre r_c = L / 6 (sqrt 2 + ln(1 + sqrt 2))
  = 0.0382597858; a leg's end about a corner r_l = 0.1060779397; both leg tops about the middle r_s = 0.1841549028.
  The paper's 20 sampled points are usually off by several per cent there; the value here is the integral.

**Cube and stack.** The sets to examine are "cube k and all above it", k not above the pushed cube i. With
N_i = (4 - i) m g under cube i, W the whole weight, t the horizontal distance of the push from the middle of its
face, z its height:

    sides          min( mu N_i,  mu N_i r_c / |t|,  W L / (2 z) )
    tops           inf: unbounded flow, and the force acts inside all hull edges
    undersides     N_i (L / 2) / (L / 2 + max(|x|, |y|))

The whole pile topples, since the set from cube k up needs (4 - k) m g L / 2 / (z - (k - 1) L), least for k = 1.

**Table**, sets {slab}, {leg}, {slab, one leg}, all; x and y stand for |x| and |y|:

    slab top       inf up to x = 0.2; beyond, over the outer top edge of the leg, 9.81 (0.025 + 0.375) / (x - 0.2)
    slab below     19.62 min(0.2 / (0.2 + x), 0.1 / (0.1 + y)): over its far end or a long side
    slab ends      9.81: slip on both leg tops; all else needs 16.7 or more
    slab sides     9.81 min(1, r_s / x): slip, then torsion about the middle
    leg faces      min(14.715, 0.5 * 29.43 r_l / (0.1 + y)): slip on floor (9.81) and slab (4.905), then torsion about
                   the upright edge farther from the push. A leg between floor and slab turns about no level axis;
                   about its middle the torque is half as large, but the lever y <= (0.1 + y) / 2 at most half as long
    leg ends       min(14.715, 29.43 * 0.1 * 0.35 / (0.35 z + 0.2 (x - 0.15))): slip, or {slab, leg} about the slanted
                   hull edge from the inner foot of this leg to the outer top of the other, run 0.35, rise 0.2
    leg top, foot  pressed inf; lifted with the slab min(7.60275 / (0.2 + x), 2.943 / (0.1 + y)), where 7.60275 =
                   19.62 * 0.375 + 9.81 * 0.025 is the moment about the outer top edge of the other leg

Eq. 24 of the paper leaves the direction of a sliding point's torque open: by virtual power it is R_slip(p, -v/|v|)
|v|.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import asinh, hypot, log, sqrt
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import Bool, Float, Int, checked_pushes
from holdfast.base.errors import SceneError, message
from holdfast.scene.shapes import Box

WHERE = "decoupled truth"
SAME = 1e-9  # [m, kg, m/s2] largest difference of a scene from the derived one

GRAVITY = 9.81  # [m/s2]
ON_FACE = 1e-6  # how far a point may lie off the face its normal names [m]

CUBE_SIDE = 0.1  # [m]
CUBE_WEIGHT = 1.0 * GRAVITY  # [N]
CUBE_MU = 0.6
STACK = ("cube1", "cube2", "cube3")  # bottom to top

TABLE_MU = 0.5
TABLE_SIZE = {"slab": (0.5, 0.2, 0.05), "leg_left": (0.05, 0.2, 0.2), "leg_right": (0.05, 0.2, 0.2)}  # [m]
TABLE_CENTRE = {"slab": (0.0, 0.0, 0.225), "leg_left": (-0.175, 0.0, 0.1), "leg_right": (0.175, 0.0, 0.1)}  # [m]
SCENES = {"cube": ("cube",), "stack": STACK, "table": tuple(TABLE_SIZE)}  # the bodies of each
LEG_INNER, LEG_OUTER = 0.15, 0.2  # |x| of the two faces of a leg [m]
LEG_HEIGHT = 0.2  # [m]
HALF_DEPTH = 0.1  # half the common y extent of slab and legs [m]
SLAB_WEIGHT = 2.0 * GRAVITY  # [N]
LEG_WEIGHT = 1.0 * GRAVITY  # [N]
ON_LEG = SLAB_WEIGHT / 2  # force between the slab and one leg [N]
ON_FLOOR = ON_LEG + LEG_WEIGHT  # force between one leg and the floor [N]


def robustness(
    scene: str | Assembly,
    body: str,
    points: Any,  # noqa: ANN401 - (n, 3) or (3,) numbers, checked
    directions: Any,  # noqa: ANN401 - (n, 3) or (3,) numbers, checked
) -> Float:
    """The decoupled robustness (n,) [N] of ``body`` to pushes at ``points`` (n, 3) [m] straight into its faces.

    Infinite where no push moves anything. ``scene``: "cube", "stack" or "table", or an assembly of one of these shipped
    scenes; anything else raises SceneError.
    """
    p, e = checked_pushes(points, directions, f"{WHERE} of {body!r}")
    name = recognised(scene) if isinstance(scene, Assembly) else scene
    if name not in SCENES:
        raise SceneError(message(WHERE, f"scene {name!r} was not worked out by hand", f"known: {', '.join(SCENES)}"))
    _named([body], body, SCENES[name])
    if name == "cube":
        return truth_cube(p, -e)
    return (truth_stack if name == "stack" else truth_table)(p, -e, [body] * len(p))


def recognised(assembly: Assembly) -> str:
    """Return which hand-derived scene an assembly is, "cube", "stack" or "table"; raise SceneError if it is none."""
    cube = (CUBE_SIDE,) * 3
    level = CUBE_SIDE / 2
    known = {
        scene: (CUBE_MU, {name: (cube, (0.0, 0.0, level + k * CUBE_SIDE), 1.0) for k, name in enumerate(SCENES[scene])})
        for scene in ("cube", "stack")
    }
    weights = {"slab": SLAB_WEIGHT, "leg_left": LEG_WEIGHT, "leg_right": LEG_WEIGHT}
    table = {name: (size, TABLE_CENTRE[name], weights[name] / GRAVITY) for name, size in TABLE_SIZE.items()}
    known["table"] = (TABLE_MU, table)
    level_gravity = np.allclose(assembly.scene.gravity, (0, 0, -GRAVITY), rtol=0, atol=SAME)
    for scene, (mu, boxes) in known.items():
        bodies = assembly.movable
        if {body.name for body in bodies} != set(boxes) or not level_gravity:
            continue
        if not np.allclose(assembly.mu, mu, rtol=0, atol=SAME):
            continue
        if all(_is_box(assembly, body.name, *boxes[body.name]) for body in bodies):
            return scene
    names = ", ".join(repr(body.name) for body in assembly.movable[:5])
    problem = f"the scene of {names} is not one that was worked out by hand"
    raise SceneError(message(WHERE, problem, "needs the shipped scene cube, stack or table"))


def _is_box(assembly: Assembly, name: str, size: tuple[float, ...], centre: tuple[float, ...], mass: float) -> bool:
    body = assembly.scene.body(name)
    assert body.mass is not None
    pose = np.eye(4)
    pose[:3, 3] = centre
    return (
        isinstance(body.shape, Box)
        and np.allclose(body.shape.size, size, rtol=0, atol=SAME)
        and np.allclose(body.pose, pose, rtol=0, atol=SAME)
        and np.allclose(body.com_world, centre, rtol=0, atol=SAME)
        and abs(body.mass - mass) <= SAME
    )


def distance_integral(a: float, b: float) -> float:
    """Integral of sqrt(x^2 + y^2) over [0, a] x [0, b] [m3]: a b D / 3 + (a^3 asinh(b/a) + b^3 asinh(a/b)) / 6."""
    return a * b * hypot(a, b) / 3 + (a**3 * asinh(b / a) + b**3 * asinh(a / b)) / 6


# Mean distance to the torsion axis, "lever of friction" [m]: torsion capacity = mu N lever.
CUBE_LEVER = CUBE_SIDE / 6 * (sqrt(2) + log(1 + sqrt(2)))  # a square about its own centre
LEG_LEVER = distance_integral(0.05, 2 * HALF_DEPTH) / (0.05 * 2 * HALF_DEPTH)  # a leg's end about one of its corners
SLAB_LEVER = (  # both leg tops about the middle of the table
    distance_integral(LEG_OUTER, HALF_DEPTH) - distance_integral(LEG_INNER, HALF_DEPTH)
) / ((LEG_OUTER - LEG_INNER) * HALF_DEPTH)


def truth_cube(points: ArrayLike, normals: ArrayLike) -> Float:
    """Decoupled robustness [N] of the cube (0.1 m, 1 kg, mu 0.6, on the floor) to pushes along -normals.

    ``points`` (n, 3) [m] on its faces, ``normals`` (n, 3) outward; returns (n,), inf where nothing moves it.
    """
    p = np.asarray(points, dtype=np.float64).reshape(-1, 3)
    axis, sign = _face(p, normals, (0.0, 0.0, CUBE_SIDE / 2), (CUBE_SIDE,) * 3)
    return _pile(p, axis, sign, borne=np.full(len(p), CUBE_WEIGHT), pile=CUBE_WEIGHT)


def truth_stack(points: ArrayLike, normals: ArrayLike, body: Sequence[str]) -> Float:
    """Decoupled robustness [N] of the stack of three such cubes to pushes on the cubes named in ``body`` (n,).

    ``points`` (n, 3) [m] on the faces of those cubes, ``normals`` (n, 3) outward; returns (n,), inf where nothing
    moves.
    """
    p = np.asarray(points, dtype=np.float64).reshape(-1, 3)
    result = np.empty(len(p))
    for level, name in enumerate(STACK):
        here = _named(body, name, STACK)
        centre = (0.0, 0.0, (level + 0.5) * CUBE_SIDE)
        axis, sign = _face(p[here], np.asarray(normals)[here], centre, (CUBE_SIDE,) * 3)
        borne = np.full(int(here.sum()), (len(STACK) - level) * CUBE_WEIGHT)
        result[here] = _pile(p[here], axis, sign, borne=borne, pile=len(STACK) * CUBE_WEIGHT)
    return result


def truth_table(points: ArrayLike, normals: ArrayLike, body: Sequence[str]) -> Float:
    """Decoupled robustness [N] of the table to pushes on ``body`` (n,): "slab", "leg_left" or "leg_right".

    ``points`` (n, 3) [m] on the faces of those bodies, ``normals`` (n, 3) outward; returns (n,), inf where nothing
    moves.
    """
    p = np.asarray(points, dtype=np.float64).reshape(-1, 3)
    result = np.empty(len(p))
    for name, size in TABLE_SIZE.items():
        here = _named(body, name, tuple(TABLE_SIZE))
        axis, sign = _face(p[here], np.asarray(normals)[here], TABLE_CENTRE[name], size)
        result[here] = _slab(p[here], axis, sign) if name == "slab" else _leg(p[here], axis, sign)
    return result


def _pile(p: Float, axis: Int, sign: Float, *, borne: Float, pile: float) -> Float:
    """Pushes on a cube of a pile: ``borne`` (n,) is the weight on its underside, ``pile`` that of the whole pile."""
    across = np.where(axis == 0, np.abs(p[:, 1]), np.abs(p[:, 0]))
    twist = CUBE_MU * borne / np.maximum(across / CUBE_LEVER, 1.0)  # mu N min(1, lever / across): slip or torsion
    with np.errstate(divide="ignore"):
        tip = pile * CUBE_SIDE / 2 / p[:, 2]  # the whole pile over its front edge on the floor
    lift = borne * (CUBE_SIDE / 2) / (CUBE_SIDE / 2 + np.maximum(np.abs(p[:, 0]), np.abs(p[:, 1])))
    vertical = np.where(sign > 0, np.inf, lift)
    result: Float = np.where(axis == 2, vertical, np.minimum(twist, tip))
    return result


def _slab(p: Float, axis: Int, sign: Float) -> Float:
    """Pushes on the slab: down on its overhang, up from below, along x at an end, along y at a long side."""
    x, y = np.abs(p[:, 0]), np.abs(p[:, 1])
    with np.errstate(divide="ignore"):
        press = np.where(x > LEG_OUTER, SLAB_WEIGHT * LEG_OUTER / np.maximum(x - LEG_OUTER, 0.0), np.inf)
    lift = SLAB_WEIGHT * np.minimum(LEG_OUTER / (LEG_OUTER + x), HALF_DEPTH / (HALF_DEPTH + y))
    end = np.full(len(p), TABLE_MU * SLAB_WEIGHT)
    side = TABLE_MU * SLAB_WEIGHT / np.maximum(x / SLAB_LEVER, 1.0)
    return np.select([axis == 0, axis == 1, sign > 0], [end, side, press], lift)


def _leg(p: Float, axis: Int, sign: Float) -> Float:
    """Pushes on a leg: along x, which twists it between slab and floor; along y; or upwards together with the slab."""
    x, y, z = np.abs(p[:, 0]), np.abs(p[:, 1]), p[:, 2]
    slip = TABLE_MU * (ON_FLOOR + ON_LEG)
    # About the upright edge farther from the push. Turning about the leg's own middle is never easier: the mean
    # distance to the middle is half that to a corner, but the lever |y| is less than half of |y| + 0.1.
    face = slip / np.maximum((HALF_DEPTH + y) / LEG_LEVER, 1.0)
    # The leg and the slab roll about the line from the leg's inner foot to the far leg's outer top, in the plane
    # y = +-0.1: run 0.35, rise 0.2. x is counted outwards from the middle of the table, z from the floor.
    run, rise = LEG_INNER + LEG_OUTER, LEG_HEIGHT
    with np.errstate(divide="ignore"):
        roll = (ON_FLOOR + ON_LEG) * HALF_DEPTH * run / (run * z + rise * (x - LEG_INNER))
    end = np.minimum(slip, roll)
    over_far_leg = ON_FLOOR * (LEG_OUTER + 0.175) + ON_LEG * 0.025  # [N m] moment about the far leg's outer top edge
    sideways = (ON_FLOOR + ON_LEG) * HALF_DEPTH
    lift = np.minimum(over_far_leg / (LEG_OUTER + x), sideways / (HALF_DEPTH + y))
    vertical = np.where(sign > 0, np.inf, lift)
    return np.select([axis == 0, axis == 1], [face, end], vertical)


def _named(body: Sequence[str], name: str, known: tuple[str, ...]) -> Bool:
    """Mask (n,) of the queries on ``name``; refuses names that are not in ``known``."""
    names = np.asarray(body)
    strange = sorted(set(names.tolist()) - set(known))
    if strange:
        raise SceneError(message(WHERE, f"body {strange[0]!r} is not in this scene", f"it has {', '.join(known)}"))
    mask: Bool = names == name
    return mask


def _face(p: Float, normals: ArrayLike, centre: tuple[float, ...], size: tuple[float, ...]) -> tuple[Int, Float]:
    """Which box face each (point, outward normal) is on: its axis (n,) in 0..2 and its sign (n,)."""
    n = np.asarray(normals, dtype=np.float64).reshape(-1, 3)
    rows = np.arange(len(n))
    axis = np.abs(n).argmax(axis=1)
    sign = np.sign(n[rows, axis])
    off_axis = np.abs(n - sign[:, None] * np.eye(3)[axis]).max(axis=1, initial=0.0)
    local, half = p - np.asarray(centre), np.asarray(size) / 2
    off_face = np.abs(local[rows, axis] - sign * half[axis])
    outside = (np.abs(local) - half).max(axis=1, initial=-np.inf)
    wrong = (off_axis > ON_FACE) | (off_face > ON_FACE) | (outside > ON_FACE)
    if wrong.any():
        i = int(wrong.argmax())
        problem = f"point {p[i]} with outward normal {n[i]} is not on a face of the box at {centre}"
        raise SceneError(message(f"{WHERE}: push {i}", problem, "needs pushes straight into a face"))
    return axis, sign
