"""Constants of the amendments and of engine ``compliant``: moved by a factor of three, each changes a small scene.

Where a move in one direction only can be seen, only that one is asked for.
"""

from __future__ import annotations

import importlib
import sys
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import holdfast as hf
from bench.scenes.random_pushes import columns, random_pushes
from holdfast.base.rigid import pose_from
from holdfast.engines.answers import Answers
from holdfast.engines.compliant.engine import Compliant
from holdfast.engines.compliant.random_faces import Faces
from holdfast.engines.compliant.rough import Rough
from holdfast.engines.contract import Engine
from holdfast.engines.groups import prepared
from holdfast.scene.shipped.blocks import box, floor

IMPORTED = ("MATTERS",)  # by other modules
UP, DOWN = 3.0, 1 / 3
BOTH = (UP, DOWN)


def pushed(scene: str, engine: Engine) -> Answers:
    """Eight pushes on a shipped scene, up to 60 degrees aslant."""
    assembly = hf.assemble(hf.shipped_scene(scene))
    W = columns(assembly, random_pushes(assembly, np.random.default_rng(0), 8, slant=60))
    return prepared(engine, assembly).load_factor(W)


def grooved() -> Answers:
    """A cube in a groove: its own weight spreads it, and a push may jam it."""
    return pushed("v_groove", Compliant())


def wedged() -> Answers:
    """A cube that two walls press without any load."""
    return pushed("wedged_floor", Compliant())


def leaning() -> Answers:
    """A rough box whose seen pose may be tilted by two degrees."""
    scene = hf.Scene([floor(4, 4), box("box", (0.1, 0.1, 0.16), 1, (0, 0, 0.08))], 2.0)
    assembly = hf.assemble(scene, pose_sigma=(0.0015, 0.5))
    return hf.robustness(assembly, "box", (-0.05, 0, 0.16), (1, 0.2, 0), engine="limit").answers


def turned() -> Answers:
    """The same box, turned about the vertical: it leans over an edge that no axis is along."""
    half = np.array([np.cos(0.1), 0, 0, np.sin(0.1)])
    body = hf.Body("box", hf.Box((0.1, 0.1, 0.16)), mass=1, pose=pose_from(np.array([0, 0, 0.08]), half))
    assembly = hf.assemble(hf.Scene([floor(4, 4), body], 2.0), pose_sigma=(0.0015, 0.5))
    return hf.robustness(assembly, "box", (0, 0, 0.16), (1, 0, -0.1), engine="limit").answers


def rough(flatness: float) -> Answers:
    """A table whose faces are not flat."""
    return pushed("table", Rough(Compliant(), Faces(hf.Imperfect(flatness, 2e9, seed=1), 0)))


def seen(answers: Answers) -> tuple[Any, ...]:
    """All of the answers that a user sees."""
    numbers = (np.round(a, 9).tolist() for a in (answers.force, answers.lower))
    return (*numbers, answers.status.tolist(), answers.notes)


A, C = "holdfast.engines.amendments.", "holdfast.engines.compliant."
CASES: list[tuple[str, str, Callable[[], Answers], tuple[float, ...]]] = [
    (A + "amendment", "MATTERS", wedged, (UP,)),
    (A + "pose_allowance", "STEEPEST", leaning, (DOWN,)),
    (A + "pose_allowance", "DIRECTIONS", turned, (UP,)),
    (A + "self_stressed", "JAMMED", grooved, (DOWN,)),
    (C + "elastic_model", "ROUGHEST", lambda: rough(0.05), BOTH),
    (C + "random_faces", "WAVES", lambda: rough(5e-5), BOTH),
    (C + "random_faces", "PATCH_SHARE", lambda: rough(5e-5), BOTH),
    (C + "random_faces", "LATTICE", lambda: rough(5e-5), BOTH),
]


@pytest.mark.parametrize(
    ("module", "name", "scene", "factor"),
    [
        pytest.param(module, name, scene, factor, id=f"{module.rsplit('.', 1)[1]}.{name} x {factor:.3g}")
        for module, name, scene, factors in CASES
        for factor in factors
    ],
)
def test_a_moved_constant_changes_an_answer(
    monkeypatch: pytest.MonkeyPatch, module: str, name: str, scene: Callable[[], Answers], factor: float
) -> None:
    before, value = seen(scene()), getattr(importlib.import_module(module), name)
    moved = max(1, round(value * factor)) if isinstance(value, int) else value * factor
    for other in [one for key, one in sys.modules.items() if key.startswith("holdfast.engines.")]:
        if vars(other).get(name) is value and (other.__name__ == module or name in IMPORTED):
            monkeypatch.setattr(other, name, moved)
    assert seen(scene()) != before
