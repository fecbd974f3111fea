"""The worst case in closed form, and which boxes are refused."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import holdfast as hf
from bench.scenes.fitted import row
from holdfast.queries.uncertain import friction_intervals
from holdfast.queries.uncertainty import worst_case
from holdfast.scene.shipped import shipped_scene
from holdfast.scene.shipped.blocks import box, cube, floor

G = 9.81
X = np.array([1.0, 0, 0])


def test_of_the_parts_of_two_bodies_the_least_rough_counts() -> None:
    """A table with a foot of rubber and one of felt, listed either way."""
    feet = [
        hf.Part(hf.Box((0.05, 0.1, 0.02)), pose=hf.pose(x, 0, 0.01), material=name)
        for x, name in ((-0.05, "rubber"), (0.05, "felt"))
    ]
    friction = hf.Friction(0.5, pairs={("rubber", "tile"): 0.8, ("felt", "tile"): 0.2})
    ground = hf.Body("floor", hf.Box((1, 1, 0.05)), position=(0, 0, -0.025), material="tile", fixed=True)
    for order in (feet, feet[::-1]):
        top = hf.Part(hf.Box((0.15, 0.1, 0.02)), pose=hf.pose(0, 0, 0.03))
        standing = hf.Body("table", hf.Compound([*order, top]), mass=1.0, material="wood")
        assembly = hf.assemble(hf.Scene([ground, standing], friction))
        assert friction_intervals(assembly, None, "test") == {("floor", "table"): (0.2, 0.2)}
        assert friction_intervals(assembly, 0.5, "test")["floor", "table"] == pytest.approx((0.1, 0.3))


def test_the_worst_cube_in_closed_form() -> None:
    assembly = hf.assemble(cube())
    points, ways, half = [[-0.05, 0, 0.02], [-0.05, 0, 0.098]], [X, X], {"cube": (0.01, 0, 0.02)}
    ranges = {"mu_range": (0.5, 0.7), "mass_range": {"cube": (0.8, 1.1)}, "com_range": half}
    found = worst_case(assembly, "cube", points, ways, exists=True, **ranges)
    least = 0.8 * G * min(0.5, 1)
    np.testing.assert_allclose(found.force, [least, min(least, 0.8 * G * 0.04 / 0.098)], rtol=1e-6)
    assert (found.force <= found.nominal).all()
    assert (found.lower <= found.force).all()
    assert (found.force <= found.upper).all()
    assert found.corners == 4, "shifts along gravity do not count"
    assert found.masses[1] == {"cube": 0.8}
    assert found.coms[1]["cube"][0] == pytest.approx(0.01)
    assert found.mu == {("floor", "cube"): 0.5}
    assert "exact" in found.guarantee
    assert found.claim is hf.answers.Claim.EXISTS
    assert "holds" not in found.to_dict()
    assert found.to_dict()["exists"]["lower"] == pytest.approx(found.lower.min())
    held = worst_case(assembly, "cube", points, ways, **ranges)
    assert held.claim is hf.answers.Claim.HOLDS
    assert (held.lower <= found.force * (1 + 1e-9)).all()
    assert (held.lower >= 0.9 * found.force).all()
    assert held.corners == 2 * 4 + 1, "both ends of friction, and the values as given"
    assert held.masses[1] == {"cube": 0.8}
    assert "not a proof: what holds by engine compliant was asked at 9 combinations" in held.guarantee
    assert held.guarantee in str(held.summary())


def test_one_width_is_for_all_bodies() -> None:
    """A fifth of the mass and a centimetre of its centre: 0.8 kg, whose centre is 4 cm from the edge it tips about."""
    ranges = {"mass_range": 0.2, "com_range": 0.01}
    found = worst_case(hf.assemble(cube()), "cube", [-0.05, 0, 0.098], X, exists=True, **ranges)
    assert float(found) == pytest.approx(0.8 * G * 0.04 / 0.098, rel=1e-6)


def test_a_corner_that_does_not_stand_makes_the_worst_case_zero() -> None:
    found = worst_case(hf.assemble(cube()), "cube", [-0.05, 0, 0.02], X, com_range={"cube": (0.06, 0, 0)})
    assert found.force[0] == 0
    assert found.status[0] is hf.Status.UNSTABLE
    down = worst_case(hf.assemble(cube()), "cube", [0, 0, 0.1], [0, 0, -1], mu_range=0.3, mass_range=0.2)
    assert down.status[0] is hf.Status.INFINITE
    assert np.isinf(down.force[0])


def test_without_uncertainty_it_is_the_query() -> None:
    found = worst_case(hf.assemble(cube()), "cube", [-0.05, 0.045, 0.02], X)
    assert found.force[0] == pytest.approx(found.nominal[0], rel=1e-9)
    assert worst_case(hf.assemble(cube()), "cube", [-0.05, 0.045, 0.02], X, exists=True).corners == 1


@pytest.mark.parametrize(
    ("asked", "told"),
    [
        ({"mu_range": (0.5, 0.4)}, "needs 0 <= low <= high"),
        ({"mu_range": 1.0}, "relative width"),
        ({"mass_range": {"floor": (1, 2)}}, "'floor' is fixed"),
        ({"com_range": {"cube": (0.1, 0, -0.1)}}, "half widths >= 0"),
    ],
)
def test_a_bad_box_is_refused(asked: dict[str, Any], told: str) -> None:
    with pytest.raises(hf.HoldfastError, match=told):
        worst_case(hf.assemble(cube()), "cube", [-0.05, 0, 0.02], X, **asked)


def test_too_many_corners_are_refused_with_a_remedy() -> None:
    with pytest.raises(hf.HoldfastError, match=r"corners; at most 4,096: name the bodies that matter"):
        worst_case(hf.assemble(shipped_scene("arch")), "v3", [0, 0, 0.3], [0, 0, -1], mass_range=0.1, com_range=0.01)


def test_friction_intervals_may_name_materials() -> None:
    """The names of bodies count before materials, and of two mixed pairs both intervals."""
    scene = hf.Scene(
        [
            replace(floor(), material="oak"),
            replace(box("low", (0.1, 0.1, 0.1), 1, (0, 0, 0.05)), material="glass"),
            replace(box("top", (0.1, 0.1, 0.1), 1, (0, 0, 0.15)), material="glass"),
        ],
        0.5,
    )
    assembly = hf.assemble(scene)
    low, top = ("floor", "low"), ("low", "top")

    def found(given: dict[tuple[str, str], tuple[float, float]]) -> dict[tuple[str, str], tuple[float, float]]:
        intervals = friction_intervals(assembly, given, "test")
        return {tuple(sorted(pair)): interval for pair, interval in intervals.items()}

    assert found({("oak", "glass"): (0.2, 0.3)}) == {low: (0.2, 0.3), top: (0.5, 0.5)}
    assert found({("glass", "glass"): (0.2, 0.3), ("top", "low"): (0.1, 0.4)})[top] == (0.1, 0.4)
    assert found({("floor", "glass"): (0.2, 0.3), ("oak", "low"): (0.1, 0.25)})[low] == (0.1, 0.3)
    with pytest.raises(hf.errors.SceneError, match="or their materials"):
        found({("oak", "oak"): (0.2, 0.3)})


@pytest.mark.parametrize("air", [0.0, 1e-5, 2e-4])
def test_a_book_in_a_row_that_nothing_squeezes_has_the_friction_of_its_board(air: float) -> None:
    """Least friction times least weight; an equilibrium that squeezes it exists for far more."""
    push = ("book1", (0, -0.085, 0.12), (0, -1, 0))
    found = worst_case(row(3, air), *push, mu_range=(0.3, 0.5), mass_range=0.1)
    right = 0.3 * 0.9 * 0.8 * G
    assert 0.9 * right <= found.lower[0] <= right
    assert found.force[0] <= right * (1 + 1e-3)
    exists = worst_case(row(3, air), *push, mu_range=(0.3, 0.5), mass_range=0.1, exists=True)
    assert exists.lower[0] > (2 if air < 1e-4 else 0.99) * right


def test_the_weaker_end_of_friction_counts() -> None:
    found = worst_case(hf.assemble(cube()), "cube", [-0.05, 0, 0.02], X, mu_range=(0.2, 2.0))
    assert found.lower[0] == pytest.approx(0.2 * G, rel=0.03)
    assert found.mu == {("floor", "cube"): 0.2}
    assert found.corners == 3


def test_a_relative_width_is_told_with_both_of_its_ends() -> None:
    """0.1 is a tenth of the coefficient, not 0.1 more and less: what slides has 0.54 m g, and a note says so."""
    push = (-0.05, 0, 0.001), (1, 0, 0)
    found = worst_case(hf.assemble(cube()), "cube", *push, mu_range=0.1)
    assert found.force[0] == pytest.approx(0.54 * 9.81, rel=1e-4)
    assert "mu_range 0.1 is relative: friction 0.54 to 0.66 of 0.6" in found.notes
    sampled = hf.robustness_under(hf.assemble(cube()), "cube", *push, hf.sets.Uncertain(mu_range=0.1, samples=2))
    assert "mu_range 0.1 is relative: friction 0.54 to 0.66 of 0.6" in sampled.notes
    for mu_range in (None, (0.5, 0.7), {("cube", "floor"): (0.5, 0.7)}):
        again = worst_case(hf.assemble(cube()), "cube", *push, mu_range=mu_range, mass_range=0.1)
        assert not any("mu_range" in note for note in again.notes)
