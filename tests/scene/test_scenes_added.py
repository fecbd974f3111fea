"""``scene + scene`` keeps what both say, or names what differs."""

from __future__ import annotations

from dataclasses import replace

import pytest
from placed import FLOOR

import holdfast as hf


def cube(name: str, x: float = 0.0, **options: object) -> hf.Body:
    return hf.Body(name, hf.Box((0.1, 0.1, 0.1)), mass=1, position=(x, 0, 0.05), **options)


def test_both_friction_tables_are_kept() -> None:
    one = hf.Scene([FLOOR, cube("a")], hf.Friction(0.5, pairs={("a", "floor"): 0.3}), name="one")
    two = hf.Scene([FLOOR, cube("b", 1)], hf.Friction(0.5, pairs={("b", "floor"): 0.2}), name="two")
    both = one + two
    assert [body.name for body in both.bodies] == ["floor", "a", "b"]
    assert (both.mu("a", "floor"), both.mu("b", "floor"), both.mu("a", "b")) == (0.3, 0.2, 0.5)
    assert both.name == "one + two"
    assert float(hf.robustness(both, "b", (0.95, 0, 0.05), (1, 0, 0), engine="limit")) == pytest.approx(0.2 * 9.81)


def test_values_excluded_pairs_and_notes_are_kept() -> None:
    one = hf.Scene(
        [FLOOR, cube("a"), cube("c", 3)],
        hf.Friction(values={"floor": 0.5, "a": 0.4, "c": 0.4}, combine="min"),
        excluded=[("a", "c")],
        notes=["one"],
    )
    two = hf.Scene([FLOOR, cube("b", 1)], hf.Friction(values={"floor": 0.5, "b": 0.1}, combine="min"), notes=["two"])
    both = one + two
    assert both.mu("a", "b") == 0.1
    assert both.excluded == (("a", "c"),)
    assert both.notes == ("one", "two")


@pytest.mark.parametrize(
    ("second", "match"),
    [
        (hf.Scene([FLOOR, cube("a")], 0.5), "a body named 'a' is in both; give it another name"),
        (hf.Scene([replace(FLOOR, pose=hf.pose(z=-1)), cube("b")], 0.5), "a body named 'floor' is in both"),
        (hf.Scene([FLOOR, cube("b")], 0.4), r"friction: default is 0.5 and 0.4; give both the same"),
        (hf.Scene([FLOOR, cube("b")], 0.5, gravity=(0, 0, -1.62)), "gravity is .* and .*; needs the same"),
        (
            hf.Scene([FLOOR, cube("b", material="oak")], hf.Friction(0.5, pairs={("floor", "oak"): 0.7})),
            r"\('floor', 'oak'\) is 0.3 in one scene and 0.7 in the other",
        ),
        (
            hf.Scene([FLOOR, cube("b", material="oak")], 0.5),
            r"\('floor', 'oak'\) is 0.3 in one scene and 0.5 in the other",
        ),
    ],
)
def test_what_differs_is_named(second: hf.Scene, match: str) -> None:
    first = hf.Scene([FLOOR, cube("a", material="oak")], hf.Friction(0.5, pairs={("floor", "oak"): 0.3}))
    with pytest.raises(hf.errors.SceneError, match=match):
        first + second


def test_only_scenes_are_added() -> None:
    with pytest.raises(TypeError, match="unsupported operand"):
        hf.Scene([FLOOR], 0.5) + FLOOR
