"""Models like those of three public benchmarks, each with fifty start states whose verdicts are known beforehand."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
STABLE, UNSTABLE, UNDECIDED = "stable", "unstable", "undecided"
TABLE = 0.8  # [m] height of the top


class Benchmark(NamedTuple):
    """A model, its states (50, 1 + nq + nv), the verdict on each, and words that the reason or the faults must have."""

    xml: str
    states: Floats
    verdicts: list[str]
    words: dict[int, str]


def arm(x: float) -> str:
    """A robot of seven hinges and two fingers, which motors hold."""
    text = f'<body name="base" pos="{x} 0 {TABLE}"><geom type="cylinder" size=".06 .05" pos="0 0 .05"/>'
    for k in range(1, 8):
        axis = "0 0 1" if k % 2 else "0 1 0"
        text += f'<body name="link{k}" pos="0 0 .1"><joint name="joint{k}" axis="{axis}" range="-2.9 2.9"/>'
        text += '<geom type="capsule" size=".04 .03" pos="0 0 .05" mass="1"/>'
    for name, side in (("left", 1), ("right", -1)):
        text += f'<body name="{name}" pos="0 {0.04 * side} .12"><joint name="{name}" type="slide" axis="0 {side} 0"/>'
        text += '<geom type="box" size=".01 .005 .03" mass=".02"/></body>'
    return text + "</body>" * 8


def model(objects: str, furniture: str) -> str:
    """A world with a robot, furniture and objects."""
    motors = "".join(f'<position joint="{name}"/>' for name in (*(f"joint{k}" for k in range(1, 8)), "left", "right"))
    return (
        '<mujoco><compiler angle="radian"/><default><geom friction="0.8"/></default><worldbody>'
        f'<geom name="floor" type="plane" size="3 3 .1"/>{furniture}{arm(-0.6)}{objects}</worldbody>'
        f"<actuator>{motors}</actuator></mujoco>"
    )


def freed(name: str, geoms: str) -> str:
    """An object as robosuite writes it: the geoms lie in a body within the body that moves."""
    return (
        f'<body name="{name}"><freejoint name="{name}"/><body name="{name}_object" pos="0 0 .001">{geoms}</body></body>'
    )


TABLE_TOP = f'<body name="table" pos="0 0 {TABLE - 0.02}"><geom type="box" size=".5 .5 .02"/></body>'
ARM = [0.1, -0.4, 0.2, -1.2, 0.1, 1.0, 0.3, 0.01, 0.01]  # positions of the robot
DOFS = 9


def filled(places: Floats, objects: int) -> Floats:
    """States of positions (n, objects, 3) of upright objects: time, robot, poses, velocities."""
    count = len(places)
    poses = np.zeros((count, objects, 7))
    poses[:, :, :3], poses[:, :, 3] = places - [0, 0, 0.001], 1.0  # geoms lie 1 mm above the frame of an object
    robot = ARM + 0.05 * np.random.default_rng(1).normal(size=(count, DOFS)) * ([1] * 7 + [0] * 2)
    return np.hstack([np.zeros((count, 1)), robot, poses.reshape(count, -1), np.zeros((count, DOFS + 6 * objects))])


def around(seed: int, centres: list[tuple[float, float, float]]) -> Floats:
    """Positions (50, objects, 3) up to 3 cm from these."""
    shift = np.random.default_rng(seed).uniform(-0.03, 0.03, (50, len(centres), 2))
    places = np.tile(np.array(centres), (50, 1, 1))
    places[:, :, :2] += shift
    return places


def kitchen() -> Benchmark:
    """A table with a plate, a bowl on it and a mug, as in LIBERO: in states 7 and 8 the bowl hangs 11 cm high."""
    walls = "".join(
        f'<geom type="box" size="{a} {b} .02" pos="{x} {y} .03"/>'
        for a, b, x, y in (
            (0.005, 0.05, 0.055, 0),
            (0.005, 0.05, -0.055, 0),
            (0.05, 0.005, 0, 0.055),
            (0.05, 0.005, 0, -0.055),
        )
    )
    bowl = freed("bowl", f'<geom type="box" size=".06 .06 .005" pos="0 0 .005"/>{walls}')
    plate = freed("plate", '<geom type="cylinder" size=".1 .01" pos="0 0 .01"/>')
    mug = freed(
        "mug",
        '<geom type="cylinder" size=".04 .05" pos="0 0 .05"/><geom type="box" size=".02 .005 .03" pos=".055 0 .05"/>',
    )
    places = around(2, [(0, 0, TABLE), (0, 0, TABLE + 0.02), (0.2, 0.2, TABLE)])
    places[:, 1, :2] = places[:, 0, :2]
    places[[7, 8], 1, 2] += 0.11
    places[20, 2, 2] -= 0.005
    places[30, 2, :2] = 0.52, 0.2  # over the edge by more than half
    verdicts = [STABLE] * 50
    verdicts[7] = verdicts[8] = verdicts[30] = UNSTABLE
    verdicts[20] = UNDECIDED
    words = {7: "bowl hovers 110 mm above plate", 20: "mug sinks 5 mm into table", 30: "mug"}
    return Benchmark(model(plate + bowl + mug, TABLE_TOP), filled(places, 3), verdicts, words)


def lifting() -> Benchmark:
    """A can, a cube and a pot with handles, as in robosuite: in state 3 the cube is over the can's edge."""
    can = freed("can", '<geom type="cylinder" size=".033 .06" pos="0 0 .06"/>')
    cube = freed("cube", '<geom type="box" size=".02 .02 .02" pos="0 0 .02"/>')
    handles = "".join(f'<geom type="box" size=".01 .03 .01" pos="{x} 0 .08"/>' for x in (0.09, -0.09))
    pot = freed("pot", f'<geom type="box" size=".08 .08 .05" pos="0 0 .05"/>{handles}')
    places = around(3, [(0, 0.2, TABLE), (0.1, 0, TABLE), (0.1, -0.25, TABLE)])
    places[25:, 1] = places[25:, 0] + [0, 0, 0.12]  # the cube on the can
    places[3, 1] = places[3, 0] + [0.04, 0, 0.12]
    places[4, 0, 2] += 0.3
    verdicts = [STABLE] * 50
    verdicts[3] = verdicts[4] = UNSTABLE
    return Benchmark(
        model(can + cube + pot, TABLE_TOP), filled(places, 3), verdicts, {3: "cube", 4: "can hovers 300 mm above table"}
    )


