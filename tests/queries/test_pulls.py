"""Pushes that point away from the surface are pulls, and the answer says so (P6)."""

from __future__ import annotations

import numpy as np
import pytest

import holdfast as hf
from holdfast.scene.shipped.blocks import at

PLATE = hf.Body("plate", hf.Box((1, 1, 0.1)), fixed=True)
SIDE = 0.1


def told(shape: object, points: object, directions: object) -> list[str]:
    """The notes on pulls of pushes on a body of this shape whose middle is at (0, 0, 0.1)."""
    body = hf.Body("b", shape, mass=1.0, pose=at(0, 0, 0.1))  # type: ignore[arg-type]
    found = hf.robustness(hf.Scene([PLATE, body], 0.5), "b", points, directions, engine="limit")  # type: ignore[arg-type]
    return [note for note in found.notes if "pull" in note]


def box_cases() -> dict[str, tuple[tuple[float, ...], tuple[float, ...], bool]]:
    """Points on a cube, directions, and whether they point away from it."""
    return {
        "into a face": ((0.05, 0, 0.1), (-1, 0, 0), False),
        "out of a face": ((0.05, 0, 0.1), (1, 0, 0), True),
        "out of a face, aslant": ((0.05, 0, 0.1), (0.1, 1, 0), True),
        "along a face": ((0, 0, 0.15), (1, 0, 0), False),
        "out of an edge": ((0.05, 0, 0.15), (1, 0, 1), True),
        "along a face, out at its edge": ((0.05, 0, 0.15), (1, 0, 0), False),
        "into an edge, but out of one of its faces": ((0.05, 0, 0.15), (1, 0, -0.5), False),
        "out of a corner": ((0.05, 0.05, 0.15), (1, 1, 1), True),
    }


@pytest.mark.parametrize("case", box_cases())
def test_what_points_out_of_a_cube_pulls(case: str) -> None:
    point, direction, pulls = box_cases()[case]
    expected = ["the push points away from the surface of b: it pulls"] if pulls else []
    assert told(hf.Box((SIDE, SIDE, SIDE)), point, direction) == expected


def test_off_the_surface_within_tolerance_it_is_the_same() -> None:
    for off in (-5e-5, 5e-5):
        point = (0.05 + off, 0, 0.1)
        assert told(hf.Box((SIDE, SIDE, SIDE)), point, (1, 0, 0))
        assert not told(hf.Box((SIDE, SIDE, SIDE)), point, (-1, 0, 0))


def test_of_many_pushes_the_number_is_told() -> None:
    shape, turn = hf.Cylinder(0.05, 0.1), np.linspace(0, 2 * np.pi, 12, endpoint=False)
    outward = np.stack([np.cos(turn), np.sin(turn), np.zeros(12)], axis=1)
    points = 0.05 * np.cos(np.pi / 64) * outward + (0, 0, 0.1)
    ways = -outward
    assert told(shape, points, ways) == []
    ways[[3, 7]] *= -1
    assert told(shape, points, ways) == ["2 of 12 pushes, the first number 3, pull: they point away from b"]
