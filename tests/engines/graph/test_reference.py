"""The engine against the method done by enumeration from definitions, on the same contact forces."""

import numpy as np
import pytest
from engine_scenes import surface_points
from graph_scenes import push
from reference import reference_of

from holdfast import assemble
from holdfast.assembly.one_group import part_of
from holdfast.scene.shipped import shipped_scene


@pytest.mark.parametrize(
    ("name", "pushes"),
    [
        ("cube", 25),
        ("stack", 10),
        ("table", 12),
        ("wall2x2", 5),
        ("slope", 8),
        ("slope_two", 5),
        ("cantilever", 4),
        ("v_groove", 15),
        ("wedged_floor", 10),
    ],
)
def test_engine_equals_enumeration(name: str, pushes: int) -> None:
    assembly = assemble(shipped_scene(name))
    reference = reference_of(part_of(assembly, assembly.groups[0]).assembly)  # nodes as the query places them
    rng = np.random.default_rng(5)
    for body in assembly.movable:
        points = surface_points(body, pushes, rng)
        directions = rng.normal(size=(pushes, 3))
        directions /= np.linalg.norm(directions, axis=1, keepdims=True)
        for p, e in zip(points, directions, strict=True):
            expected = reference.robustness(body.name, p, e)
            assert push(assembly, body.name, p, e) == pytest.approx(expected, rel=1e-5, abs=1e-5), (body.name, p, e)
