"""Published block assemblies: whether an equilibrium exists is known."""

from __future__ import annotations

import warnings
from pathlib import Path

import pytest
import shared

import holdfast as hf

LARGE = {"armadillo"}  # 366 bodies, 10 to 20 s each time: by default its contacts are compared, and it stands by limit

OWN_DETECTION_DIFFERS = {
    # 385 pairs of its blocks overlap by 1 to 55 times the gap; such contacts are not modelled, and it says so
    "armadillo": hf.Status.UNDECIDED,
}


@shared.needed
@pytest.mark.parametrize("path", shared.paths("published", slow=LARGE))
def test_an_equilibrium_exists_on_the_published_interfaces_where_it_should(path: Path) -> None:
    data = shared.contents(path)
    interfaces = [hf.answers.Interface(tuple(i["between"]), i["polygon"], i["normal"]) for i in data["interfaces"]]
    assembly = hf.assemble(hf.load_scene(path), interfaces=interfaces)
    assert len(assembly.interfaces) == len(data["interfaces"])
    result = hf.stability(assembly, engine="graph")
    assert result.equilibrium_exists is data["expected"]["equilibrium_exists"]
    if result.equilibrium_exists:
        assert result.residual < 1e-7
    else:
        assert result.certificate.power > 0
        assert result.certificate.violation < 1e-6


@shared.needed
@pytest.mark.parametrize("path", shared.paths("published", slow=LARGE))
def test_an_equilibrium_exists_on_detected_interfaces_where_it_should(path: Path) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", hf.errors.HoldfastWarning)
        assembly = hf.assemble(hf.load_scene(path))
    result = hf.stability(assembly, engine="graph")
    if path.stem in OWN_DETECTION_DIFFERS:
        assert result.status == OWN_DETECTION_DIFFERS[path.stem]
    else:
        assert result.equilibrium_exists is shared.contents(path)["expected"]["equilibrium_exists"]


@shared.needed
@pytest.mark.parametrize("engine", [pytest.param("graph", marks=pytest.mark.slow), "limit"])
def test_armadillo_stands_on_our_interfaces_at_the_tolerance_its_data_needs(engine: str) -> None:
    """Its blocks have warped faces and overlap by up to 30 mm: at 50 mm and 20 degrees all its contacts are found."""
    (path,) = [p.values[0] for p in shared.paths("published") if p.id == "armadillo"]
    scene = hf.load_scene(path)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", hf.errors.HoldfastWarning)
        assembly = hf.assemble(scene, gap=0.05, angle_degrees=20)
    published = {frozenset(i["between"]) for i in shared.contents(path)["interfaces"]}
    assert {frozenset(i.bodies) for i in assembly.interfaces} == published
    assert hf.stability(assembly, engine=engine).equilibrium_exists is True
