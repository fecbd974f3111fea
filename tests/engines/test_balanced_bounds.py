"""Bodies that are only balanced: bounds hold to the last digit, not to a share of the weight (finding D9)."""

from __future__ import annotations

import numpy as np
import pytest

import holdfast as hf
from holdfast.scene.shipped.blocks import about_y, at, box, floor

SIDE = 0.1
DIAGONAL = 0.05 * np.sqrt(2)


def on_an_edge() -> hf.Body:
    return hf.Body("thing", hf.Box((SIDE, SIDE, SIDE)), mass=3, pose=at(0, 0, DIAGONAL, about_y(np.pi / 4)))


def ball() -> hf.Body:
    return hf.Body("thing", hf.Sphere(0.05), mass=3, pose=at(0, 0, 0.05))


def over_the_end() -> hf.Body:
    """Its centre of mass stands exactly over the edge of what carries it."""
    return box("thing", (0.4, 0.1, 0.02), 3, (0.5, 0, 0.01))


@pytest.mark.parametrize("engine", ["limit", "compliant", "graph"])
@pytest.mark.parametrize("make", [on_an_edge, ball, over_the_end])
def test_d9_force_lies_within_its_bounds_to_the_last_digit(make: object, engine: str) -> None:
    body = make()  # type: ignore[operator]
    assembly = hf.assemble(hf.Scene([floor(), body], 0.5))
    rng = np.random.default_rng(4)
    surface = body.surface_world
    corners = surface.vertices[surface.faces[rng.integers(len(surface.faces), size=12)]]
    points = np.einsum("nkx,nk->nx", corners, rng.dirichlet(np.ones(3), size=12))
    ways, bound = rng.normal(size=(12, 3)), engine == "compliant"
    found = hf.robustness(assembly, "thing", points, ways, engine=engine, bounds=bound)
    assert (found.lower <= found.force).all()
    assert (found.force <= found.upper).all()
    assert not np.isnan(found.force).any()
    factor = hf.load_factor(assembly, [hf.Load("thing", points[0], (3, 1, 2))], engine=engine)
    assert factor.lower <= factor.factor <= factor.upper


@pytest.mark.parametrize("engine", ["limit", "compliant", "graph"])
@pytest.mark.parametrize("yaw", [0, 17, 123])
def test_a_plank_balanced_on_an_edge_anywhere_holds_nothing_at_all(engine: str, yaw: float) -> None:
    """A push down beyond the edge takes 0 N and not what rounding makes of it, and a note says why."""
    there = hf.pose(0.313, -0.271, 0, yaw=yaw)
    base = hf.Body("base", hf.Box((0.2, 0.3, 0.1)), fixed=True, pose=there @ hf.pose(0, 0, 0.05))
    plank = hf.Body("plank", hf.Box((0.4, 0.1, 0.02)), mass=0.7, pose=there @ hf.pose(0.1, 0, 0.11))
    points = np.array([[0.29, 0, 0.12, 1], [0.29, 0.03, 0.12, 1]]) @ there.T
    found = hf.robustness(hf.Scene([base, plank], 0.6), "plank", points[:, :3], (0, 0, -1), engine=engine)
    assert found.force.tolist() == [0.0, 0.0]
    assert found.lower.tolist() == [0.0, 0.0]
    assert any("only balanced" in note and "plank" in note for note in found.notes)