def shelf() -> Benchmark:
    """A shelf with boxes and a trash can, as in SIMPLE: in states 5 and 6 the can is partly inside the board."""
    boards = "".join(f'<geom type="box" size=".2 .4 .01" pos="0 0 {z}"/>' for z in (0.39, 0.79, 1.19))
    sides = "".join(f'<geom type="box" size=".2 .01 .6" pos="0 {y} .6"/>' for y in (0.41, -0.41))
    boxes = [freed(f"box{k}", '<geom type="box" size=".04 .06 .1" pos="0 0 .1"/>') for k in range(2)]
    trash = freed("trash", '<geom type="cylinder" size=".07 .1" pos="0 0 .1"/>')
    places = around(4, [(0.4, -0.2, 0.8), (0.4, 0.2, 0.8), (0.4, 0, 0.4)])
    places[[5, 6], 2, 2] -= 0.05
    places[9, 0, 0] = 0.4 - 0.24  # its middle beyond the edge
    verdicts = [STABLE] * 50
    verdicts[5] = verdicts[6] = UNDECIDED
    verdicts[9] = UNSTABLE
    furniture = f'<body name="shelf" pos=".4 0 0">{boards}{sides}</body>'
    return Benchmark(
        model("".join(boxes) + trash, furniture), filled(places, 3), verdicts, {5: "trash sinks", 9: "box0"}
    )


BENCHMARKS: dict[str, Callable[[], Benchmark]] = {"kitchen": kitchen, "lifting": lifting, "shelf": shelf}
