"""Contacts that are ruled out body by body: closed forms, and the cone program that finds all that can press."""

import numpy as np
import pytest

import holdfast as hf
from bench.scenes import random_assemblies
from holdfast.assembly.contact_nodes import ContactNodes, contact_nodes
from holdfast.engines.forces import EXACT, clampable, self_stressed_nodes
from holdfast.scene.shipped.blocks import at, box, floor


def slot(*, blocks: int) -> hf.answers.Assembly:
    """A row of blocks on the floor that fills the place between two fixed walls, and a block on top of the first."""
    middle = 0.05 * (blocks - 1)
    walls = [
        hf.Body(
            f"wall{side}", hf.Box((0.1, 0.3, 0.3)), pose=at(middle + side * (0.05 * blocks + 0.05), 0, 0.15), fixed=True
        )
        for side in (-1, 1)
    ]
    row = [box(f"block{k}", (0.1, 0.1, 0.1), 1, (0.1 * k, 0, 0.05)) for k in range(blocks)]
    top = box("top", (0.06, 0.06, 0.06), 1, (0, 0, 0.13))
    return hf.assemble(hf.Scene([floor(3.0, 1.0), *walls, *row, top], 0.3))


def groove(normals: np.ndarray, mu: float, *, second: bool) -> ContactNodes:
    """Contacts of a body with fixed ones, along normals (n, 3) into it, or out of it if it is the first of the two."""
    count = len(normals)
    sign = 1.0 if second else -1.0
    axes = np.stack([np.linalg.qr(np.column_stack([n, np.eye(3)]))[0].T[:3] for n in sign * normals])
    axes[:, 0] = sign * normals
    body, fixed = np.zeros(count, dtype=np.int64), np.full(count, -1)
    a, b = (fixed, body) if second else (body, fixed)
    return ContactNodes(
        np.zeros((count, 3)), axes, np.full(count, mu), np.ones(count), np.arange(count), a, b, np.zeros(count)
    )


@pytest.mark.parametrize("second", [True, False])
@pytest.mark.parametrize("steep", [20.0, 45.0, 60.0])
def test_two_slopes_clamp_a_body_where_friction_reaches_across(steep: float, second: bool) -> None:
    """Slopes at an angle to the floor, friction angle φ: forces oppose each other from angle + φ = 90 degrees on."""
    angle = np.radians(steep)
    normals = np.array([[np.sin(angle), 0, np.cos(angle)], *4 * [[-np.sin(angle), 0, np.cos(angle)]]])
    for off, left in ((-8.0, False), (8.0, True)):
        found = clampable(groove(normals, np.tan(np.radians(90 - steep + off)), second=second))
        assert (found == left).all()


def test_a_polygon_around_the_cone_counts_with_its_corners() -> None:
    normals = np.array([[1.0, 0, 1], [-1, 0, 1]]) / np.sqrt(2)
    nodes = groove(normals, 0.8, second=True)
    assert not clampable(nodes).any()
    assert clampable(nodes, 1.5).all()


def test_what_is_left_holds_all_that_the_program_finds() -> None:
    """A row that two walls can clamp: peeling keeps it and takes the block on top, and the program clamps no less."""
    assembly = slot(blocks=3)
    nodes = contact_nodes(assembly, 4, "corners")
    left = clampable(nodes)
    top = assembly.index["top"]
    assert not left[(nodes.a == top) | (nodes.b == top)].any()
    pressed = self_stressed_nodes(assembly, nodes, EXACT)
    assert pressed is not None
    assert (np.abs(nodes.normals[pressed, 0]) > 0.9).any()
    assert not (pressed & ~left).any()


@pytest.mark.parametrize("family", list(random_assemblies.FAMILIES))
def test_the_program_agrees_that_contacts_which_are_ruled_out_cannot_press(
    family: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    for seed in range(2):
        random = np.random.default_rng([seed, 31])
        assembly = random_assemblies.standing(random_assemblies.FAMILIES[family], random)
        nodes = contact_nodes(assembly, 4, "corners")
        left = clampable(nodes)
        with monkeypatch.context() as whole:
            whole.setattr("holdfast.engines.forces.clampable", lambda nodes, _: np.ones(len(nodes), dtype=bool))
            pressed = self_stressed_nodes(assembly, nodes, EXACT)
        assert pressed is not None
        assert not (pressed & ~left).any()


def test_a_dense_stack_is_peeled_from_its_corners() -> None:
    """At a corner forces come from three sides, at most 81 degrees from the space diagonal at μ = 0.5."""
    size = (0.2, 0.15, 0.1)
    bodies = [
        box(f"{i}{j}{k}", size, 1, (0.2 * i, 0.15 * j, 0.05 + 0.1 * k))
        for i in range(3)
        for j in range(3)
        for k in range(3)
    ]
    assembly = hf.assemble(hf.Scene([floor(3.0, 3.0), *bodies], 0.5))
    assert not clampable(contact_nodes(assembly, 4, "corners")).any()
