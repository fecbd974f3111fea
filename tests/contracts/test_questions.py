"""How questions are asked: of a scene or an assembly, operands in order, everything else by keyword."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from public_api import public

import holdfast as hf

POINT, ALONG = (-0.05, 0, 0.05), (1, 0, 0)
POSES = np.array([hf.pose(0, 0, 0.05)] * 2)
PUSH = hf.Load("cube", POINT, force=ALONG)
THING = hf.Body("thing", hf.Box((0.03, 0.03, 0.03)), mass=0.1)

QUESTIONS: dict[str, Callable[[Any], Any]] = {
    "stability": lambda a: hf.stability(a, engine="graph").forces.force,
    "stability_of_poses": lambda a: hf.stability_of_poses(a, "cube", POSES, engine="graph").stable,
    "robustness_of_poses": lambda a: hf.robustness_of_poses(a, "cube", POSES, POINT, ALONG, engine="graph").force,
    "robustness": lambda a: hf.robustness(a, "cube", POINT, ALONG, engine="graph").force,
    "load_factor": lambda a: hf.load_factor(a, [PUSH], engine="graph").factor,
    "robustness_map": lambda a: hf.robustness_map(a, spacing=0.05, engine="graph").force,
    "gradients": lambda a: hf.sets.gradients(a, hf.robustness(a, "cube", POINT, ALONG, engine="limit")).force,
    "sensitivity": lambda a: hf.sets.sensitivity(a, "cube", POINT, ALONG).force,
    "worst_case": lambda a: hf.sets.worst_case(a, "cube", POINT, ALONG, mu_range=0.1).force,
    "robustness_under": lambda a: (
        hf.robustness_under(
            a, "cube", POINT, ALONG, uncertain=hf.sets.Uncertain(samples=2, mu_range=0.2), engine="graph"
        ).force
    ),
    "admissible_wrenches": lambda a: hf.sets.admissible_wrenches(a, "cube", accuracy=0.5).vertices,
    "constraint": lambda a: hf.sets.constraint(a, "cube", solves=50).known,
    "sustainable_accelerations": lambda a: hf.sets.sustainable_accelerations(a, accuracy=0.2).vertices,
    "transport_limits": lambda a: hf.transport_limits(a, ALONG, engine="graph").acceleration,
    "fastest_carry": lambda a: hf.sets.fastest_carry(a, [(0, 0), (1, 0)], engine="limit").profile.time,
    "friction_from": lambda a: (
        hf.friction_from(a, [("cube", POINT, ALONG, 1.0)], scatter=0.1, engine="graph").predicted
    ),
    "transport_under": lambda a: (
        hf.transport_under(a, ALONG, hf.sets.Uncertain(samples=2, mass_range=0.2), engine="graph").acceleration
    ),
    "Monitor": lambda a: hf.Monitor(a, seconds=100, solves=30).update(ALONG).margin,
    "inertial_loads": lambda a: hf.sets.inertial_loads(a, acceleration=(1, 0, 0))[0].force,
    "disassembly_order": lambda a: hf.disassembly_order(a, engine="graph").order,
    "can_remove": lambda a: hf.can_remove(a, "cube", engine="graph").reason,
    "build_order": lambda a: hf.build_order(a, engine="graph", pushes=30).force,
    "plan_placement": lambda a: (
        hf.plan_placement(a, THING, search=hf.Search(solves=2, confirm=None), engine="graph").pose
    ),
}
OPERANDS = {
    "assembly", "body", "bodies", "point", "points", "direction", "directions", "loads", "tilt", "count",
    "accelerations", "limits", "poses", "scene", "obj", "where", "approach", "search", "uncertain", "tilt_degrees",
    "measured", "answer", "waypoints",
}  # fmt: skip


@pytest.mark.parametrize("name", QUESTIONS)
def test_a_scene_is_assembled_with_default_tolerances(name: str) -> None:
    scene = hf.shipped_scene("cube")
    np.testing.assert_array_equal(QUESTIONS[name](scene), QUESTIONS[name](hf.assemble(scene)))


@pytest.mark.parametrize("name", QUESTIONS)
def test_anything_else_is_refused_with_the_way_to_an_assembly(name: str) -> None:
    with pytest.raises(hf.HoldfastError, match=r"assembly: got a str; needs an Assembly: hf\.assemble"):
        QUESTIONS[name]("cube")


@pytest.mark.parametrize("name", [*QUESTIONS, "assemble", "safe_time_scale"])
def test_options_are_given_by_keyword(name: str) -> None:
    parameters = inspect.signature(public(name)).parameters.values()
    assert {p.name for p in parameters if p.kind is not p.KEYWORD_ONLY} <= OPERANDS


@pytest.mark.parametrize("name", QUESTIONS)
def test_seeds_and_engines_have_defaults(name: str) -> None:
    for option, parameter in inspect.signature(public(name)).parameters.items():
        if option == "seed":
            assert parameter.default == 0
        if option == "engine":
            assert parameter.kind is parameter.KEYWORD_ONLY
            assert parameter.default in ("compliant", "limit")


def test_loads_are_values() -> None:
    one, other = hf.Load("cube", POINT, force=ALONG), hf.Load("cube", np.array(POINT), force=list(ALONG))
    assert one == other
    assert len({one, other, hf.Load("cube", moment=(0, 0, 1))}) == 2
    with pytest.raises(ValueError, match="read-only"):
        one.force[0] = 2
