"""Common sense in placement, whatever the time and the seed: nothing over an edge, on a knife's edge, or elsewhere."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import holdfast as hf
from holdfast.scene.shipped.blocks import at

JAMS = Path(__file__).parents[3] / "shared" / "cases" / "jams"
FEW: dict[str, Any] = {"candidates": 2, "spacing": 0.04}


BOARD = hf.Body("board", hf.Box((0.5, 0.28, 0.02)), fixed=True, pose=at(0, 0, -0.01))
TIN = hf.Body("tin", hf.Cylinder(0.04, 0.1), 0.4, pose=at(-0.12, 0.03, 0.05))
FLIMSY = hf.Body("block", hf.Box((0.02, 0.12, 0.12)), 0.1, pose=at(0.1, -0.02, 0.06))
CUP = hf.Body("cup", hf.Cylinder(0.035, 0.1), 0.3)


@pytest.mark.parametrize("budget", [None, 2.0, 0.2])
@pytest.mark.parametrize("seed", range(3))
def test_nothing_juts_out_over_an_edge(seed: int, budget: float | None) -> None:
    """A cup of radius 35 mm on a board 0.5 x 0.28 m (P12); a pose that was not found in time is none."""
    found = hf.plan_placement(
        hf.Scene([BOARD, TIN, FLIMSY], 0.5), CUP, search=hf.Search(seed=seed, seconds=budget, solves=40, **FEW)
    )
    assert found.pose is not None or budget == 0.2
    if found.pose is not None:
        assert (np.abs(found.pose[:2, 3]) <= np.array([0.25, 0.14]) - 0.035 + 2e-4).all()


def test_what_is_larger_than_its_support_juts_out_wherever_it_is_put() -> None:
    post = hf.Body("post", hf.Box((0.1, 0.1, 0.3)), fixed=True, pose=at(0, 0, 0.15))
    tray = hf.Body("tray", hf.Box((0.3, 0.2, 0.02)), 0.5)
    found = hf.plan_placement(hf.Scene([post], 0.5), tray, search=hf.Search(solves=40, **FEW))
    assert found.status == hf.Status.STABLE
    assert np.abs(found.pose[:2, 3]).max() <= 0.05


def test_what_can_only_be_balanced_is_not_placed() -> None:
    found = hf.plan_placement(
        hf.Scene([BOARD], 0.5), hf.Body("orange", hf.Sphere(0.04), 0.2), search=hf.Search(solves=40, **FEW)
    )
    assert found.pose is None
    assert "is only balanced" in found.reason


def test_it_stands_on_what_was_asked_for_alone() -> None:
    """Not on the floor beside a shelf that it touches from the side."""
    low = hf.Body("low", hf.Box((0.12, 0.12, 0.03)), fixed=True, pose=at(0, 0, 0.015))
    floor = hf.Body("floor", hf.HalfSpace(), fixed=True)
    for seed in range(4):
        tin = hf.Body("new", hf.Cylinder(0.015, 0.07), 0.1)
        found = hf.plan_placement(
            hf.Scene([floor, low], 0.5),
            tin,
            where=hf.Where(supports=["low"]),
            search=hf.Search(seed=seed, solves=40, **FEW),
        )
        assert found.status == hf.Status.STABLE
        assert set(found.beneath) == {"low"}
        assert found.pose[2, 3] > 0.03


@pytest.mark.skipif(not JAMS.is_dir(), reason=f"needs the case files in {JAMS}")
@pytest.mark.parametrize("budget", [20.0, 1.0])
def test_a_tin_on_a_pile_stands_on_the_pile(budget: float) -> None:
    """It was laid on its side on the floor, only balanced, where there was little time (T5)."""
    scene = hf.load_scene(JAMS / "place_20.yaml")
    rest, tin = scene.without("new"), scene.body("new")
    supports = [body.name for body in rest.movable]
    for seed in range(2):
        found = hf.plan_placement(
            rest, tin, where=hf.Where(supports=supports), search=hf.Search(seed=seed, seconds=budget, solves=40, **FEW)
        )
        touched = {name for contact in found.contacts for name in contact.bodies} - {"new"}
        assert found.pose is None or touched <= set(supports)
        assert found.pose is None or not hf.stability(found.assembly).verdict.balanced
