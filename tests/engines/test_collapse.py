"""The least motion that no contact can resist, on its own."""

from __future__ import annotations

import numpy as np
import pytest
from placed import at
from scipy.spatial.transform import Rotation

import holdfast as hf
from holdfast.assembly.contact_nodes import contact_nodes
from holdfast.engines.mechanism import modes_of, relative_velocity
from holdfast.engines.rest import falls_by, least_motion
from holdfast.scene.shipped.blocks import box, floor


@pytest.mark.parametrize(("lean", "mode"), [((0.6, 0), "slip"), ((0.42, 0.42), "slip"), ((1.2, 0), "slip")])
def test_a_flat_box_on_a_steep_slope_slides_down_and_nothing_else_moves(lean: tuple[float, float], mode: str) -> None:
    """At μ 0.5: gravity wins over the dual cone, which lets the box rise by μ times its slip."""
    bodies = [floor(), box("box", (0.1, 0.1, 0.02), 1, (0, 0, 0.01))]
    assembly = hf.assemble(hf.Scene(bodies, 0.5, 9.81 * np.array([*lean, -1])))
    nodes = contact_nodes(assembly, 4, "corners")
    twists = least_motion(assembly, nodes, assembly.weight_wrench())
    assert twists is not None
    velocity = relative_velocity(nodes, assembly.com, twists)
    assert (velocity[:, 0] - 0.5 * np.linalg.norm(velocity[:, 1:], axis=1)).min() > -1e-7 * np.abs(velocity).max()
    assert float(twists.ravel() @ assembly.weight_wrench()) > 0
    assert modes_of(assembly, nodes, twists[None], velocity[None], dual=True) == [mode]
    down = twists[0, :2] / np.linalg.norm(twists[0, :2])
    np.testing.assert_allclose(down, np.array(lean) / np.linalg.norm(lean), atol=1e-5)


def test_a_box_that_stands_has_no_such_motion() -> None:
    assembly = hf.assemble(hf.Scene([floor(), box("box", (0.1, 0.1, 0.02), 1, (0, 0, 0.01))], 0.5))
    assert least_motion(assembly, contact_nodes(assembly, 4, "corners"), assembly.weight_wrench()) is None


@pytest.mark.parametrize(("rise", "proved"), [(0.501, True), (0.499, False), (0.0, False), (-0.1, False)])
def test_a_fall_is_proved_by_a_motion_that_opens_contacts_by_mu_times_its_slip(rise: float, proved: bool) -> None:
    """On a slope of 0.7 at μ 0.5, slipping gains power; a contact that opens by less can resist it."""
    bodies = [floor(), box("box", (0.1, 0.1, 0.02), 1, (0, 0, 0.01))]
    assembly = hf.assemble(hf.Scene(bodies, 0.5, 9.81 * np.array([0.7, 0, -1])))
    nodes, slip = contact_nodes(assembly, 4, "corners"), np.array([[1.0, 0, rise, 0, 0, 0]])
    found, _ = falls_by(assembly, nodes, assembly.weight_wrench(), slip)
    assert found.status == ("unstable" if proved else "undecided")
    assert (found.certificate is not None) == proved
    uphill, _ = falls_by(assembly, nodes, assembly.weight_wrench(), slip * [-1, 1, 1, 1, 1, 1])
    assert uphill.status == "undecided", "it gains no power"


@pytest.mark.parametrize("yaw", [0, 15, 90, 222])
@pytest.mark.parametrize(("degrees", "mu"), [(5, 0.5), (8, 0.8), (16, 0.2), (20, 0.5), (25, 0.8)])
def test_a_rod_rolls_down_a_slope_although_the_program_for_its_forces_is_not_solved(
    degrees: float, mu: float, yaw: float
) -> None:
    """A quarter of such verdicts was undecided: numerical trouble in the solver."""
    turn = Rotation.from_euler("ZX", (yaw, degrees), degrees=True).as_matrix()
    across = turn @ Rotation.from_euler("y", 90, degrees=True).as_matrix()
    slope = hf.Body("slope", hf.Box((1, 1, 0.1)), fixed=True, pose=at(*turn @ (0, 0, -0.05), turn))
    rod = hf.Body("rod", hf.Cylinder(0.04, 0.2), mass=1, pose=at(*turn @ (0, 0, 0.04), across))
    for engine in ("limit", "compliant"):
        found = hf.stability(hf.assemble(hf.Scene([slope, rod], mu)), engine=engine)
        assert found.status == "unstable"
        assert found.mechanism is not None
        assert found.mechanism.twists[0, :3] @ (turn @ (0, -np.sin(np.radians(degrees)), 0)) > 0
