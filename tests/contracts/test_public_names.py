"""The public names, their arguments and the attributes of results, as the design writes them."""

from __future__ import annotations

import inspect
import subprocess
import sys
from types import UnionType
from typing import Any

import numpy as np
import pytest
from public_api import NAMES, public

import holdfast as hf
from holdfast.scene.shipped.blocks import table

TOP = (0.0, 0.0, 0.25)
DOWN = (0.0, 0.0, -1.0)
EDGE = (0.2499, 0.0, 0.25)


@pytest.fixture(scope="module")
def assembly() -> hf.answers.Assembly:
    return hf.assemble(table())


HINTS = {
    "plan_placement": ("supports", "where=Where"),
    "place_all": ("seconds", "search=Search"),
    "robustness_under": ("samples", "uncertain=Uncertain"),
    "batch": ("megabytes", "resources=Resources"),
}


@pytest.mark.parametrize("name", HINTS)
def test_an_option_that_is_a_field_of_a_value_is_told_with_the_value(name: str) -> None:
    option, value = HINTS[name]
    with pytest.raises(TypeError, match=rf"{name}\(\) got an unexpected .* {value}\({option}=\.\.\.\)"):
        getattr(hf, name)(None, **{option: 1})


@pytest.mark.parametrize(
    ("name", "defaults"),
    [
        ("robustness_map", {"spacing": 0.01}),
        ("Uncertain", {"samples": 200, "seed": 0}),
        ("Graph", {"nodes": 20, "isolated": False, "sampling": "hull"}),
        ("Compliant", {"nodes": 7, "stiffness_ratio": 1.0}),
    ],
)
def test_numbers_that_nobody_gave_are_these(name: str, defaults: dict[str, Any]) -> None:
    parameters = inspect.signature(public(name)).parameters
    assert {option: parameters[option].default for option in defaults} == defaults


@pytest.mark.parametrize("name", NAMES)
def test_every_public_name_is_documented(name: str) -> None:
    assert inspect.getdoc(NAMES[name]) or isinstance(NAMES[name], UnionType)


def test_errors_are_one_family() -> None:
    for error in (hf.errors.SceneError, hf.errors.GeometryError, hf.errors.SolverError):
        assert issubclass(error, hf.HoldfastError)
    assert issubclass(hf.HoldfastError, Exception)
    assert issubclass(hf.errors.HoldfastWarning, UserWarning)


def questions(assembly: hf.answers.Assembly, **options: Any) -> dict[str, Any]:
    return {
        "stability": hf.stability(assembly, **options),
        "robustness": hf.robustness(assembly, "slab", EDGE, DOWN, **options),
        "load_factor": hf.load_factor(assembly, [hf.Load("slab", EDGE, force=DOWN)], **options),
        "robustness_map": hf.robustness_map(assembly, ["slab"], spacing=0.05, **options),
        "transport_limits": hf.transport_limits(assembly, (1, 0, 0), **options),
    }


@pytest.mark.parametrize("engine", ["graph", hf.Graph(), hf.Graph(nodes=12, isolated=True, sampling="quadrature")])
def test_every_answer_names_its_engine_and_claim(assembly: hf.answers.Assembly, engine: Any) -> None:
    for answer in questions(assembly, engine=engine).values():
        assert answer.engine == "graph"
        assert answer.claim is hf.answers.Claim.ESTIMATED
        assert isinstance(answer.notes, tuple)


@pytest.mark.parametrize(
    "ask",
    [
        lambda a: hf.stability(a),
        lambda a: hf.robustness(a, "slab", TOP, DOWN),
        lambda a: hf.load_factor(a, [hf.Load("slab", TOP, force=DOWN)]),
        lambda a: hf.robustness_map(a, spacing=0.1),
    ],
)
def test_the_engine_whose_answers_hold_is_the_default(assembly: hf.answers.Assembly, ask: Any) -> None:
    answer = ask(assembly)
    assert answer.engine == "compliant"
    assert answer.claim is hf.answers.Claim.HOLDS


def test_stability_has_its_attributes(assembly: hf.answers.Assembly) -> None:
    s = hf.stability(assembly, engine="graph")
    assert s.status is hf.Status.STABLE
    assert s.equilibrium_exists is True
    assert s.self_stress is False
    assert 0 <= s.residual < 1e-7
    assert (s.moving, s.mechanism, s.certificate) == ((), None, None)
    assert s.forces.force.shape == s.forces.points.shape == s.forces.normal.shape


