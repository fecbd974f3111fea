"""Published block assemblies: whether an equilibrium exists is known."""

from __future__ import annotations

import warnings

import pytest
import shared

import holdfast as hf


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
