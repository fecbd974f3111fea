"""Friction of the parts of a compound: each contact has the coefficient of the part that touches."""

from __future__ import annotations

import numpy as np
import pytest
from placed import at

import holdfast as hf

G = 9.81


FLOOR = hf.Body("floor", hf.HalfSpace(), fixed=True, material="wood")
TABLE = {("rubber", "wood"): 0.9, ("steel", "wood"): 0.2}


def sled(left: str | None, right: str | None, material: str | None = None) -> hf.Body:
    """Two runners under a slab, each carrying half of 2 kg."""
    parts = [
        hf.Part(hf.Box((0.4, 0.2, 0.05)), at(0, 0, 0.075), "steel"),
        hf.Part(hf.Box((0.4, 0.02, 0.05)), at(0, -0.09, 0.025), left),
        hf.Part(hf.Box((0.4, 0.02, 0.05)), at(0, 0.09, 0.025), right),
    ]
    return hf.Body("sled", hf.Compound(parts), mass=2.0, material=material)


def force(body: hf.Body, friction: hf.Friction, engine: str) -> tuple[hf.answers.Assembly, float]:
    names = {"floor", "wood", "sled", *body.materials}
    assembly = hf.assemble(hf.Scene([FLOOR, body], friction.among(names)))
    found = hf.robustness(assembly, "sled", (-0.2, 0, 0.0501), (1, 0, 0), engine=engine)
    return assembly, float(found.force[0])


@pytest.mark.parametrize("engine", ["limit", "compliant"])
def test_two_runners_of_different_materials_share_the_friction(engine: str) -> None:
    """Pushed along the middle, a sled of a rubber and a steel runner turns until the rubber one alone stands fast."""
    assembly, found = force(sled("rubber", "steel"), hf.Friction(pairs=TABLE), engine)
    assert sorted(assembly.mu) == [0.2, 0.9]
    assert [i.bodies for i in assembly.interfaces] == [("floor", "sled")] * 2
    _, both_steel = force(sled("steel", "steel"), hf.Friction(pairs=TABLE), engine)
    _, both_rubber = force(sled("rubber", "rubber"), hf.Friction(pairs=TABLE), engine)
    assert both_steel == pytest.approx(0.2 * 2 * G, rel=2e-3)
    assert both_rubber == pytest.approx(0.9 * 2 * G, rel=2e-3)
    assert both_steel < found < both_rubber


def test_parts_without_a_material_have_that_of_the_body() -> None:
    assembly, found = force(sled(None, None, "rubber"), hf.Friction(pairs=TABLE), "limit")
    assert assembly.mu == (0.9,)
    assert found == pytest.approx(0.9 * 2 * G, rel=1e-5)


def test_a_pair_of_bodies_goes_before_the_materials_of_their_parts() -> None:
    friction = hf.Friction(pairs={**TABLE, ("floor", "sled"): 0.5})
    assembly, found = force(sled("rubber", "steel"), friction, "limit")
    assert assembly.mu == (0.5,)
    assert found == pytest.approx(0.5 * 2 * G, rel=1e-5)


def test_a_patch_over_two_parts_is_cut_at_their_border() -> None:
    """A plate of two halves on a board; the border runs at x = 0.03."""
    parts = [
        hf.Part(hf.Box((0.26, 0.2, 0.05)), at(0.16, 0, 0.025), "rubber"),
        hf.Part(hf.Box((0.24, 0.2, 0.05)), at(-0.09, 0, 0.025), "steel"),
    ]
    plate = hf.Body("plate", hf.Compound(parts), mass=1.0)
    found = hf.assemble(hf.Scene([FLOOR, plate], hf.Friction(pairs=TABLE))).interfaces
    areas = {i.mu: i.area for i in found}
    assert areas == pytest.approx({0.9: 0.26 * 0.2, 0.2: 0.24 * 0.2}, rel=1e-9)
    for interface in found:
        x = np.vstack([patch.polygon for patch in interface.patches])[:, 0]
        assert (x >= 0.03 - 1e-9).all() if interface.mu == 0.9 else (x <= 0.03 + 1e-9).all()


