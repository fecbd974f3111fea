"""Stiffness by the names of bodies and of materials: what is looked up first, and what is refused."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest
from engine_scenes import block, floor

import holdfast as hf
from holdfast import Compliant, Scene, assemble
from holdfast.answers import Assembly

Table = dict[tuple[str, str], float]
MATERIALS = {"floor": "stone", "leg0": "steel", "leg1": "rubber", "leg2": "steel", "slab": "wood"}


@pytest.fixture(scope="module")
def table() -> Assembly:
    """A slab on three legs: how much each carries depends on its stiffness."""
    legs = [block(f"leg{k}", (0.05, 0.2, 0.2), (x, 0, 0.1)) for k, x in enumerate((-0.2, 0, 0.2))]
    bodies = [floor(), *legs, block("slab", (0.5, 0.2, 0.05), (0, 0, 0.225), 3.0)]
    return assemble(Scene([replace(body, material=MATERIALS[body.name]) for body in bodies], 0.5))


def carried(assembly: Assembly, stiffness: Table | None) -> list[float]:
    """The vertical force [N] of every interface."""
    forces = hf.stability(assembly, engine=Compliant(stiffness=stiffness)).forces
    assert forces is not None
    return [float(forces.force[forces.interface == k, 2].sum()) for k in range(len(assembly.interfaces))]


def pushed(assembly: Assembly, stiffness: Table | None) -> float:
    found = hf.robustness(assembly, "slab", [(0.2, -0.1, 0.225)], [(0.2, 1, 0)], engine=Compliant(stiffness=stiffness))
    return float(found.force[0])


@pytest.mark.parametrize(
    ("general", "bodies"),
    [
        ({("rubber", "wood"): 3.0}, {("leg1", "slab"): 3.0}),
        ({("wood", "rubber"): 3.0}, {("slab", "leg1"): 3.0}),
        ({("steel", "wood"): 0.2}, {("leg0", "slab"): 0.2, ("leg2", "slab"): 0.2}),
        ({("leg1", "wood"): 3.0, ("stone", "leg1"): 5.0}, {("leg1", "slab"): 3.0, ("floor", "leg1"): 5.0}),
        ({("rubber", "slab"): 3.0}, {("leg1", "slab"): 3.0}),
    ],
)
def test_names_of_materials_count_as_those_of_their_bodies(table: Assembly, general: Table, bodies: Table) -> None:
    assert carried(table, general) == carried(table, bodies)
    assert pushed(table, general) == pushed(table, bodies)
    assert carried(table, general) != pytest.approx(carried(table, None), rel=1e-3)


@pytest.mark.parametrize(
    ("given", "means"),
    [
        ({("steel", "wood"): 0.2, ("leg0", "wood"): 3.0}, {("leg0", "slab"): 3.0, ("leg2", "slab"): 0.2}),
        ({("steel", "wood"): 0.2, ("slab", "steel"): 3.0}, {("leg0", "slab"): 3.0, ("leg2", "slab"): 3.0}),
        (
            {("steel", "wood"): 0.2, ("leg0", "wood"): 9.0, ("leg0", "slab"): 3.0},
            {("leg0", "slab"): 3.0, ("leg2", "slab"): 0.2},
        ),
    ],
)
def test_the_more_special_name_wins(table: Assembly, given: Table, means: Table) -> None:
    assert carried(table, given) == carried(table, means)
    assert carried(table, dict(reversed(given.items()))) == carried(table, means)


def test_bodies_that_do_not_touch_may_be_named(table: Assembly) -> None:
    apart = {("leg0", "leg2"): 5.0, ("floor", "slab"): 7.0}
    assert carried(table, apart) == carried(table, None)


@pytest.mark.parametrize(
    ("stiffness", "match"),
    [
        ({("nosuch", "slab"): 3.0}, r"stiffness of \('nosuch', 'slab'\): unknown name 'nosuch'; known: floor, leg0"),
        ({("slab", "leg4"): 3.0}, r"stiffness of \('leg4', 'slab'\): unknown name 'leg4'; did you mean 'leg"),
        ({("stel", "wood"): 3.0}, r"stiffness of \('stel', 'wood'\): unknown name 'stel'; did you mean 'steel'\?"),
    ],
)
@pytest.mark.parametrize("ask", [lambda a, e: hf.stability(a, engine=e), lambda a, e: hf.robustness_map(a, engine=e)])
def test_unknown_names_are_refused_with_the_nearest(table: Assembly, stiffness: Table, match: str, ask: Any) -> None:
    with pytest.raises(hf.errors.SceneError, match=match):
        ask(table, Compliant(stiffness=stiffness))


def test_names_of_bodies_that_were_taken_away_are_known(table: Assembly) -> None:
    stiffness = {("leg1", "slab"): 3.0, ("rubber", "wood"): 2.0, ("leg0", "slab"): 4.0}
    left = table.without("leg1")
    assert left.absent == ("leg1", "rubber")
    assert left == assemble(left.scene)
    assert carried(left, stiffness) == carried(left, {("leg0", "slab"): 4.0})
    for edited in (left.moved({}), left.without("leg0")):
        assert "rubber" in edited.absent
    with pytest.raises(hf.errors.SceneError, match="'leg1'"):
        carried(assemble(left.scene), stiffness)
