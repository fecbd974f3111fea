"""Engines stay prepared with an assembly: the next question costs the solve alone, and its answer is the same."""

from __future__ import annotations

import copy
import pickle
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import pytest

import holdfast as hf
from holdfast.engines.groups import prepared
from holdfast.scene.shipped import shipped_scene
from holdfast.scene.shipped.blocks import box, floor

ENGINES = ("graph", "limit", "compliant")

pytestmark = pytest.mark.filterwarnings("ignore::holdfast.errors.HoldfastWarning")


def counted(monkeypatch: pytest.MonkeyPatch, kind: type) -> list[str]:
    calls: list[str] = []
    prepare = kind.prepare

    def counting(self: Any, assembly: hf.answers.Assembly, *loads: Any) -> Any:
        calls.append(",".join(sorted(body.name for body in assembly.movable)))
        return prepare(self, assembly, *loads)

    monkeypatch.setattr(kind, "prepare", counting)
    return calls


def top(assembly: hf.answers.Assembly, name: str) -> Any:
    return assembly.scene.body(name).box[1] * [0, 0, 1] + assembly.scene.body(name).com_world * [1, 1, 0]


def bits(found: Any) -> tuple[Any, ...]:
    told = found.answers
    arrays = (told.force, told.lower, told.upper)
    return (*(a.tobytes() for a in arrays), told.status.tolist(), told.moving.tolist(), told.notes)


def gates() -> hf.Scene:
    """Two gates, a lintel 1 on posts 0 and 2 each: forces run around loops, so that no tree spares the engine."""
    bodies = []
    for k, gate in enumerate("ab"):
        posts = [box(f"{gate}{n}", (0.05, 0.1, 0.1), 1, (0.4 * k + 0.05 * (n - 1), 0, 0.05)) for n in (0, 2)]
        bodies += [posts[0], box(f"{gate}1", (0.15, 0.1, 0.1), 1, (0.4 * k, 0.01, 0.15)), posts[1]]
    return hf.Scene([floor(), *bodies], 0.5)


@pytest.mark.parametrize("kind", [hf.Graph, hf.Limit, hf.Compliant])
def test_a_group_is_prepared_once_for_all_questions(monkeypatch: pytest.MonkeyPatch, kind: type) -> None:
    calls = counted(monkeypatch, kind)
    assembly, engine = hf.assemble(gates()), kind()
    hf.robustness(assembly, "a1", top(assembly, "a1"), [0, 0.1, 1.0], engine=engine)
    hf.robustness_map(assembly, ["a1"], spacing=0.05, engine=kind())
    hf.load_factor(assembly, [hf.Load("a1", top(assembly, "a1"), force=(1.0, 0, 0))], engine=engine)
    hf.stability(assembly, engine=engine)
    assert calls.count("a0,a1,a2") == 1
    assert calls.count("b0,b1,b2") == 1
    hf.stability(assembly, loads=[hf.Load("b1", top(assembly, "b1"), force=(0.1, 0, 0))], engine=engine)
    assert (calls.count("a0,a1,a2"), calls.count("b0,b1,b2")) == (1, 2)  # loads concern their group alone


@pytest.mark.parametrize("engine", ENGINES)
def test_no_answer_depends_on_what_was_asked_before(engine: str) -> None:
    """Certified maps draw on all solves of one query, but not on those of another."""
    names = ["slab", "leg_left"]
    scene = shipped_scene("table")
    alone = [bits(hf.robustness_map(hf.assemble(scene), [name], spacing=0.05, engine=engine)) for name in names]
    shared = hf.assemble(scene)
    for _ in range(2):
        assert [bits(hf.robustness_map(shared, [name], spacing=0.05, engine=engine)) for name in names] == alone


@pytest.mark.parametrize("sigma", [None, (0.002, 0.5)])
@pytest.mark.parametrize("engine", ENGINES)
def test_threads_that_ask_one_assembly_get_what_one_after_the_other_gets(engine: str, sigma: Any) -> None:
    scene = shipped_scene("stack")
    names = [body.name for body in scene.movable]

    def ask(assembly: hf.answers.Assembly, k: int) -> Any:
        name = names[k % len(names)]
        direction = ([1.0, 0, 0], [0.3, 1.0, 0.1])[k // len(names) % 2]
        points = assembly.scene.body(name).surface_world.vertices[:3]
        return bits(hf.robustness(assembly, name, points, direction, engine=engine))

    count = 2 * len(names)
    alone = [ask(hf.assemble(scene, pose_sigma=sigma), k) for k in range(count)]
    together = hf.assemble(scene, pose_sigma=sigma)
    with ThreadPoolExecutor(4) as pool:
        assert list(pool.map(lambda k: ask(together, k), range(2 * count))) == alone + alone


def test_assemblies_travel_without_what_is_kept() -> None:
    assembly = hf.assemble(gates())
    size = len(pickle.dumps(assembly))
    hf.stability(assembly)
    assert len(assembly.memory) > 0
    assert len(pickle.dumps(assembly)) == size
    for other in (pickle.loads(pickle.dumps(assembly)), copy.deepcopy(assembly)):
        assert other == assembly
        assert len(other.memory) == 0


def test_a_name_of_a_larger_assembly_is_unknown_in_the_smaller_one() -> None:
    """Both share what is prepared, yet an engine that names the added body is refused where it is not."""
    smaller = hf.assemble(gates())
    larger = smaller.with_body(box("c", (0.1, 0.1, 0.1), 1, (-0.3, 0, 0.05)))
    engine = hf.Compliant(stiffness={("c", "a0"): 1e8})
    hf.stability(larger, engine=engine)
    with pytest.raises(hf.errors.SceneError, match="unknown"):
        hf.stability(smaller, engine=engine)
    hf.stability(larger, engine=engine)


def test_engines_that_are_no_values_are_prepared_anew() -> None:
    calls = []

    class Own:
        name, claim = "own", hf.Limit().claim

        def prepare(self, assembly: hf.answers.Assembly, standing: Any = None, acceleration: Any = None) -> Any:
            calls.append(1)
            return hf.Limit().prepare(assembly, standing, acceleration)

    assembly, engine = hf.assemble(gates()), Own()
    for _ in range(2):
        hf.stability(assembly, engine=engine)
    assert len(calls) == 4


def test_what_was_stopped_half_way_is_not_asked_again(monkeypatch: pytest.MonkeyPatch) -> None:
    assembly = hf.assemble(gates())
    groups = prepared(hf.Limit(), assembly)
    state = groups.group_with(0).state
    W = np.zeros((24, 1))
    W[0] = 1.0
    kept = len(assembly.memory)

    def stopped(*_: Any) -> Any:
        raise KeyboardInterrupt

    monkeypatch.setattr(type(state), "load_factor", stopped)
    with pytest.raises(KeyboardInterrupt):
        groups.load_factor(W)
    assert len(assembly.memory) == kept - 1
