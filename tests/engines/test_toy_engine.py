"""An engine of one's own: one class with ``prepare``, one with ``verdict`` and ``load_factor``; the rest is there."""

from __future__ import annotations

import json
import pickle
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import holdfast as hf
from holdfast import Status
from holdfast.answers import Assembly, Bound, Claim
from holdfast.base.arrays import Float
from holdfast.cli.main import app
from holdfast.plugins import EXACT, Accuracy, Answers, Engine, State, Verdict, register_engine


@dataclass(frozen=True)
class ToyState:
    """Bodies stand wherever they are, and each is carried off by a force of ``share`` of the total weight."""

    engine: Toy
    assembly: Assembly

    @property
    def notes(self) -> tuple[str, ...]:
        return ("a toy",)

    def verdict(self) -> Verdict:
        return Verdict(status=Status.STABLE, reason="toys always stand", equilibrium_exists=True)

    def load_factor(self, W: Float, accuracy: Accuracy = EXACT) -> Answers:
        pushed = np.linalg.norm(W.reshape(-1, 6, W.shape[1])[:, :3], axis=1).sum(0)
        with np.errstate(divide="ignore"):
            force = self.engine.share * self.assembly.weight / pushed
        return Answers.of(
            engine=self.engine.name,
            claim=self.engine.claim,
            verdict=self.verdict(),
            force=force,
            lower=force / 2,
            status=[Status.INFINITE if np.isinf(f) else Status.FINITE for f in force],
            mechanism=[None] * len(force),
            lower_bound=Bound.ESTIMATED,
            notes=self.notes,
        )


@dataclass(frozen=True)
class Toy:
    share: float = 0.5

    name = "toy"
    claim = Claim.ESTIMATED

    def prepare(self, assembly: Assembly, standing: Float | None = None, acceleration: Float | None = None) -> ToyState:
        return ToyState(self, assembly)


@pytest.fixture
def toy() -> Iterator[str]:
    take_back = register_engine("toy", Toy)
    yield "toy"
    take_back()
    with pytest.raises(hf.HoldfastError, match="engine: 'toy' is unknown"):
        hf.stability(hf.shipped_scene("cube"), engine="toy")


def test_it_is_an_engine_for_type_checkers() -> None:
    engine: Engine = Toy()
    state: State = engine.prepare(hf.assemble(hf.shipped_scene("cube")))
    assert state.verdict().status is hf.Status.STABLE


@pytest.mark.parametrize("share", [0.5, 2.0])
def test_it_answers_all_questions_that_need_no_more(share: float, tmp_path: Path) -> None:
    stack, engine = hf.assemble(hf.shipped_scene("stack")), Toy(share)
    assert hf.stability(stack, engine=engine).reason == "toys always stand"
    body = stack.movable[0]
    point = body.com_world - [body.size / (2 * np.sqrt(3)), 0, 0]
    r = hf.robustness(stack, body.name, point, (1, 0, 0), engine=engine)
    assert r.force == pytest.approx([share * stack.weight])
    assert (r.engine, r.claim, r.lower_bound, r.notes) == ("toy", Claim.ESTIMATED, Bound.ESTIMATED, ("a toy",))
    m = hf.robustness_map(stack, spacing=0.05, engine=engine)
    assert m.force == pytest.approx(np.full(len(m.force), share * stack.weight))
    assert m.weakest().force == pytest.approx(share * stack.weight)
    m.save_png(tmp_path / "map.png")
    for value in (r, m):
        value.save(tmp_path / "answer.npz")
        assert hf.load_answer(tmp_path / "answer.npz") == value
        assert pickle.loads(pickle.dumps(value)) == value
    t = hf.transport_limits(stack, [(1, 0, 0), (0, 1, 0)], engine=engine)
    assert t.acceleration == pytest.approx(np.full(2, share * 9.81))
    assert hf.load_factor(stack, [], engine=engine).factor == np.inf
    u = hf.robustness_under(
        stack, body.name, point, (1, 0, 0), uncertain=hf.sets.Uncertain(mu_range=0.1, samples=2, seed=0), engine=engine
    )
    assert u.median == pytest.approx([share * stack.weight])


def test_a_name_makes_it_known_everywhere(toy: str) -> None:
    assert hf.stability(hf.shipped_scene("cube"), engine=toy).engine == "toy"
    done = CliRunner().invoke(app, ["assess", "cube", "--engine", toy, "--json"])
    assert done.exit_code == 0
    assert json.loads(done.stdout)["reason"] == "toys always stand"
    done = CliRunner().invoke(app, ["map", "cube", "--engine", toy, "--spacing", "0.05", "--json"])
    assert json.loads(done.stdout)["details"]["weakest"]["force"] == pytest.approx(0.5 * 9.81)


def test_a_name_is_given_once_and_may_be_taken_back(toy: str) -> None:
    for name in (toy, "limit"):
        with pytest.raises(hf.HoldfastError, match=f"engine: there is one named '{name}'; give it another name"):
            register_engine(name, Toy)
    take_back = register_engine("toy2", Toy)
    take_back()
    take_back()
    with pytest.raises(hf.HoldfastError, match="engine: 'toy2' is unknown"):
        hf.stability(hf.shipped_scene("cube"), engine="toy2")
