"""Pairs of faces kept from step to step are those of a fresh search."""

from __future__ import annotations

import numpy as np
import pytest

import holdfast as hf
from holdfast.settling.moved_surfaces import Posed
from holdfast.settling.near_points import FacePairs, near_points

MARGIN = 2e-3


def at(x: float, y: float, z: float) -> np.ndarray:
    pose = np.eye(4)
    pose[:3, 3] = x, y, z
    return pose


def balls() -> list[Posed]:
    """Two tessellated balls, 1 mm apart."""
    low, high = (hf.Body(n, hf.Sphere(0.04), mass=1.0, pose=at(0, 0, z)) for n, z in (("low", 0.0), ("high", 0.081)))
    return [Posed(low), Posed(high)]


@pytest.mark.parametrize("seed", range(5))
def test_pairs_that_are_kept_are_those_of_a_fresh_search(seed: int) -> None:
    """Both bodies wander in steps of half a millimetre: near points are the same as without any memory."""
    rng, (low, high), kept, count = np.random.default_rng(seed), balls(), FacePairs(), 0
    for _ in range(12):
        for body in (low, high):
            body.move(5e-4 * rng.uniform(-1, 1, 3), 0.01 * rng.uniform(-1, 1, 3))
        found = near_points(low, high, kept, margin=MARGIN)
        fresh = near_points(low, high, FacePairs(), margin=MARGIN)
        assert np.allclose(np.sort(found.gaps), np.sort(fresh.gaps), atol=1e-12)
        count += len(fresh.gaps)
    assert count > 0


def test_pairs_are_searched_again_only_after_the_spare_distance_is_used_up(monkeypatch: pytest.MonkeyPatch) -> None:
    import holdfast.settling.near_points as module

    searches: list[float] = []
    search = module.near_faces
    monkeypatch.setattr(module, "near_faces", lambda a, b, gap: searches.append(gap) or search(a, b, gap))
    (low, high), kept = balls(), FacePairs()
    for _ in range(3):
        kept.within(low, high, MARGIN)
        high.move(np.array([0, 0, -2e-4]), np.zeros(3))
    assert len(searches) == 1
    high.move(np.array([0, 0, 3e-3]), np.zeros(3))
    kept.within(low, high, MARGIN)
    assert len(searches) == 2


def test_bodies_that_move_together_need_no_new_search(monkeypatch: pytest.MonkeyPatch) -> None:
    import holdfast.settling.near_points as module

    (low, high), kept = balls(), FacePairs()
    kept.within(low, high, MARGIN)
    monkeypatch.setattr(module, "near_faces", lambda a, b, gap: pytest.fail("searched"))
    for body in (low, high):
        body.move(np.array([0.3, -0.2, 0.1]), np.zeros(3))
    assert len(kept.within(low, high, MARGIN)) > 0
