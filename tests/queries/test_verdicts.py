"""Why something does not stand, in words that name bodies and distances."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import holdfast as hf
from holdfast.scene.shipped.blocks import about_x, about_y, at, box, cube, floor, wall

SIDE = (0.1, 0.1, 0.1)


def verdict(*bodies: hf.Body, **options: Any) -> hf.answers.Stability:
    return hf.stability(hf.assemble(hf.Scene([floor(), *bodies], 0.5), **options), engine="graph")


def test_an_unsupported_body_is_named_with_the_nearest_and_the_distance() -> None:
    """Nearer ones are undecided: tests/engines/test_reach.py."""
    result = verdict(box("a", SIDE, 1, (0, 0, 0.05)), box("b", SIDE, 1, (0, 0, 0.162)))
    assert result.status == hf.Status.UNSTABLE
    assert result.equilibrium_exists is False
    assert "unsupported: b" in result.reason
    assert "b is 12 mm from a" in result.reason
    assert "0.173 mm" in result.reason
    assert "raise gap" in result.reason
    assert result.moving == ("b",)


def test_a_group_that_hangs_together_is_named_together() -> None:
    result = verdict(box("a", SIDE, 1, (0, 0, 0.07)), box("b", SIDE, 1, (0, 0, 0.17)))
    assert "unsupported: a, b" in result.reason
    assert "a is 20 mm from floor" in result.reason
    assert result.moving == ("a", "b")


def test_a_body_far_from_everything_is_named() -> None:
    assert "unsupported: a: no chain of contacts" in verdict(box("a", SIDE, 1, (0, 0, 5))).reason


ROLLING = {
    "sphere": hf.Body("it", hf.Sphere(0.05), mass=1, pose=at(0, 0, 0.05)),
    "cube on edge": hf.Body("it", hf.Box(SIDE), mass=1, pose=at(0, 0, 0.05 * np.sqrt(2), about_y(np.pi / 4))),
    "lying cylinder": hf.Body("it", hf.Cylinder(0.05, 0.2), mass=1, pose=at(0, 0, 0.05, about_x(np.pi / 2))),
}


@pytest.mark.parametrize("engine", ["limit", "graph"])
@pytest.mark.parametrize("name", ROLLING)
def test_a_body_on_a_point_or_a_line_stands_but_nothing_keeps_it_from_turning(name: str, engine: str) -> None:
    body = ROLLING[name]
    assembly = hf.assemble(hf.Scene([floor(), body], 0.5))
    assert hf.stability(assembly, engine=engine).equilibrium_exists
    top = [0, 0, body.surface_world.vertices[:, 2].max()]
    pushes = hf.robustness(
        assembly, "it", np.array([top, top, top]), np.array([[1, 0, 0], [-1, 0, 0], [0, 0, -1]]), engine=engine
    )
    np.testing.assert_allclose(pushes.force, [0, 0, np.inf], atol=1e-6)
    if name != "sphere":  # along the line friction holds, or it tips over the line's end
        side = [0, -0.05 if name == "cube on edge" else -0.1, body.com_world[2]]
        along = hf.robustness(assembly, "it", side, (0, 1, 0), engine=engine)
        assert along.force[0] == pytest.approx(0.5 * 9.81, rel=1e-3)


def ridges() -> hf.Scene:
    """A cube on its edge along the edge of another: sharp on sharp, no direction of contact is defined."""
    below = hf.Body("below", hf.Box(SIDE), pose=at(0, 0, 0.05 * np.sqrt(2), about_y(np.pi / 4)), fixed=True)
    above = hf.Body("it", hf.Box(SIDE), mass=1, pose=at(0, 0, 0.15 * np.sqrt(2), about_y(np.pi / 4)))
    return hf.Scene([below, above], 0.5)


@pytest.mark.parametrize("engine", ["limit", "graph"])
def test_sharp_on_sharp_is_undecided_and_not_unstable(engine: str) -> None:
    result = hf.stability(hf.assemble(ridges()), engine=engine)
    assert result.status == hf.Status.UNDECIDED
    assert result.equilibrium_exists is None
    for word in ("it", "below", "edge"):
        assert word in result.reason


@pytest.mark.parametrize("offset", [0.2, 0.3])
def test_a_wall_with_a_brick_in_the_air_is_unstable_with_a_certificate(offset: float) -> None:
    scene = wall(2, 3, 0.5, "w")
    brick = box("loose", (0.2, 0.1, 0.1), 4, (0.1, 0, 0.25 + offset))
    result = hf.stability(hf.assemble(hf.Scene([*scene.bodies, brick], 0.6)), engine="graph")
    assert result.status == hf.Status.UNSTABLE
    assert result.moving == ("loose",)
    assert result.certificate.power > 0
    assert result.certificate.violation <= 1e-6
    assert "loose" in result.reason


def test_an_overhanging_brick_topples_with_a_certificate() -> None:
    result = verdict(box("a", SIDE, 1, (0, 0, 0.05)), box("b", SIDE, 1, (0.06, 0, 0.15)))
    assert result.status == hf.Status.UNSTABLE
    assert "b" in result.moving
    assert result.mechanism.mode in ("topple", "mixed")
    assert result.mechanism.twists.shape == (2, 6)
    assert result.certificate.power > 0
    assert result.forces is None
    assert np.isinf(result.residual)


def test_a_standing_load_can_tip_what_stands() -> None:
    assembly = hf.assemble(cube())
    push = hf.Load("cube", (0.05, 0, 0.1), force=(6, 0, 0))
    result = hf.stability(assembly, loads=[push], engine="graph")
    assert result.status == hf.Status.UNSTABLE
    assert result.moving == ("cube",)


@pytest.mark.parametrize(
    ("build", "match"),
    [
        (lambda: hf.Load("cube"), r"'cube': has neither force nor moment; give one"),
        (lambda: hf.Load("cube", force=(1, 0, 0)), r"'cube': has a force but no point; say where"),
    ],
)
def test_what_is_refused(build: Any, match: str) -> None:
    with pytest.raises(hf.HoldfastError, match=match):
        build()
