"""Lying cylinders touch flat faces along a line however they are rolled, and uncertain poses widen nothing."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from placed import FLOOR, at, lying, prism
from scipy.spatial.transform import Rotation

import holdfast as hf

G = 9.81
FACET = 360 / 64  # [deg] of a cylinder that is tessellated as usual


def tin(roll: float, shape: hf.Shape | None = None) -> hf.Body:
    return hf.Body("tin", shape or hf.Cylinder(0.04, 0.12), mass=1, pose=at(0, 0, 0.04, lying(roll)))


def drawn() -> hf.Mesh:
    """The same tin as a mesh of which nobody says what it stands for: a prism."""
    surface = hf.Cylinder(0.04, 0.12).surface
    return hf.Mesh(surface.vertices, surface.faces)


@pytest.mark.parametrize("order", [1, -1])
@pytest.mark.parametrize("roll", [0.0, 1.0, 2.0, FACET / 2, 77.3])
def test_a_lying_cylinder_touches_along_its_lowest_line(roll: float, order: int) -> None:
    floor = hf.Body("floor", hf.Box((1, 1, 0.1)), pose=at(0, 0, -0.05), fixed=True)
    (interface,) = hf.assemble(hf.Scene([floor, tin(roll)][::order], 0.5)).interfaces
    (line,) = interface.patches
    assert line.kind == "line"
    assert line.normal == pytest.approx((0, 0, order), abs=1e-12)
    assert line.polygon[np.argsort(line.polygon[:, 1])] == pytest.approx(
        np.array([(0, -0.06, 0), (0, 0.06, 0)]), abs=1e-9
    )
    assert line.separation == pytest.approx((0, 0), abs=1e-12)


@pytest.mark.parametrize("order", [1, -1])
def test_a_contact_lies_halfway_between_the_surfaces_whichever_body_comes_first(order: int) -> None:
    floor = hf.Body("floor", hf.Box((1, 1, 0.1)), pose=at(0, 0, -0.05), fixed=True)
    lifted = tin(10).moved(at(0, 0, 0.04 + 5e-5, lying(10)))
    (interface,) = hf.assemble(hf.Scene([floor, lifted][::order], 0.5), gap=1e-4).interfaces
    assert interface.patches[0].polygon[:, 2] == pytest.approx((2.5e-5, 2.5e-5), abs=1e-12)


@pytest.mark.parametrize("engine", ["limit", "compliant"])
@pytest.mark.parametrize("roll", [0.0, 1.0, 2.0, FACET / 2])
def test_a_lying_cylinder_rolls_at_the_least_push_and_slides_along_its_axis(roll: float, engine: str) -> None:
    """By 1 degree it was said to fall, by 2 to withstand 0.62 N."""
    assembly = hf.assemble(hf.Scene([FLOOR, tin(roll)], 0.5))
    assert hf.stability(assembly, engine=engine).status == "stable"
    push = hf.robustness(assembly, "tin", [(0.04, 0, 0.04), (0, -0.06, 0.04)], [(-1, 0, 0), (0, 1, 0)], engine=engine)
    assert push.force == pytest.approx([0, min(0.5 * G, G * 0.06 / 0.04)], rel=1e-4, abs=1e-6)


@pytest.mark.parametrize("engine", ["limit", "compliant"])
@pytest.mark.parametrize("roll", [0.0, 1.3, 31.0])
def test_a_cylinder_in_a_groove_is_spun_by_the_moment_of_both_frictions(roll: float, engine: str) -> None:
    """Faces at 45 degrees: both slip, so M = µ r m g / ((1 + µ²) cos 45°)."""
    mu, r = 0.4, 0.04
    sides = [
        hf.Body(
            f"side {sign:+d}",
            hf.Box((0.2, 0.3, 0.02)),
            fixed=True,
            pose=at(turn=Rotation.from_euler("y", 45 * sign, degrees=True).as_matrix()) @ at(-0.1 * sign, 0, -0.01),
        )
        for sign in (1, -1)
    ]
    body = hf.Body("tin", hf.Cylinder(r, 0.12), mass=1, pose=at(0, 0, r * np.sqrt(2), lying(roll)))
    assembly = hf.assemble(hf.Scene([*sides, body], mu))
    load = hf.Load("tin", (0, 0, r * np.sqrt(2)), moment=(0, 1, 0))
    found = hf.load_factor(assembly, [load], engine=engine)
    assert found.factor == pytest.approx(mu * r * G / ((1 + mu**2) * np.cos(np.pi / 4)), rel=1e-3)


@pytest.mark.parametrize("tilt", [10.0, 40.0, 75.0])
def test_a_leaning_cylinder_touches_with_the_lowest_point_of_its_rim(tilt: float) -> None:
    lean = np.radians(tilt)
    low = 0.04 * np.cos(lean) + 0.06 * np.sin(lean)
    body = hf.Body("tin", hf.Cylinder(0.04, 0.12), mass=1, pose=at(0, 0, low, lying(33, tilt)))
    (interface,) = hf.assemble(hf.Scene([FLOOR, body], 0.5), gap=1e-4).interfaces
    (point,) = interface.patches
    assert point.kind == "point"
    axis = body.pose[:3, 2] * np.sign(-body.pose[2, 2])
    down = np.array([0, 0, -1.0]) - axis * (axis @ [0, 0, -1])
    assert point.polygon[0] == pytest.approx(
        body.pose[:3, 3] + 0.06 * axis + 0.04 * down / np.linalg.norm(down), abs=1e-9
    )


def test_a_standing_cylinder_stands_on_its_end_and_carries_a_ball_there() -> None:
    base = hf.Body("base", hf.Cylinder(0.05, 0.1), mass=1, pose=at(0, 0, 0.05))
    ball = hf.Body("ball", hf.Sphere(0.03), mass=0.5, pose=at(0.01, 0.02, 0.13))
    found = {i.bodies: i.patches for i in hf.assemble(hf.Scene([FLOOR, base, ball], 0.5), gap=1e-4).interfaces}
    assert [patch.kind for patch in found["floor", "base"]] == ["face"]
    (point,) = found["base", "ball"]
    assert point.polygon[0] == pytest.approx((0.01, 0.02, 0.1), abs=1e-9)


def test_a_nut_of_six_sides_is_a_prism() -> None:
    nut = hf.Body("nut", hf.Cylinder(0.04, 0.12, segments=6), mass=1, pose=at(0, 0, 0.04 * np.cos(np.pi / 6), lying(0)))
    (interface,) = hf.assemble(hf.Scene([FLOOR, nut], 0.5)).interfaces
    assert [patch.kind for patch in interface.patches] == ["face"]


@pytest.mark.parametrize("sigma", [(0.0005, 0.2), (0.0005, 0.5), (0.003, 1.0), (0.001, 2.0)])
@pytest.mark.parametrize("engine", ["limit", "compliant"])
def test_doubt_about_its_rotation_does_not_hold_a_lying_cylinder(sigma: tuple[float, float], engine: str) -> None:
    """A line became a face of 8 mm, and ``lower`` rose from 0 to 0.58 N."""
    assembly = hf.assemble(hf.Scene([FLOOR, tin(1)], 0.5), pose_sigma=sigma)
    push = hf.robustness(assembly, "tin", (0.04, 0, 0.04), (-1, 0, 0), engine=engine)
    assert push.lower == pytest.approx([0], abs=1e-6)
    assert push.force == pytest.approx([0], abs=1e-6)


@pytest.mark.parametrize("sigma", [(0.0005, 0.2), (0.0005, 0.5), (0.003, 1.0), (0.001, 2.0)])
def test_doubt_about_its_rotation_widens_no_contact_of_a_drawn_cylinder(sigma: tuple[float, float]) -> None:
    body = tin(FACET / 2, drawn()).moved(at(0, 0, 0.04 * np.cos(np.pi / 64), lying(FACET / 2)))
    scene = hf.Scene([FLOOR, body], 0.5)
    sure, unsure = hf.assemble(scene), hf.assemble(scene, pose_sigma=sigma)
    ((one,), (two,)) = (each.interfaces[0].patches for each in (sure, unsure))
    assert two.width == pytest.approx(one.width, rel=1e-6)
    known, doubtful = (hf.robustness(each, "tin", (0.04, 0, 0.04), (-1, 0, 0)) for each in (sure, unsure))
    assert doubtful.lower[0] <= known.lower[0]
    assert doubtful.force == pytest.approx(known.force, rel=1e-6)


@pytest.mark.parametrize("sigma", [(0.0005, 0.5), (0.001, 2.0)])
def test_doubt_about_its_rotation_gives_a_drawn_ball_no_more_points(sigma: tuple[float, float]) -> None:
    surface = hf.Sphere(0.05).surface
    ball = hf.Body("ball", hf.Mesh(surface.vertices, surface.faces), mass=1)
    low = float(ball.surface_world.vertices[:, 2].min())
    scene = hf.Scene([FLOOR, ball.moved(at(0, 0, -low))], 0.5)
    (sure,), (unsure,) = (hf.assemble(scene, pose_sigma=s).interfaces for s in (None, sigma))
    assert len(unsure.patches) == len(sure.patches)


def test_a_facet_that_stands_for_a_curved_surface_is_told() -> None:
    """A drawn tin on its side; not on its end, nor a true cylinder, a rounded box or half a rod on its flat."""
    side = tin(FACET / 2, drawn()).moved(at(0, 0, 0.04 * np.cos(np.pi / 64), lying(FACET / 2)))
    bar = prism(np.array(_rounded(0.1, 0.06, 0.005, 8)), -0.1, 0.1)
    turn = np.linspace(0, np.pi, 33)
    arch = prism(0.04 * np.column_stack([np.cos(turn), np.sin(turn)]), -0.1, 0.1)
    for body, told in (
        (side, True),
        (hf.Body("end", drawn(), mass=1, pose=at(0, 0, 0.06)), False),
        (tin(FACET / 2), False),
        (hf.Body("bar", bar, mass=1, pose=at(0, 0, 0.03, lying(0))), False),
        (hf.Body("arch", arch, mass=1, pose=at(0, 0, 0, lying(0))), False),
    ):
        (interface,) = hf.assemble(hf.Scene([FLOOR, body], 0.5)).interfaces
        assert ("facet" in interface.flags) == told


def _rounded(width: float, height: float, radius: float, steps: int) -> list[tuple[float, float]]:
    """The outline of a rectangle with rounded corners, counter-clockwise."""
    outline = []
    for quarter, (sx, sy) in enumerate(((1, 1), (-1, 1), (-1, -1), (1, -1))):
        for angle in np.linspace(0, np.pi / 2, steps + 1) + quarter * np.pi / 2:
            x, y = sx * (width / 2 - radius), sy * (height / 2 - radius)
            outline.append((x + radius * float(np.cos(angle)), y + radius * float(np.sin(angle))))
    return outline


@pytest.mark.parametrize("roll", [0.0, FACET / 2])
def test_a_rod_in_a_drawn_pipe_leans_on_its_facets_and_that_is_told(roll: float) -> None:
    """At its lowest the pipe has an edge, where the rod touches two facets along a line each."""
    drawn_pipe = trimesh.creation.annulus(r_min=0.05, r_max=0.06, height=0.3, sections=64)
    pipe = hf.Body("pipe", hf.Mesh(drawn_pipe.vertices, drawn_pipe.faces), fixed=True, pose=at(turn=lying(0)))
    rod = hf.Body("rod", hf.Cylinder(0.02, 0.25), mass=1, pose=at(0, 0, -0.03, lying(roll)))
    (interface,) = hf.assemble(hf.Scene([pipe, rod], 0.5)).interfaces
    assert "facet" in interface.flags
