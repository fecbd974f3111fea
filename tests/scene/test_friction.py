"""The friction table: order of lookup, combination, and what it refuses."""

from __future__ import annotations

from typing import Any

import pytest

import holdfast as hf
from holdfast.scene.shipped.blocks import at, floor

MATERIALS = {"slab": "wood", "leg": "steel", "floor": None}
BY_BODIES = {("leg", "slab"): 0.1}
BY_MIXED = {("slab", "steel"): 0.2}
BY_MIXED_TOO = {("wood", "leg"): 0.25}
BY_MATERIALS = {("steel", "wood"): 0.3}
VALUES = {"slab": 0.4, "leg": 0.6}


@pytest.mark.parametrize("order", [("slab", "leg"), ("leg", "slab")])
@pytest.mark.parametrize(
    ("table", "expected"),
    [
        ({"pairs": BY_BODIES | BY_MIXED | BY_MATERIALS, "values": VALUES, "combine": "max", "default": 0.5}, 0.1),
        ({"pairs": BY_MIXED | BY_MATERIALS, "values": VALUES, "combine": "max", "default": 0.5}, 0.2),
        ({"pairs": BY_MIXED_TOO | BY_MATERIALS, "default": 0.5}, 0.25),
        ({"pairs": BY_MATERIALS, "values": VALUES, "combine": "max", "default": 0.5}, 0.3),
        ({"values": VALUES, "combine": "max", "default": 0.5}, 0.6),
        ({"values": VALUES, "combine": "min", "default": 0.5}, 0.4),
        ({"values": VALUES, "combine": "product", "default": 0.5}, 0.24),
        ({"values": {"slab": 0.4}, "combine": "max", "default": 0.5}, 0.5),
        ({"default": 0.5}, 0.5),
        ({"pairs": {("slab", "leg"): 0.0}, "default": 0.5}, 0.0),
    ],
)
def test_lookup_goes_from_bodies_to_materials_to_values_to_default(
    table: dict[str, Any], expected: float, order: tuple[str, str]
) -> None:
    assert hf.Friction(**table).between(*order, MATERIALS) == pytest.approx(expected, rel=1e-15)


def test_a_material_meets_itself() -> None:
    friction = hf.Friction(pairs={("wood", "wood"): 0.35})
    assert friction.between("a", "b", {"a": "wood", "b": "wood"}) == 0.35


def cube() -> hf.Body:
    return hf.Body("cube", hf.Box((0.1, 0.1, 0.1)), mass=1, pose=at(0, 0, 0.05), material="oak")


def test_a_touching_pair_without_a_coefficient_is_an_error_that_names_it() -> None:
    scene = hf.Scene([floor(), cube()], hf.Friction())
    with pytest.raises(
        hf.errors.SceneError, match=r"friction of \('floor', 'cube'\): is not given; add the pair or a default"
    ):
        hf.stability(hf.assemble(scene), engine="graph")


def test_a_pair_that_does_not_touch_needs_no_coefficient() -> None:
    roof = hf.Body("roof", hf.Box((1, 1, 0.1)), fixed=True, pose=at(0, 0, 9))
    scene = hf.Scene([floor(), cube(), roof], hf.Friction(pairs={("cube", "floor"): 0.5}))
    assert hf.stability(hf.assemble(scene), engine="graph").status == hf.Status.STABLE


@pytest.mark.parametrize(
    ("build", "match"),
    [
        (lambda: hf.Friction(default=-0.1), r"friction: default: is -0\.1; needs a finite number >= 0"),
        (lambda: hf.Friction(default=float("nan")), r"friction: default: is nan; needs"),
        (lambda: hf.Friction(pairs={("a", "b"): -1}), r"friction of \('a', 'b'\): is -1; needs"),
        (lambda: hf.Friction(pairs={("a", "b"): "low"}), r"friction of \('a', 'b'\): got 'low'; needs"),
        (lambda: hf.Friction(pairs={("a", "b"): 1, ("b", "a"): 1}), r"pair \('b', 'a'\) stands twice; give each"),
        (lambda: hf.Friction(pairs={"ab": 1}), r"pair 'ab'; needs two"),
        (lambda: hf.Friction(pairs={(1, "b"): 1}), r"pair \(1, 'b'\); needs two"),
        (lambda: hf.Friction(pairs=[("a", "b")]), r"friction: pairs.*; "),
        (lambda: hf.Friction(values={"a": -1}, combine="max"), r"friction of 'a': is -1; needs"),
        (lambda: hf.Friction(values={"a": 1}), r"combine is not given; say how .* max, min or product"),
        (lambda: hf.Friction(combine="mean"), r"combine: is 'mean'; needs one of max, min, product"),
        (lambda: hf.Scene([floor(), cube()], -0.5), r"friction: default: is -0\.5; needs"),
        (
            lambda: hf.Scene([floor(), cube()], hf.Friction(0.5, {("cub", "floor"): 0.1})),
            r"friction of \('cub', 'floor'\): unknown name 'cub'; did you mean 'cube'\?",
        ),
        (
            lambda: hf.Scene([floor(), cube()], hf.Friction(0.5, values={"oak": 0.1}, combine="min")),
            r"unknown body 'oak'; known: cube, floor",
        ),
    ],
)
def test_what_is_refused(build: Any, match: str) -> None:
    with pytest.raises(hf.errors.SceneError, match=match):
        build()
