"""What a newcomer stumbled over: innocent bodies in a collapse, units, and the wrong kind of argument."""

from __future__ import annotations

import warnings
from collections.abc import Callable

import pytest

import holdfast as hf
from holdfast.scene.shipped import shipped_scene
from holdfast.scene.shipped.blocks import box, floor


def shelf() -> hf.Scene:
    """A block over the edge of a shelf, and two bodies that have nothing to do with it."""
    ground = hf.Body("shelf", hf.Box((0.6, 0.3, 0.02)), pose=floor().pose, fixed=True)
    z = ground.pose[2, 3] + 0.01
    over = box("over", (0.2, 0.1, 0.05), 1, (0.32, -0.1, z + 0.025))
    book = box("book", (0.15, 0.2, 0.03), 0.7, (-0.1, 0, z + 0.015))
    cereal = box("cereal", (0.05, 0.2, 0.3), 0.5, (0.1, 0.02, z + 0.15))
    return hf.Scene([ground, book, cereal, over], 0.5)


@pytest.mark.parametrize("engine", ["graph", "limit"])
def test_a_collapse_names_only_the_bodies_that_fall(engine: str) -> None:
    result = hf.stability(hf.assemble(shelf()), engine=engine)
    assert result.status is hf.Status.UNSTABLE
    assert result.moving == ("over",)
    assert "turns about the axis through (0.3, 0," in result.mechanism.text
    assert result.certificate.violation < 1e-6


def test_a_gap_in_millimetres_is_noticed() -> None:
    with pytest.warns(hf.errors.HoldfastWarning, match=r"gap: is 1e\+03 mm, but body .* is only 100 mm thick.*metres"):
        hf.assemble(shipped_scene("stack"), gap=1.0)


@pytest.mark.parametrize("ask", [hf.assemble, hf.stability, lambda scene: hf.robustness_map(scene, spacing=0.1)])
def test_a_warning_points_at_the_line_of_the_user(ask: Callable[[hf.Scene], object]) -> None:
    scene = hf.Scene([floor(), box("sunk", (0.1, 0.1, 0.1), 1, (0, 0, 0.04))], 0.5)
    with pytest.warns(hf.errors.HoldfastWarning, match="overlap") as caught:
        ask(scene)
    assert {warning.filename for warning in caught} == {__file__}


def test_a_mesh_in_millimetres_is_noticed_and_does_not_raise_the_gap() -> None:
    huge = box("carton", (200, 200, 200), 1, (0, 0, 100))
    small = box("can", (0.1, 0.1, 0.1), 1, (300, 0, 0.05))
    scene = hf.Scene([floor(1000, 1000), huge, small], 0.5)
    with pytest.warns(hf.errors.HoldfastWarning, match=r"'carton': is 200 m across; .*scale 0.001"):
        assembly = hf.assemble(scene)
    assert assembly.tolerances.gap < 1e-3


def test_ordinary_scenes_do_not_warn() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for name in ("table", "tabletop", "bonded_wall"):
            hf.assemble(shipped_scene(name))