@pytest.mark.parametrize(
    ("points", "directions", "n"),
    [
        (TOP, DOWN, 1),
        ([TOP], [DOWN], 1),
        ([TOP, EDGE], DOWN, 2),
        (TOP, [DOWN, (0, 0, 1), (0, 1, 0)], 3),
        (np.array([TOP, EDGE]), np.array([DOWN, DOWN]), 2),
    ],
)
def test_robustness_takes_one_or_many(assembly: hf.answers.Assembly, points: Any, directions: Any, n: int) -> None:
    r = hf.robustness(assembly, body="slab", points=points, directions=directions, standing=(), engine="graph")
    assert r.force.shape == r.lower.shape == r.upper.shape == (n,)
    assert len(r.status) == len(r.moving) == len(r.mode) == n
    assert r.points.shape == r.directions.shape == (n, 3)
    assert (r.lower == 0).all()
    assert np.isposinf(r.upper).all()
    assert not np.isnan(r.force).any()
    for status, mode, force in zip(r.status, r.mode, r.force, strict=True):
        assert status in (hf.Status.FINITE, hf.Status.INFINITE)
        assert mode in ("slip", "topple", "mixed", "none")
        assert (mode == "none") == np.isinf(force)


def test_directions_need_no_unit_length(assembly: hf.answers.Assembly) -> None:
    one, seven = (
        hf.robustness(assembly, "slab", EDGE, length * np.array(DOWN), engine="graph").force for length in (1, 7)
    )
    assert one == pytest.approx(seven, rel=1e-12)


@pytest.mark.parametrize("off", [0.001, 0.1])
def test_a_point_off_the_surface_raises(assembly: hf.answers.Assembly, off: float) -> None:
    match = rf"'slab': point 1 at \[.*\] is {off * 1e3:g} mm from the surface; needs points on the body \(tolerance"
    with pytest.raises(hf.errors.SceneError, match=match):
        hf.robustness(assembly, "slab", [TOP, (0, 0, 0.25 + off)], DOWN, engine="graph")


def test_a_point_within_the_tolerance_is_taken(assembly: hf.answers.Assembly) -> None:
    near = (0, 0, 0.25 + 0.9 * assembly.tolerances.gap)
    assert hf.robustness(assembly, "slab", near, DOWN, engine="graph").status[0] is hf.Status.INFINITE


@pytest.mark.parametrize(
    ("options", "match"),
    [
        ({"directions": (0, 0, 0)}, r"is zero; needs vectors"),
        ({"points": (0, 0)}, r"points: has shape \(2,\); needs"),
        ({"points": [[0, 0, 1], [1]]}, r"points: got .*; needs"),
        ({"points": (0, 0, float("nan"))}, r"points: contains nan at index \(2,\); needs"),
        ({"points": np.zeros((2, 3)), "directions": np.ones((3, 3))}, r"2 points and 3 directions; needs"),
        ({"points": np.zeros((0, 3)), "directions": np.zeros((0, 3))}, r"points.*; needs"),
        ({"body": "slb"}, r"'slb'; did you mean 'slab'"),
        ({"engine": "grap"}, r"engine: 'grap' is unknown; known: graph"),
        ({"engine": hf.Graph(nodes=2)}, r"2 nodes an interface; needs"),
        ({"engine": hf.Graph(sampling="grid")}, r"sampling = 'grid'; needs"),
    ],
)
def test_a_query_that_makes_no_sense_is_refused(
    assembly: hf.answers.Assembly, options: dict[str, Any], match: str
) -> None:
    query = {"body": "slab", "points": TOP, "directions": DOWN, "engine": "graph"}
    with pytest.raises(hf.HoldfastError, match=match):
        hf.robustness(assembly, **{**query, **options})


@pytest.mark.parametrize(
    ("options", "match"),
    [
        ({"mass_margin": 1.0}, r"mass_margin = 1; needs 0 <= mass_margin < 1"),
        ({"mass_margin": -0.1}, r"mass_margin: is -0\.1; needs"),
        ({"immobile_above": 0}, r"immobile_above: is 0; needs"),
    ],
)
def test_an_engine_option_that_makes_no_sense_is_refused(options: dict[str, Any], match: str) -> None:
    with pytest.raises(hf.HoldfastError, match=match):
        hf.Graph(**options)


def test_answers_are_the_same_bit_for_bit_every_time() -> None:
    first, second = (questions(hf.assemble(table()), engine="graph") for _ in range(2))
    assert first["stability"].forces.force.tobytes() == second["stability"].forces.force.tobytes()
    assert first["robustness"].force.tobytes() == second["robustness"].force.tobytes()
    assert first["load_factor"].factor == second["load_factor"].factor
    for name in ("points", "normals", "force", "lower", "upper"):
        ours, theirs = (getattr(m["robustness_map"], name) for m in (first, second))
        assert ours.tobytes() == theirs.tobytes()


def test_results_cannot_be_changed(assembly: hf.answers.Assembly) -> None:
    for answer in questions(assembly, engine="graph").values():
        with pytest.raises(AttributeError):
            answer.engine = "other"


def test_import_is_light() -> None:
    heavy = (
        *("numpy", "scipy", "clarabel", "trimesh", "pydantic", "matplotlib", "viser", "pyvista", "mujoco"),
        *("pybullet", "typer", "rich", "holdfast.drawing", "holdfast.cli"),
    )
    front = "holdfast, holdfast.answers, holdfast.sets, holdfast.plugins, holdfast.errors"
    code = f"import sys, {front}; print([m for m in {heavy!r} if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
