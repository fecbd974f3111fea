"""Interfaces that are given are taken as they are."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import holdfast as hf
from holdfast.scene.shipped.blocks import box, floor

UP = (0.0, 0.0, 1.0)
ELL = np.array([(0, 0, 0), (0.1, 0, 0), (0.1, 0.05, 0), (0.05, 0.05, 0), (0.05, 0.1, 0), (0, 0.1, 0)]) - [0.03, 0.03, 0]


def scene() -> hf.Scene:
    return hf.Scene([floor(), box("cube", (0.1, 0.1, 0.1), 1, (0, 0, 0.05))], 0.5)


@pytest.mark.parametrize("polygon", [ELL, ELL[::-1]], ids=["counter-clockwise", "clockwise"])
@pytest.mark.parametrize("length", [1, 7.5])
def test_a_polygon_that_is_not_convex_keeps_its_shape_in_either_winding(polygon: np.ndarray, length: float) -> None:
    interface = hf.answers.Interface(bodies=("floor", "cube"), polygon=polygon, normal=length * np.array(UP))
    (patch,) = interface.patches
    assert interface.area == pytest.approx(0.0075, rel=1e-12)
    assert len(patch.polygon) == 6
    assert len(patch.hull) == 5
    np.testing.assert_allclose(patch.normal, UP)
    np.testing.assert_allclose(patch.centroid, np.array([0.125 / 3, 0.125 / 3, 0]) - [0.03, 0.03, 0], rtol=1e-9)
    assembly = hf.assemble(scene(), interfaces=[interface])
    assert assembly.interfaces == (interface,)
    assert hf.stability(assembly, engine="graph").status == hf.Status.STABLE


def test_given_interfaces_are_complete() -> None:
    assembly = hf.assemble(scene(), interfaces=[])
    assert assembly.interfaces == ()
    result = hf.stability(assembly, engine="graph")
    assert result.status == hf.Status.UNSTABLE
    assert result.moving == ("cube",)


def test_a_slightly_warped_polygon_is_flattened() -> None:
    warped = ELL + np.random.default_rng(0).uniform(-1, 1, ELL.shape) * [0, 0, 1e-4]
    (patch,) = hf.answers.Interface(("floor", "cube"), warped, UP).patches
    assert np.ptp((patch.polygon - warped.mean(0)) @ patch.normal) < 1e-15
    assert patch.area == pytest.approx(0.0075, rel=1e-9)


@pytest.mark.parametrize(
    ("build", "match"),
    [
        (lambda: hf.answers.Interface(("a", "b"), ELL, (1, 0, 0)), r"leave the plane by .* m; split it"),
        (lambda: hf.answers.Interface(("a", "b"), ELL, (0, 0, 0)), r"normal is zero; needs"),
        (lambda: hf.answers.Interface(("a", "b"), ELL), r"normal.*; needs"),
        (lambda: hf.answers.Interface(("a", "b"), ELL[:2], UP), r"polygon has 2 corners; needs at least 3"),
        (lambda: hf.answers.Interface(("a", "b"), ELL[[0, 1, 1]], UP), r"polygon has area 0.*; needs a surface"),
        (lambda: hf.answers.Interface(("a", "a"), ELL, UP), r"\('a', 'a'\): joins a body with itself; needs two"),
        (lambda: hf.answers.Interface(("a", "b")), r"has no patches; give polygon= and normal="),
        (lambda: hf.answers.Interface(("a",), ELL, UP), r"\('a',\).*; needs the names of two"),
        (
            lambda: hf.answers.Interface(("a", "b"), [[0, 0, 0], [1, 1, 0], [1, 0, 0], [0, 2, 0]], UP),
            r"crosses itself.*; ",
        ),
    ],
)
def test_what_is_refused(build: Any, match: str) -> None:
    with pytest.raises(hf.errors.GeometryError, match=rf"interface.*{match}"):
        build()


def test_an_interface_of_an_unknown_body_suggests_the_nearest() -> None:
    interface = hf.answers.Interface(("floor", "cub"), ELL, UP)
    with pytest.raises(hf.errors.SceneError, match=r"'cub'; did you mean 'cube'\?"):
        hf.assemble(scene(), interfaces=[interface])


def test_an_interface_between_fixed_bodies_is_left_out() -> None:
    two = hf.Scene([floor(), hf.Body("wall", hf.Box((1, 1, 1)), fixed=True)], 0.5)
    assembly = hf.assemble(two, interfaces=[hf.answers.Interface(("floor", "wall"), ELL, UP)])
    assert assembly.interfaces == ()
    assert hf.stability(assembly, engine="graph").reason.startswith("nothing here can move")
    assert hf.robustness(assembly, "wall", (0, 0, 0.5), (0, 0, -1), engine="graph").force[0] == np.inf
