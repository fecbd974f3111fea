"""Taking one body out: what is asked between its first lift and its last contact, and how a sideways pull is loaded."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

import holdfast as hf
from holdfast.applications.disassembly.removal import Answer, Removals
from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import Float
from holdfast.engines.answers import Answers, Claim
from holdfast.engines.contract import EXACT, Accuracy
from holdfast.engines.verdict import Status, Verdict
from holdfast.scene.shipped.blocks import at, box, floor

MASS = 2.0  # [kg]
Z, Y = np.array([0, 0, 1.0]), np.array([0, 1.0, 0])


def slot() -> hf.Scene:
    """A book between two fixed walls, on a slippery plate that may slide on the floor and touches no wall."""
    walls = [
        hf.Body(f"wall{k}", hf.Box((0.02, 0.3, 0.2)), pose=at(x, 0, 0.12), fixed=True)
        for k, x in enumerate((-0.06, 0.06))
    ]
    plate, book = box("plate", (0.08, 0.3, 0.01), 1, (0, 0, 0.005)), box("book", (0.1, 0.2, 0.1), 1, (0, 0, 0.06))
    friction = hf.Friction(0.1, {("book", "plate"): 0.8})
    return hf.Scene([floor(), *walls, plate, book], friction)


def test_a_body_that_is_pulled_sideways_is_carried_and_not_pressed_down() -> None:
    """With 90 % of its weight taken the book drags its plate by 0.08 weights, which the floor holds with 0.11.

    Pressed down by as much, it would drag by 1.52 weights, of which the floor holds 0.29: the plate would come along.
    """
    removals = Removals(hf.assemble(slot()), hf.Compliant(), Y)
    found = removals.by_forces("book", frozenset(removals.names))
    assert (found.answer, found.moving) == (Answer.SAFE, ())


@dataclass(frozen=True)
class FallsMidway:
    """An engine for which another body falls while the lift of the second one is between two shares of its weight."""

    low: float
    high: float
    name = "midway"
    claim = Claim.HOLDS

    def prepare(self, assembly: Assembly, standing: Float | None = None, acceleration: Float | None = None) -> State:
        return State(self, assembly, 0.0 if standing is None else float(standing.reshape(-1, 6)[:, 2].sum()))


@dataclass(frozen=True)
class State:
    engine: FallsMidway
    assembly: Assembly
    lift: float
    notes: tuple[str, ...] = ()

    def verdict(self) -> Verdict:
        if self.engine.low < self.lift / (MASS * 9.81) < self.engine.high:
            return Verdict(status=Status.UNSTABLE, reason="midway", equilibrium_exists=True)
        return Verdict(status=Status.STABLE, reason="", equilibrium_exists=True)

    def load_factor(self, W: Float, accuracy: Accuracy = EXACT) -> Answers:
        raise NotImplementedError


@pytest.mark.parametrize(("low", "high"), [(0.05, 0.45), (0.45, 0.75), (0.75, 1.0)])
def test_a_fall_in_any_third_of_the_lift_is_seen(low: float, high: float) -> None:
    """The rest stands with the body and without it, but not in between: it must not be called safe."""
    bodies = [
        floor(),
        box("post", (0.1, 0.1, 0.1), MASS, (0, 0, 0.05)),
        box("mate", (0.1, 0.1, 0.1), 1, (0.1, 0, 0.05)),
    ]
    removals = Removals(hf.assemble(hf.Scene(bodies, 0.5)), FallsMidway(low, high), Z)
    found = removals.by_forces("post", frozenset(removals.names))
    assert found.answer is Answer.UNSAFE
    assert "of its weight taken" in found.reason
    calm = Removals(removals.assembly, FallsMidway(2.0, 3.0), Z)
    assert calm.by_forces("post", frozenset(removals.names)).answer is Answer.SAFE
