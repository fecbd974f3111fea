"""Jams (findings T1 to T3): `lower` is held, by MuJoCo with the bodies' real shapes or by discrete elements.

MuJoCo's bodies chatter where friction is about to let go, and walk the faster the longer its steps are; and they sink
in, which makes air under a ceiling that touches. Discrete elements remember how friction came about, but stay where
they are. What both of them see move is confirmed.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest

import holdfast as hf
from bench.baselines import penalty
from bench.baselines.native import Native
from bench.scenes.jams import FAMILIES, jam
from bench.scenes.random_pushes import Push, columns
from holdfast import Status
from holdfast.answers import Assembly
from holdfast.engines.compliant.elastic_model import Places

STEPS = (2e-4, 5e-5)  # [s]: what moves with the first and holds with the second was MuJoCo's softness
SHARE = 0.95  # of `lower`, which has to be held: MuJoCo's friction creeps
MOST = 10.0  # weights of all bodies, beyond which nothing is tried
SIDE = 5  # nodes along a side of discrete elements
GONE = 1000.0  # of their first displacement, by which something has moved: before a jam holds, line contacts slide far
HALF = 2.0  # times `lower`: what is held there was bounded with more than half of caution


class Tried(NamedTuple):
    """Whether ``lower`` was tried, is above what is held, and is less than half of that."""

    tried: bool
    above: bool
    cautious: bool


def tried(number: int, *, caution: bool = False) -> Tried:
    """Ask about the hardest of the pushes of a jam, the one with the largest `lower` that is not beyond all weights."""
    assembly, pushes = jam(number)
    found = [hf.robustness(assembly, p.body, p.point, p.direction) for p in pushes]
    most = MOST * assembly.weight
    lower = np.array([min(f.lower[0], most) if f.verdict.status is Status.STABLE else 0.0 for f in found])
    k = int(np.argmax(np.where(lower < most, lower, 0.0)))
    if not 0 < lower[k] < most:
        return Tried(False, False, False)
    worlds = (Native(assembly.scene, step) for step in STEPS)  # the second is made only if it is asked
    first = next(worlds)
    if not first.stands:
        return Tried(False, False, False)
    above = first.moves(pushes[k], SHARE * lower[k])
    if above:
        second = next(worlds)
        above = second.stands and second.moves(pushes[k], SHARE * lower[k])
    if above:
        above = not held_by_elements(assembly, pushes[k], SHARE * lower[k])
    return Tried(True, above, caution and not above and not first.moves(pushes[k], HALF * lower[k]))


def held_by_elements(assembly: Assembly, push: Push, force: float) -> bool:
    """Whether discrete elements come to rest under a push without having moved far."""
    load = force * columns(assembly, [push])[:, 0]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(penalty, "FAR", GONE)
        return penalty.holds(assembly, load, Places.of(assembly, SIDE).nodes).holds is True


@pytest.mark.parametrize("number", range(len(FAMILIES)))
def test_mujoco_holds_what_lower_says(number: int) -> None:
    """One jam of each family."""
    pytest.importorskip("mujoco", reason="the referee needs MuJoCo: pip install -e '.[bench]'")
    assert not tried(number).above


@pytest.mark.slow
@pytest.mark.referee
def test_mujoco_holds_what_lower_says_of_300_jams() -> None:
    pytest.importorskip("mujoco", reason="the referee needs MuJoCo: pip install -e '.[bench]'")
    seen = [tried(number) for number in range(300)]
    assert sum(one.tried for one in seen) > 200
    assert not any(one.above for one in seen)
