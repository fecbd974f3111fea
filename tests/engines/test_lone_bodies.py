"""Lone bodies judged by a formula: as the engines judge them, at Navier's kern and on slopes, and with any faces."""

from __future__ import annotations

import numpy as np
import pytest
from placed import at
from scipy.spatial.transform import Rotation

import holdfast as hf
from holdfast.answers import Interface
from holdfast.engines.compliant.engine import Compliant
from holdfast.engines.groups import prepared
from holdfast.engines.limit.engine import Limit
from holdfast.engines.lone_bodies import lone, rest_firmly
from holdfast.scene.shipped.blocks import box, floor

SIDE, MU = 0.2, 0.5
SPARED = 0.1  # share of the friction that a firm body does not need


def cube_on(
    polygon: np.ndarray, *, mu: float = MU, com: tuple[float, float, float] = (0, 0, 0.1)
) -> hf.answers.Assembly:
    """A cube whose only contact is the given face of the floor, with its centre of mass anywhere."""
    cube = hf.Body(
        "cube", hf.Box((SIDE, SIDE, SIDE)), mass=1.0, pose=at(0, 0, SIDE / 2), com=np.subtract(com, (0, 0, 0.1))
    )
    return hf.assemble(
        hf.Scene([floor(), cube], friction=mu), interfaces=[Interface(("floor", "cube"), polygon, (0, 0, 1))]
    )


def square(x: float, y: float) -> np.ndarray:
    return np.array([[-x, -y, 0], [x, -y, 0], [x, y, 0], [-x, y, 0]]) / 2


def firmly(assembly: hf.answers.Assembly, load: np.ndarray | None = None, **how: float) -> bool:
    wrench = assembly.weight_wrench() + (0 if load is None else load)
    bodies = lone(assembly)
    assert bodies.tolist() == [0]
    return bool(rest_firmly(assembly, bodies, wrench, **{"spare": SPARED, **how})[0])


@pytest.mark.parametrize("ratio", [0.3, 1.0, 4.0])
def test_a_face_is_pressed_everywhere_as_far_as_its_kern(ratio: float) -> None:
    """At an eccentricity e of the width b the pressure at the edges is 1 ± 6 e/b, on half of a face as on the whole."""
    b = 0.1
    most = b / 6 * (1 - SPARED) / (1 + SPARED)
    for share, firm in ((0.999, True), (1.001, False)):
        for com in ((share * most, 0, 0.1), (-share * most, 0, 0.1)):
            assert firmly(cube_on(square(b, 0.05), com=com), ratio=ratio) == firm


@pytest.mark.parametrize("spare", [0.01, SPARED])
def test_a_block_on_a_slope_spares_friction_as_far_as_the_angle_of_friction(spare: float) -> None:
    """A level pull of tan φ times the weight is as a slope; its moment about the face is undone."""
    limit = MU * (1 - spare)
    for share, firm in ((0.999, True), (1.001, False)):
        pull = share * limit * 9.81
        assembly = cube_on(square(0.1, 0.1))
        load = np.array([0, pull, 0, 0.1 * pull, 0, 0])
        assert firmly(assembly, load, spare=spare) == firm


def test_torsion_slips_at_the_corners_first() -> None:
    """A twist T shears the corner of a square of side b by T r / J, with J = b⁴/6 and r = b/√2."""
    b, weight = 0.1, 9.81
    most = MU * (1 - SPARED) * weight / b**2 * (b**4 / 6) / (b / np.sqrt(2))
    for share, firm in ((0.999, True), (1.001, False)):
        assert firmly(cube_on(square(b, b)), np.array([0, 0, 0, 0, 0, share * most])) == firm


def test_a_face_with_a_hole_has_the_moments_of_the_rest() -> None:
    """A square tube of sides b and c: its kern reaches (b⁴ - c⁴) / (6 b (b² - c²))."""
    b, c = 0.1, 0.08
    outline, hole = square(b, b), square(c, c)[::-1]
    patch = hf.answers.Patch(outline, np.array([0.0, 0, 1]), holes=(hole,))
    most = (b**4 - c**4) / (6 * b * (b**2 - c**2)) * (1 - SPARED) / (1 + SPARED)
    for share, firm in ((0.999, True), (1.001, False)):
        assembly = cube_on(outline, com=(0, share * most, 0.1))
        with_hole = Interface(("floor", "cube"), patches=[patch])
        assert firmly(hf.assemble(assembly.scene, interfaces=[with_hole])) == firm


