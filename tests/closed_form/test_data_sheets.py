"""From data sheets of suction cups and two-finger grippers to newtons and m/s², beside formulas by hand."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import holdfast as hf

G = 9.81
LIMIT = "limit"
SIDE = 0.1  # [m] of the box under the cup
WIDTH, PAD = 0.04, 0.02  # [m] of the part between the fingers, of their square pads


def under(force: float, radius: float, mu: float, mass: float) -> hf.Scene:
    """A box under a suction cup whose face is at z = 1."""
    box = hf.Body("box", hf.Box((SIDE,) * 3), mass=mass, position=(0, 0, 1 - SIDE / 2))
    cup = hf.Grip.suction("box", hf.pose(0, 0, 1), force, radius, mu)
    return hf.Scene([hf.Body("floor", hf.HalfSpace(), fixed=True), box], 0.5, holds=[cup])


def push(scene: hf.Scene, body: str, point: tuple[float, ...], along: tuple[float, ...]) -> float:
    """The largest push, whose two bounds agree."""
    found = hf.robustness(scene, body, point, along, engine=LIMIT)
    assert found.lower[0] == pytest.approx(found.upper[0], rel=1e-6)
    return float(found.lower[0])


CUPS = [  # vacuum [Pa], diameter [m], friction, mass [kg], safety factor
    pytest.param(60e3, 0.04, 0.5, 0.8, 2.0, id="it peels before it slides"),
    pytest.param(70e3, 0.05, 0.2, 1.5, 1.5, id="it slides before it peels"),
]


@pytest.mark.parametrize(("vacuum", "diameter", "mu", "mass", "safety"), CUPS)
def test_a_cup_from_above(vacuum: float, diameter: float, mu: float, mass: float, safety: float) -> None:
    force, radius = vacuum * math.pi * diameter**2 / 4 / safety, diameter / 2
    scene, left = under(force, radius, mu, mass), force - mass * G
    assert push(scene, "box", (0, 0, 1 - SIDE), (0, 0, -1)) == pytest.approx(left, rel=1e-6)
    aside = 0.03
    edge = left * radius / (radius + aside)  # moments about the far edge of the seal
    assert push(scene, "box", (aside, 0, 1 - SIDE), (0, 0, -1)) == pytest.approx(edge, rel=1e-6)
    depth = SIDE / 2
    level = min(mu, radius / depth) * left
    assert push(scene, "box", (-SIDE / 2, 0, 1 - depth), (1, 0, 0)) == pytest.approx(level, rel=1e-6)
    assert push(scene, "box", (-SIDE / 2, 0, 1), (1, 0, 0)) == pytest.approx(mu * left, rel=1e-6)
    limits = hf.transport_limits(scene, [(1, 0, 0), (0, 0, 1)], engine=LIMIT)
    assert limits.lower == pytest.approx([level / mass, left / mass], rel=1e-6)
    # as data sheets have it: F = m (g + a) S upwards, and m (g + a / mu) S sideways, which knows no peeling
    assert force * safety == pytest.approx(mass * (G + limits.lower[1]) * safety, rel=1e-6)
    assert force * safety >= mass * (G + limits.lower[0] / mu) * safety * (1 - 1e-6)


def test_the_seal_is_a_polygon_of_16_sides_within_it() -> None:
    limits = hf.transport_limits(under(37.7, 0.02, 0.5, 0.8), engine=LIMIT).lower  # 100 level directions
    left = (37.7 - 0.8 * G) * 0.02 / (SIDE / 2) / 0.8
    assert limits.max() == pytest.approx(left, rel=1e-6)
    assert limits.min() == pytest.approx(left * math.cos(math.pi / 16), rel=1e-3)
    assert limits.min() >= left * math.cos(math.pi / 16) * (1 - 1e-6)


def test_a_cup_on_a_wall_slides_or_peels() -> None:
    force, radius, mu, mass = 60.0, 0.03, 0.4, 0.7
    outward = hf.pose(0.05, 0, 1, pitch=90)  # z of the frame along the world's x
    for depth in (0.02, 0.2):  # it slides, it peels
        box = hf.Body("box", hf.Box((depth, 0.1, 0.1)), mass=mass, position=(0.05 - depth / 2, 0, 1))
        cup = hf.Grip.suction("box", outward, force, radius, mu)
        scene = hf.Scene([hf.Body("floor", hf.HalfSpace(), fixed=True), box], 0.5, holds=[cup])
        limits = hf.transport_limits(scene, [(0, 0, 1)], engine=LIMIT)
        # its seal is horizontal at its lowest and highest points, so the polygon has vertices there
        assert limits.lower[0] == pytest.approx(min(mu, radius / (depth / 2)) * force / mass - G, rel=1e-6)


def test_a_cup_bears_a_moment_about_its_axis() -> None:
    force, radius, mu, mass = 50.0, 0.025, 0.3, 0.5
    twist = hf.load_factor(under(force, radius, mu, mass), [hf.Load("box", moment=(0, 0, 1))], engine=LIMIT)
    assert float(twist.lower) == pytest.approx(mu * (force - mass * G) * radius, rel=1e-6)


def test_a_cup_in_a_scene_file_is_that_of_python(tmp_path: Path) -> None:
    page = Path(__file__).parents[2] / "docs" / "howto" / "held_by_hands.md"
    (line,) = [line.strip() for line in page.read_text(encoding="utf-8").splitlines() if "type: suction" in line]
    bodies = (
        "  - {name: floor, shape: {type: halfspace}, fixed: true}\n"
        "  - {name: cup, shape: {type: cylinder, radius: 0.04, height: 0.1}, mass: 0.3, position: [0, 0, 1]}\n"
    )
    text = f"format: holdfast-scene/1\nfriction: 0.5\nbodies:\n{bodies}holds:\n  {line}\n"
    (tmp_path / "held.yaml").write_text(text)
    read = hf.load_scene(tmp_path / "held.yaml")
    assert read.holds == (hf.Grip.suction("cup", hf.pose(0, 0, 1.05), force=40, radius=0.02, mu=0.5),)
    assert push(read, "cup", (0, 0, 0.95), (0, 0, -1)) == pytest.approx(40 - 0.3 * G, rel=1e-6)
    hf.save_scene(read, tmp_path / "again.yaml")
    assert hf.load_scene(tmp_path / "again.yaml") == read
    (tmp_path / "held.yaml").write_text(text.replace("radius: 0.02", "radius: 0"))
    with pytest.raises(hf.HoldfastError, match="suction cup on 'cup': radius"):
        hf.load_scene(tmp_path / "held.yaml")


def between(force: float, mu: float, mass: float, aside: float = 0.0) -> hf.Scene:
    """A part between two fingers, with a point in each quarter of a pad, its centre ``aside`` of them along y."""
    q = PAD / 4
    pads = [(x, y, 1 + z) for x in (-WIDTH / 2, WIDTH / 2) for y in (-q, q) for z in (-q, q)]
    fingers = hf.Grip("part", pads, [(-x, 0, 0) for x, _, _ in pads], mu, force / 4)
    part = hf.Body("part", hf.Box((WIDTH, 0.06, 0.08)), mass=mass, position=(0, aside, 1))
    return hf.Scene([hf.Body("floor", hf.HalfSpace(), fixed=True), part], 0.5, holds=[fingers])


@pytest.mark.parametrize(("grip", "mu", "mass", "safety"), [(40.0, 0.4, 0.5, 2.0), (60.0, 0.15, 0.8, 1.5)])
def test_two_fingers_in_the_middle(grip: float, mu: float, mass: float, safety: float) -> None:
    force = grip / safety
    scene, carried = between(force, mu, mass), 2 * mu * force
    assert push(scene, "part", (0, 0, 0.96), (0, 0, -1)) == pytest.approx(carried - mass * G, rel=1e-6)
    limits = hf.transport_limits(scene, [(0, 1, 0), (0, 0, 1), (1, 0, 0)], engine=LIMIT).lower
    along = math.sqrt(carried**2 - (mass * G) ** 2) / mass
    assert limits[:2] == pytest.approx([along, carried / mass - G], rel=1e-6)
    assert grip == pytest.approx(mass * (G + limits[1]) * safety / (2 * mu), rel=1e-6)  # as data sheets have it
    # along x one finger presses by F, the other by F - m a; each bears half of the weight, or friction all of it
    assert limits[2] >= (force - mass * G / (2 * mu)) / mass * (1 - 1e-6)
    assert limits[2] <= (2 * force - mass * G / mu) / mass * (1 + 1e-6)


def twisted(force: float, mu: float, aside: float) -> float:
    """The largest vertical load [N] at the distance ``aside`` [m]: the least over all centres of rotation on y.

    Each of the eight points resists by mu F / 4 against its own velocity, about the centre c: the load times
    |aside - c| is the sum of mu F / 4 times the distances (Goyal, Ruina, Papadopoulos: Planar sliding, 1991).
    """
    centre = -np.concatenate([[0.0], np.geomspace(1e-6, 100, 400_001)])[:, None]
    y, z = (PAD / 4 * np.array(signs) for signs in ((-1, 1) * 4, (-1, -1, 1, 1) * 2))
    return float((mu * force / 4 * np.hypot(y - centre, z).sum(1) / (aside - centre[:, 0])).min())


@pytest.mark.parametrize("aside", [0.002, 0.01, 0.02])
def test_held_aside_a_part_twists_on_its_pads(aside: float) -> None:
    force, mu, mass = 20.0, 0.4, 0.5
    most = twisted(force, mu, aside)
    limits = hf.transport_limits(between(force, mu, mass, aside), [(0, 0, 1)], engine=LIMIT)
    assert limits.lower[0] == pytest.approx(most / mass - G, abs=1e-5)


def test_points_in_the_quarters_of_a_pad_resist_less_twist_than_even_pressure_does() -> None:
    force, mu, mass = 20.0, 0.4, 0.5
    twist = hf.load_factor(between(force, mu, mass), [hf.Load("part", moment=(1, 0, 0))], engine=LIMIT)
    # of a square under even pressure: the mean distance from its centre is (sqrt(2) + asinh(1)) / 6 of its side
    even = 2 * mu * force * PAD * (math.sqrt(2) + math.asinh(1)) / 6
    assert 0.5 * even < float(twist.lower) < even
    bare = 2 * mu * force * PAD / 4 * math.sqrt(2)  # without the weight
    assert float(twist.upper) < bare
