"""Published assemblies by engines ``limit`` and ``compliant``: whether an equilibrium exists, and whether it holds."""

from __future__ import annotations

import json
import warnings
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import holdfast as hf
from holdfast import Status

CASES = Path(__file__).parents[3] / "shared" / "cases"
LARGE = {"armadillo": [pytest.mark.slow]}  # tests/cases looks at it by default
PUBLISHED = [
    pytest.param(p, id=p.stem, marks=LARGE.get(p.stem, [])) for p in sorted((CASES / "published").glob("*.json"))
]
needed = pytest.mark.skipif(not PUBLISHED, reason=f"needs the case files in {CASES}")
STAND_UNCHECKED = {"bridge", "snake", "shelf_stable", "concave_long_0", "cube_curve_short", "armadillo"}
SELF_STRESSED = {"model_A", "wedge_a_x90", "wedge_a_xy3090"}
ANGLE = {"cube_curve_short": 5.0}  # its faces are warped


@cache
def case(path: Path) -> tuple[dict[str, Any], hf.Scene]:
    return json.loads(path.read_text()), hf.load_scene(path)


def check(path: Path, assembly: hf.answers.Assembly) -> None:
    expected = case(path)[0]["expected"]
    exists = hf.stability(assembly, engine="limit")
    assert exists.equilibrium_exists is expected["equilibrium_exists"]
    if expected["stands"] is False:
        assert exists.status is not Status.STABLE
    if exists.equilibrium_exists:
        assert exists.residual < 1e-7
        assert exists.status is Status.STABLE or exists.self_stress
    else:
        assert exists.status is Status.UNSTABLE
        assert exists.certificate is not None
        assert exists.certificate.power > 0
        assert exists.certificate.violation < 1e-6
    stands = expected["stands"] if expected["stands"] is not None else path.stem in STAND_UNCHECKED
    holds = hf.stability(assembly, engine="compliant")
    assert holds.status is (Status.STABLE if stands else Status.UNSTABLE)
    if stands:
        assert holds.residual <= 1e-8
        forces = holds.forces
        assert forces is not None
        assert (np.einsum("ix,ix->i", forces.force, forces.normal) >= 0).all()
        assert forces.usage.max() <= 1 + 1e-9
    else:
        assert holds.moving
        assert holds.equilibrium_exists is expected["equilibrium_exists"]
        assert (holds.certificate is None) == (path.stem in SELF_STRESSED)


@needed
@pytest.mark.parametrize("path", PUBLISHED)
def test_published_interfaces(path: Path) -> None:
    data, scene = case(path)
    given = [hf.answers.Interface(tuple(i["between"]), i["polygon"], i["normal"]) for i in data["interfaces"]]
    check(path, hf.assemble(scene, interfaces=given))


@needed
@pytest.mark.parametrize("path", PUBLISHED)
def test_detected_interfaces(path: Path) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", hf.errors.HoldfastWarning)
        if path.stem == "armadillo":  # its blocks overlap; such contacts are not modelled, and it says so
            assert hf.stability(hf.assemble(case(path)[1]), engine="limit").status is Status.UNDECIDED
        else:
            check(path, hf.assemble(case(path)[1], angle_degrees=ANGLE.get(path.stem)))