def random_assembly(rng: np.random.Generator) -> hf.answers.Assembly:
    """A body on one to four faces of any shape, of one or two fixed bodies, flat or inclined, seen from either."""
    cube = hf.Body(
        "cube",
        hf.Box((SIDE, SIDE, SIDE)),
        mass=rng.uniform(0.1, 10),
        pose=at(0, 0, SIDE / 2),
        com=rng.uniform(-0.01, 0.01, 3),
    )
    contacts = []
    for k in range(rng.integers(1, 5)):
        turn = (
            Rotation.from_euler("xyz", [*rng.uniform(-0.1, 0.1, 2), 0.0]).as_matrix()
            if rng.random() < 0.5
            else np.eye(3)
        )
        count = rng.integers(3, 8)
        corners = 2 * np.pi / count * (np.arange(count) + rng.uniform(0, 0.8, count))
        ring = rng.uniform(0.05, 0.1) * np.column_stack([np.cos(corners), np.sin(corners), 0 * corners])
        place, normal = np.append(rng.uniform(-0.03, 0.03, 2), 0.0), turn[:, 2]
        pair, sign = (("floor", "wall")[k % 2], "cube"), 1
        if rng.random() < 0.5:
            pair, sign = pair[::-1], -1
        contacts.append(Interface(pair, ring @ turn.T + place, sign * normal))
    wall = hf.Body("wall", hf.Box((1, 1, 1)), fixed=True, pose=at(5, 0, 0))
    scene = hf.Scene([floor(), wall, cube], friction=rng.uniform(0.2, 1.0))
    return hf.assemble(scene, interfaces=contacts)


@pytest.mark.parametrize(
    "engine", [Compliant(), Compliant(stiffness_ratio=0.4, stiffness={("floor", "cube"): 3.0}), Limit()]
)
def test_the_engines_say_the_same_of_random_bodies(engine: Compliant | Limit) -> None:
    rng, firm, stand = np.random.default_rng(5), 0, 0
    for _ in range(250):
        assembly = random_assembly(rng)
        load = rng.normal(size=6) * np.repeat([1.0, 0.1], 3) * 0.03 * assembly.weight
        rests, quick = engine.firm(assembly, assembly.weight_wrench() + load, np.array([0]))
        full = engine.prepare(assembly, load).verdict()
        stand += full.stable
        if rests[0]:
            firm += 1
            assert (full.status, full.reason) == (quick.status, quick.reason)
            assert (full.equilibrium_exists, full.self_stress) == (quick.equilibrium_exists, quick.self_stress)
    assert min(firm, stand - firm) > 30, "both kinds are asked about"


def test_evidence_is_that_of_the_engine() -> None:
    bodies = [box(f"b{k}", (0.1, 0.1, 0.1), 1.0, (0.15 * k, 0, 0.05)) for k in range(3)]
    scene = hf.Scene([floor(), *bodies], friction=MU)
    answer = hf.stability(scene)
    assert "by a formula" in answer.groups[0].verdict.explained
    assembly = hf.assemble(scene)
    groups = prepared(Compliant(), assembly)
    for number in range(3):
        np.testing.assert_array_equal(
            answer.groups[number].verdict.forces.force, groups.group(number).verdict.forces.force
        )
    assert answer.forces.force[:, 2].sum() == pytest.approx(assembly.weight)
    assert answer.residual < 1e-8


def test_bodies_with_any_doubt_are_left_to_the_engine() -> None:
    cube = box("cube", (0.1, 0.1, 0.1), 1.0, (0, 0, 0.05))
    assert lone(hf.assemble(hf.Scene([floor(), cube], MU), pose_sigma=0.001)).tolist() == [], "it may not touch"
    ball = hf.Body("ball", hf.Sphere(0.05), mass=1.0, pose=at(0.5, 0, 0.05))
    pair = [box("low", (0.1, 0.1, 0.1), 1.0, (1, 0, 0.05)), box("high", (0.1, 0.1, 0.1), 1.0, (1, 0, 0.15))]
    assembly = hf.assemble(hf.Scene([floor(), ball, *pair, cube], MU))
    assert [assembly.movable[k].name for k in lone(assembly)] == ["cube"]
    with pytest.warns(hf.errors.HoldfastWarning, match="overlap"):
        deep = hf.assemble(hf.Scene([floor(), box("cube", (0.1, 0.1, 0.1), 1.0, (0, 0, 0.03))], MU))
    assert lone(deep).tolist() == []
    assert hf.stability(deep).status is hf.Status.UNDECIDED
