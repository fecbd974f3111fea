"""What falls whatever its sharp contacts carry is unstable; what can stand by them alone is undecided."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import holdfast as hf

ENGINES = ("limit", "compliant")
FLOOR = hf.Body("floor", hf.Box((6, 6, 0.2)), position=(0, 0, -0.1), fixed=True)
DOWN = np.array([0, 0, -9.81])


def box(name: str, size: Sequence[float], place: Sequence[float], **options: object) -> hf.Body:
    return hf.Body(name, hf.Box(tuple(size)), position=tuple(place), **{"mass": 1.0, **options})


def turned(bodies: list[hf.Body], seed: int, mu: float, gravity: np.ndarray = DOWN) -> hf.answers.Assembly:
    """The scene as a whole in a random pose; seed 0 is as given."""
    pose = np.eye(4)
    if seed:
        pose[:3, :3] = Rotation.random(random_state=seed).as_matrix()
        pose[:3, 3] = np.random.default_rng(seed).normal(size=3)
    moved = [body.moved(pose @ body.pose) for body in bodies]
    return hf.assemble(hf.Scene(moved, mu, gravity=pose[:3, :3] @ gravity))


def statuses(assembly: hf.answers.Assembly) -> set[hf.Status]:
    return {hf.stability(assembly, engine=engine).status for engine in ENGINES}


@pytest.mark.parametrize(("across", "deep", "layers"), [(1, 2, 1), (2, 2, 1), (3, 2, 1), (2, 2, 2), (4, 3, 1)])
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_cubes_in_a_grid_slide_where_gravity_leans_by_more_than_friction(
    across: int, deep: int, layers: int, seed: int
) -> None:
    """Closed form: all of them slide, or none. They are diagonal neighbours along whole edges, and at corners."""
    a, mu = 0.3, 0.5
    places = [(x * a, y * a, (z + 0.5) * a) for x in range(across) for y in range(deep) for z in range(layers)]
    cubes = [box(f"b{k}", (a, a, a), place, mass=5.0) for k, place in enumerate(places)]
    angle = 0.3 + seed
    for lean, expected in ((0.8, hf.Status.STABLE), (1.005, hf.Status.UNSTABLE), (3.0, hf.Status.UNSTABLE)):
        gravity = 9.81 * np.array([lean * mu * np.cos(angle), lean * mu * np.sin(angle), -1])
        assembly = turned([FLOOR, *cubes], seed, mu, gravity)
        assert statuses(assembly) == {expected}, lean


TALL = box("tall", (1, 1, 1), (0.5, 0.5, 0.5), mass=50)
LEDGE = box("ledge", (1, 1, 1), (0.5, 0.5, 1.5), fixed=True)
SMALL = (0.2, 0.2, 0.2)
IN_THE_AIR = {
    "a vertical edge": [TALL, box("small", SMALL, (1.1, 1.1, 0.6))],
    "a vertical edge up to the top of both": [TALL, box("small", SMALL, (1.1, 1.1, 0.9))],
    "a vertical edge, turned": [
        TALL,
        box("small", SMALL, 1 + 0.1 * np.sqrt(2) * np.array([np.cos(1.1), np.sin(1.1), -2]),
            rpy_degrees=(0, 0, np.degrees(1.1) - 45)),
    ],
    "a level edge below it": [TALL, box("small", SMALL, (1.1, 0.5, 1.1))],
    "a level edge above it": [LEDGE, box("small", SMALL, (1.1, 0.5, 0.9))],
    "a corner below it": [TALL, box("small", SMALL, (1.1, 1.1, 1.1))],
    "a corner above it": [LEDGE, box("small", SMALL, (1.1, 1.1, 0.9))],
    "two corners in a row": [
        box("below", SMALL, (0, 0, 0.1), fixed=True),
        box("small", SMALL, (0.2, 0.2, 0.3)),
        box("next", SMALL, (0.4, 0.4, 0.5)),
    ],
}  # fmt: skip


@pytest.mark.parametrize("seed", [0, 3])
@pytest.mark.parametrize("name", IN_THE_AIR)
def test_a_box_in_the_air_that_shares_an_edge_or_a_corner_falls(name: str, seed: int) -> None:
    """No force there can balance its weight and keep it from turning about the edge or the corner."""
    assembly = turned([FLOOR, *IN_THE_AIR[name]], seed, 0.5)
    found = hf.stability(assembly)
    assert statuses(assembly) == {hf.Status.UNSTABLE}
    assert "small" in found.moving
    assert found.certificate is not None
    assert found.certificate.power > 0


@pytest.mark.parametrize("seed", [0, 4])
@pytest.mark.parametrize(("offset", "expected"), [(0.0, hf.Status.UNDECIDED), (0.01, hf.Status.UNSTABLE)])
def test_a_ridge_on_a_ridge_may_stand_only_right_above_it(offset: float, expected: hf.Status, seed: int) -> None:
    up = 0.05 * np.sqrt(2)
    below = box("below", (0.1, 0.1, 0.1), (0, 0, up), rpy_degrees=(0, 45, 0), fixed=True)
    above = box("it", (0.1, 0.1, 0.1), (0, 0, 3 * up), rpy_degrees=(0, 45, 0), com=(offset, 0, 0))
    assert statuses(turned([below, above], seed, 0.5)) == {expected}


@pytest.mark.parametrize("seed", [0, 5])
@pytest.mark.parametrize("share", [0.5, 0.95, 1.05, 4.0])
def test_cards_that_lean_edge_to_edge_fall_where_the_floor_is_too_smooth(share: float, seed: int) -> None:
    """By hand: upper edges press each other level, as hard as a card is tipped, and friction holds its foot."""
    lean, length, thick = np.radians(20.0), 0.12, 0.002
    c, s = np.cos(lean), np.sin(lean)
    x, z = length / 2 * s + thick / 2 * c, length / 2 * c + thick / 2 * s
    needed = (length / 2 * s - thick / 2 * c) / (length * c)  # moments about the lower edge, over the weight
    size = (thick, 0.08, length)
    cards = [
        box("one", size, (-x, 0, z), rpy_degrees=(0, 20, 0)),
        box("two", size, (x, 0, z), rpy_degrees=(0, -20, 0)),
    ]
    expected = hf.Status.UNDECIDED if share > 1 else hf.Status.UNSTABLE
    assert statuses(turned([FLOOR, *cards], seed, share * needed)) == {expected}
