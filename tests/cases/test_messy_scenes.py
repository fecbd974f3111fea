"""Scenes as users have them: what is loose, falls or is unknown keeps to itself (findings L2, U1, X1)."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from placed import at

import holdfast as hf

G = 9.81
GAP = 1e-4


FLOOR = hf.Body("floor", hf.Box((6, 6, 0.1)), pose=at(0, 0, -0.05), fixed=True)
BALL = hf.Body("ball", hf.Sphere(0.05), mass=0.5, pose=at(1, 0, 0.05))
LEFT, ALONG_X, DOWN = np.array([-0.05, 0, 0.05]), (1.0, 0, 0), (0, 0, -1.0)


def cube(name: str, x: float, z: float = 0.05, **options: Any) -> hf.Body:
    return hf.Body(name, hf.Box((0.1, 0.1, 0.1)), pose=at(x, 0, z), **{"mass": 1.0, **options})


def assembled(bodies: list[hf.Body], friction: hf.Friction | float = 0.5) -> hf.answers.Assembly:
    return hf.assemble(hf.Scene([FLOOR, *bodies], friction), gap=GAP)


def push(assembly: hf.answers.Assembly, body: str, point: Any, along: Any, **options: Any) -> hf.answers.Robustness:
    found = hf.robustness(assembly, body, point, along, **options)
    assert (found.lower <= found.force).all()
    assert (found.force <= found.upper).all()
    return found


def balanced(found: hf.answers.Robustness, *names: str) -> bool:
    """Whether the least push starts a motion of these bodies, and the answer says so."""
    told = any("only balanced" in note and all(name in note for name in names) for note in found.notes)
    known = found.mechanism[0] is not None and set(found.moving[0]) == set(names)
    zero = found.force[0] == found.lower[0] == 0 and found.upper[0] < 1e-6
    return found.status[0] is hf.Status.FINITE and bool(zero) and told and known


def test_a_ball_rolls_at_the_least_push_and_carries_what_presses_it_down() -> None:
    assembly = assembled([cube("cube", 0), BALL])
    for point, along in (((0.95, 0, 0.05), ALONG_X), ((1, 0, 0.1), ALONG_X), ((1, -0.05, 0.05), (0.3, 1, 0))):
        assert balanced(push(assembly, "ball", point, along), "ball")
    down = push(assembly, "ball", (1, 0, 0.1), DOWN)
    assert (down.status[0], down.force[0]) == (hf.Status.INFINITE, np.inf)


def test_nothing_resists_on_ice_but_a_wall_does() -> None:
    """L2: a cube on a frictionless floor, against a frictionless wall or not."""
    wall = cube("wall", 0.1, fixed=True)
    for bodies in ([cube("cube", 0)], [cube("cube", 0), wall]):
        assembly = assembled(bodies, 0.0)
        assert balanced(push(assembly, "cube", (0, -0.05, 0.05), (0, 1, 0)), "cube")
        assert push(assembly, "cube", (0.03, 0.02, 0.1), DOWN).force[0] == np.inf
    assert balanced(push(assembly, "cube", (0.05, 0, 0.05), (-1, 0, 0)), "cube")
    assert push(assembly, "cube", LEFT, ALONG_X).force[0] == np.inf


def test_a_stack_with_one_frictionless_pair() -> None:
    """L2: the lower cube carries the upper one: μ 2 m g = 9.81 N; the upper one slides at the least push."""
    friction = hf.Friction(0.5, pairs={("low", "high"): 0.0})
    assembly = assembled([cube("low", 0), cube("high", 0, 0.15)], friction)
    low = push(assembly, "low", LEFT, ALONG_X, bounds=True)
    assert low.force[0] == pytest.approx(2 * 0.5 * G, rel=1e-5)
    assert low.moving[0] == ("low",)
    assert balanced(push(assembly, "high", (-0.05, 0, 0.15), ALONG_X), "high")


def test_a_ball_that_leans_on_a_cube_carries_no_more_than_friction_allows() -> None:
    """The cube pushes the ball along: it rolls, and the cube slides at μ m g."""
    assembly = assembled([cube("cube", 0.9), BALL])
    found = push(assembly, "cube", (0.85, 0, 0.05), ALONG_X)
    assert found.force[0] == pytest.approx(0.5 * G, rel=1e-5)
    assert set(found.moving[0]) == {"cube", "ball"}


SHELF = [
    hf.Body("shelf", hf.Box((0.6, 0.3, 0.02)), pose=at(0, 0, -0.01), material="oak", fixed=True),
    hf.Body("book", hf.Box((0.15, 0.21, 0.03)), mass=0.7, pose=at(-0.1, 0, 0.015)),
    hf.Body("vase", hf.Cylinder(0.03, 0.2), mass=0.4, pose=at(0.1, 0, 0.1), material="glass"),
    hf.Body("cup", hf.Cylinder(0.035, 0.09), mass=0.25, pose=at(-0.13, 0.05, 0.075)),
]
ORANGE = hf.Body("orange", hf.Sphere(0.04), mass=0.2, pose=at(0.22, 0, 0.04))


@pytest.mark.parametrize("engine", ["limit", "compliant"])
def test_an_orange_on_the_shelf(engine: str) -> None:
    """U1: all other bodies are mapped as without it; the orange rolls, wherever it is pushed but straight down."""
    friction = hf.Friction(0.5, pairs={("glass", "oak"): 0.3})
    alone = hf.robustness_map(hf.assemble(hf.Scene(SHELF, friction), gap=GAP), spacing=0.03, engine=engine)
    found = hf.robustness_map(hf.assemble(hf.Scene([*SHELF, ORANGE], friction), gap=GAP), spacing=0.03, engine=engine)
    orange = found.body == "orange"
    assert found.force[~orange].tobytes() == alone.force.tobytes()
    assert set(found.status[~orange]) <= {hf.Status.FINITE, hf.Status.INFINITE}
    assert orange.sum() > 10
    assert (found.status[orange] == hf.Status.FINITE).all()
    assert (found.force[orange] == 0).all()
    assert found.weakest().body == "orange"
    assert any("only balanced" in note and "orange" in note for note in found.notes)


def test_a_tetrahedron_on_its_edge_has_no_answer_that_the_proof_contradicts() -> None:
    """X1: balanced on an edge to the last digit; a push through its end gave 89 N, where 39.6 N are proved."""
    side = 0.028
    corners = side / np.sqrt(8) * np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]], float)
    edge = (corners[1] - corners[0]) / side
    up = -(corners[0] + corners[1]) / np.linalg.norm(corners[0] + corners[1])
    turn = np.array([edge, np.cross(up, edge), up])
    corners = corners @ turn.T
    corners[:, 2] -= corners[:, 2].min()
    faces = np.array([[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]])
    body = hf.Body("tetrahedron", hf.Mesh(corners, faces), mass=42.0)
    assembly = hf.assemble(hf.Scene([FLOOR, body], 0.5), gap=1e-6)
    for point, along in ((corners[0], (-1.0, 0, 0.0)), (corners[0], (-1.0, 0, -0.5)), (corners[2], (0, 1.0, 0))):
        found = push(assembly, "tetrahedron", point, along)
        certain = push(assembly, "tetrahedron", point, along, engine="limit")
        assert found.status[0] is hf.Status.UNDECIDED or found.force[0] <= certain.upper[0]
