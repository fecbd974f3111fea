"""The paper's optimisation through IPOPT, beside engine ``limit`` on the same nodes and closed forms."""

from __future__ import annotations

import sys

import numpy as np
import pytest

from bench.baselines import optimised
from holdfast import HoldfastError, Limit, Scene, Status, assemble
from holdfast.answers import Assembly
from holdfast.assembly.contact_nodes import contact_nodes
from holdfast.queries.request import push_columns
from holdfast.scene.shipped import shipped_scene

X, Y, Z = np.eye(3)
MU, W = 0.6, 9.81


@pytest.fixture
def casadi() -> None:
    pytest.importorskip("casadi", reason="casadi is not installed: see bench/notes/baselines.md")


def cube(lean: float = 0.0) -> Assembly:
    return assemble(Scene(shipped_scene("cube").bodies, MU, W * np.array([lean, 0, -1.0])))


@pytest.mark.usefixtures("casadi")
@pytest.mark.parametrize("sides", [4, 8])
def test_a_cube_that_slides_and_topples(sides: int) -> None:
    """Exact towards a corner of the polygon, short by cos(π/N) towards the middle of a side (where t1 points)."""
    corners = contact_nodes(cube(), 4, "corners")
    along = [
        corners.axes[0, 1],
        np.cos(np.pi / sides) * corners.axes[0, 1] + np.sin(np.pi / sides) * corners.axes[0, 2],
    ]
    found = optimised(cube(), "cube", (0, 0, 0), along, sides=sides, nodes=corners)
    assert found.force == pytest.approx([MU * W * np.cos(np.pi / sides), MU * W], rel=1e-6)
    topples = optimised(cube(), "cube", (-0.05, 0, 0.1), [X, 0.3 * X + Z], sides=sides, nodes=corners)
    assert topples.force[0] == pytest.approx(MU * W * np.cos(np.pi / sides) if sides == 4 else W / 2, rel=1e-6)
    assert topples.method == f"ipopt ({sides})"


@pytest.mark.usefixtures("casadi")
@pytest.mark.parametrize(
    ("name", "body", "point"), [("stack", "cube2", (-0.05, 0.02, 0.17)), ("table", "slab", (-0.25, 0.05, 0.22))]
)
def test_the_same_program_as_engine_limit(name: str, body: str, point: tuple[float, float, float]) -> None:
    """On the paper's nodes, from the same seed; another seed gives other nodes."""
    assembly = assemble(shipped_scene(name))
    point, along = np.array(point)[None], np.array([[0.8, 0.6, 0.0]])
    for sides in (4, 8):
        nodes = contact_nodes(assembly, 20, "paper", 3)
        state = Limit("inscribed", sides).on(assembly, assembly.weight_wrench(), nodes)
        expected = state.load_factor(push_columns(assembly, assembly.index[body], point, along)).force
        found = optimised(assembly, body, point, along, sides=sides, seed=3)
        assert found.status[0] is Status.FINITE
        assert found.force == pytest.approx(expected, rel=1e-5)
        assert optimised(assembly, body, point, along, sides=sides, seed=4).force[0] != found.force[0]


@pytest.mark.usefixtures("casadi")
def test_infeasible_is_nothing_and_unbounded_is_endless() -> None:
    assert optimised(cube(), "cube", (0, 0, 0.1), -Z).status[0] is Status.INFINITE
    slides = optimised(cube(lean=1.0), "cube", (0, 0, 0.1), [Y, X])
    assert list(slides.status) == [Status.UNSTABLE] * 2
    assert slides.force.tolist() == [0.0, 0.0]


def test_a_missing_casadi_says_how_to_get_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delitem(sys.modules, "casadi", raising=False)
    monkeypatch.setitem(sys.modules, "casadi", None)
    with pytest.raises(HoldfastError, match=r"pip install -e '\.\[bench\]'"):
        optimised(cube(), "cube", (0, 0, 0.1), X)
