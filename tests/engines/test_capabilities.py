"""What only some engines can do: offered by a method alone, asked for by name, refused in words."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

import holdfast as hf
from holdfast.assembly.assembly import Assembly
from holdfast.assembly.contact_nodes import NO_NODES
from holdfast.base.arrays import Float
from holdfast.engines.answers import Answers, Claim
from holdfast.engines.contract import (
    EXACT,
    GRADIENTS,
    RELEASES,
    SETS,
    WORST_CASES,
    Accuracy,
    Capability,
    Gradient,
    LoadSet,
)
from holdfast.engines.verdict import Status, Verdict
from holdfast.queries import request
from holdfast.scene.shipped import shipped_scene


@dataclass(frozen=True)
class ToyState:
    """All stands, and carries whatever lies in a cross-polytope of half the box."""

    notes: tuple[str, ...] = ("a toy",)

    def verdict(self) -> Verdict:
        return Verdict(status=Status.STABLE, reason="it is a toy", equilibrium_exists=True)

    def load_factor(self, W: Float, accuracy: Accuracy = EXACT) -> Answers:
        raise NotImplementedError

    def load_set(self, columns: Float, accuracy: float, solves: int | None, where: str) -> LoadSet:
        d = columns.shape[1]
        signs = np.array(np.meshgrid(*[[-1.0, 1.0]] * d)).reshape(d, -1).T
        return LoadSet(2 * signs, 2 * signs, np.vstack([np.eye(d), -np.eye(d)]) / 2, 0.0, np.eye(d)[0], 7)

    def gradient(self, load: Float, where: str) -> Gradient:
        J = len(load) // 6
        answers = Answers.of(
            engine="toy",
            claim=Claim.ESTIMATED,
            verdict=self.verdict(),
            force=np.array([2.0]),
            status=[Status.FINITE],
            mechanism=[None],
        )
        return Gradient(
            answers=answers,
            assembly=hf.assemble(hf.shipped_scene("cube")),
            nodes=NO_NODES,
            forces=np.zeros((0, 3)),
            twists=np.ones((J, 6)),
            d_mu={},
            d_mass=np.full(J, 3.0),
            d_com=np.zeros((J, 3)),
        )


@dataclass(frozen=True)
class ToyEngine:
    name = "toy"
    claim = Claim.ESTIMATED

    def prepare(self, assembly: Assembly, standing: Float | None = None, acceleration: Float | None = None) -> ToyState:
        return ToyState()


def test_sets_come_from_whatever_engine_is_the_certain_one(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(request, "ENGINES", {**request.ENGINES, request.CERTAIN_ENGINE: ToyEngine})
    found = hf.sets.sustainable_accelerations(hf.assemble(shipped_scene("cube")), exists=True, box=8.0)
    assert (found.engine, found.claim, found.solves, found.notes) == ("toy", Claim.ESTIMATED, 7, ("a toy",))
    assert found.exists([3.9, 0, 0]) is True
    assert found.exists([4.1, 0, 0]) is False


def test_derivatives_come_from_whatever_engine_is_the_certain_one(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(request, "ENGINES", {**request.ENGINES, request.CERTAIN_ENGINE: ToyEngine})
    found = hf.sets.sensitivity(hf.assemble(shipped_scene("cube")), "cube", [-0.05, 0, 0.02], [1.0, 0, 0])
    assert found.force == 2.0
    assert found.d_mass == {"cube": 3.0}
    np.testing.assert_array_equal(found.d_point, [0, 2, -2])  # -R e × ω


@pytest.mark.parametrize(
    ("capability", "lacks"),
    [
        (SETS, "here: engine 'graph' proves nothing about loads that it was not asked; use engine='limit'"),
        (GRADIENTS, "here: engine 'graph' gives no derivatives; use engine='limit'"),
        (WORST_CASES, "here: engine 'graph' proves nothing about a box of masses and centres of mass; use"),
        (RELEASES, "here: engine 'graph' proves of no body that it comes loose; use engine='limit'"),
    ],
)
def test_what_an_engine_lacks_is_told(capability: Capability[object], lacks: str) -> None:
    for offering in (hf.Graph(), hf.Graph().prepare(hf.assemble(shipped_scene("cube")))):
        with pytest.raises(hf.HoldfastError) as error:
            capability.of(offering, engine="graph", where="here")
        assert str(error.value).startswith(lacks)