def test_a_coefficient_by_bodies_replaces_those_of_the_parts() -> None:
    assembly, _ = force(sled("rubber", "steel"), hf.Friction(pairs=TABLE), "limit")
    assert assembly.with_friction({("sled", "floor"): 0.4}).mu == (0.4, 0.4)
    assert assembly.with_mu((0.1, 0.3)).mu == (0.1, 0.3)


def test_uncertain_poses_narrow_every_cone_by_itself() -> None:
    """Rubber and steel under one body, poses uncertain: lower is below what it is with certain poses."""
    scene = hf.Scene([FLOOR, sled("rubber", "steel")], hf.Friction(pairs=TABLE))
    push = ("sled", (-0.2, 0, 0.0501), (1, 0, 0))
    sure = hf.robustness(hf.assemble(scene), *push, engine="limit")
    unsure = hf.robustness(hf.assemble(scene, pose_sigma=(0.0005, 0.2)), *push, engine="limit")
    assert 0.3 * sure.lower[0] < unsure.lower[0] < sure.lower[0]


def test_a_material_that_the_table_does_not_know_is_told() -> None:
    scene = hf.Scene([FLOOR, sled("rubber", "ice")], hf.Friction(pairs=TABLE))
    with pytest.raises(hf.errors.SceneError, match="friction"):
        hf.assemble(scene)


def test_a_body_and_the_material_of_a_part_make_a_pair() -> None:
    """The body is named on one side and the material on the other: they must not be taken for each other's."""
    table = hf.Friction(pairs={("floor", "rubber"): 0.9, ("floor", "steel"): 0.2})
    for bodies in ((FLOOR, sled("rubber", "steel")), (sled("rubber", "steel"), FLOOR)):
        assembly = hf.assemble(hf.Scene(bodies, table))
        middles = {i.mu: np.mean([patch.centroid[1] for patch in i.patches]) for i in assembly.interfaces}
        assert middles == pytest.approx({0.9: -0.09, 0.2: 0.09})


@pytest.mark.parametrize("engine", ["limit", "compliant"])
@pytest.mark.parametrize("left", ["rubber", "steel"])
def test_a_sled_slides_straight_if_pushed_nearer_to_its_rough_runner(left: str, engine: str) -> None:
    """If each bears half, (0.9 + 0.2) W / 2, at 0.09 m (0.9 - 0.2) / (0.9 + 0.2) from the middle.

    Where stiffness does not decide, the rubber one bears up to 5 / 9: by its inner edge, the steel one by its outer.
    """
    table = hf.Friction(pairs={("floor", "rubber"): 0.9, ("floor", "steel"): 0.2})
    right, side = ("steel", -1) if left == "rubber" else ("rubber", 1)
    assembly = hf.assemble(hf.Scene([FLOOR, sled(left, right)], table))
    at_balance = (-0.2, side * 0.09 * 0.7 / 1.1, 0.0501)
    beside = (-0.2, -side * 0.09 * 0.7 / 1.1, 0.0501)
    straight, turning = hf.robustness(assembly, "sled", [at_balance, beside], (1, 0, 0), engine=engine).force
    assert straight == pytest.approx((0.9 * 5 + 0.2 * 4) / 9 * 2 * G if engine == "limit" else 1.1 * G, rel=1e-3)
    assert turning < 0.9 * straight


@pytest.mark.parametrize("order", [1, -1])
def test_where_edges_meet_sharply_the_largest_friction_of_any_parts_is_allowed_for(order: int) -> None:
    """A block of two materials whose lower edge lies on the upper edge of another: what touches there is not known."""
    half = hf.Box((0.1, 0.1, 0.05))
    halves = [hf.Part(half, at(0, 0, z), name) for z, name in ((0.025, "rubber"), (-0.025, "steel"))]
    base = hf.Body("base", hf.Box((0.1, 0.1, 0.1)), position=(0, 0, 0.05), fixed=True, material="wood")
    top = hf.Body("top", hf.Compound(halves), mass=1, position=(0.1, 0, 0.15))
    scene = hf.Scene([base, top][::order], hf.Friction(pairs=TABLE))
    assembly = hf.assemble(scene)
    assert assembly.interfaces == ()
    assert [interface.mu for interface in assembly.sharpened.interfaces] == [0.9]
    assert hf.stability(assembly).status is hf.Status.UNSTABLE
