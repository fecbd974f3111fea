"""Derivatives of answers by poses, friction, masses and pushes: closed forms, invariances, differences and kinks."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import holdfast as hf
from bench.scenes.shelf import shelf
from holdfast.answers import Assembly, Derivatives, Robustness
from holdfast.assembly.node_motion import displaced, node_motion
from holdfast.base.arrays import Float
from holdfast.scene.shipped import shipped_scene
from holdfast.scene.shipped.blocks import box, cube, floor
from holdfast.sets import gradients

G = 9.81
X = np.array([1.0, 0, 0])


def found_for(
    scene: hf.Scene, body: str, point: Any, way: Any, **options: Any
) -> tuple[Assembly, Robustness, Derivatives]:
    assembly = hf.assemble(scene)
    answer = hf.robustness(assembly, body, point, way, engine="limit", **options)
    return assembly, answer, gradients(assembly, answer)


def moved(assembly: Assembly, answer: Robustness, name: str, twist: Float) -> float:
    """The push of the first row after a body has moved by ``twist`` about its origin, with the pushes on it."""
    pose = assembly.scene.body(name).pose
    motion = displaced(np.eye(4), twist, pose[:3, 3])
    p, e = answer.points[0], answer.directions[0]
    if name == answer.body:
        p, e = motion[:3, :3] @ p + motion[:3, 3], motion[:3, :3] @ e
    there = assembly.moved({name: motion @ pose})
    return float(hf.robustness(there, answer.body, p, e, engine=answer.engine).force[0])


def test_a_toppling_cube_in_closed_form() -> None:
    """R = m g (L/2 + c) / h: a corner of the cube is a corner of the patch, on the side away from the push."""
    h = 0.09
    _, _, g = found_for(hf.Scene(cube().bodies, 2.0), "cube", [-0.05, 0.01, h], X)
    r = G * 0.05 / h
    np.testing.assert_allclose(g.force, r, rtol=1e-8)
    np.testing.assert_allclose(g.point, [[0, 0, -r / h]], atol=1e-6)
    np.testing.assert_allclose(g.mass["cube"], r, rtol=1e-7)
    np.testing.assert_allclose(g.friction["floor", "cube"], 0, atol=1e-6)
    # about y, the cube leans over its edge: centre, push, its direction and the edge turn, the gap opens by half
    np.testing.assert_allclose(g.pose["cube"][0, [0, 1]], 0, atol=1e-6)
    assert not g.kinks
    assert g.from_multipliers.all()


def test_a_sliding_cube_in_closed_form() -> None:
    """Along (cos a, 0, -sin a), R = mu m g / (cos a - mu sin a)."""
    a, mu = np.radians(20), 0.6
    way = np.array([np.cos(a), 0, -np.sin(a)])
    _, _, g = found_for(cube(), "cube", [-0.05, 0, 0.02], way)
    r = mu * G / (np.cos(a) - mu * np.sin(a))
    np.testing.assert_allclose(g.force, r, rtol=1e-8)
    steeper = r * (np.sin(a) + mu * np.cos(a)) / (np.cos(a) - mu * np.sin(a))  # dR/da
    np.testing.assert_allclose(g.direction[0] @ [-np.sin(a), 0, -np.cos(a)], steeper, rtol=1e-6)
    np.testing.assert_allclose(g.direction[0] @ way, 0, atol=1e-9)
    np.testing.assert_allclose(
        g.friction["floor", "cube"], r / mu + r * np.sin(a) / (np.cos(a) - mu * np.sin(a)), rtol=1e-6
    )
    np.testing.assert_allclose(g.mass["cube"], r, rtol=1e-7)


PUSHED = [
    ("wall2x2", "b1_0", "limit"),
    ("slope", "wedge", "limit"),
    ("tabletop", "bottle", "limit"),
    ("v_groove", "cube", "limit"),
    ("table", "slab", "compliant"),
]


@pytest.mark.parametrize(("name", "body", "engine"), PUSHED)
def test_derivatives_by_poses_are_those_of_moved_scenes(name: str, body: str, engine: str) -> None:
    assembly = hf.assemble(shipped_scene(name))
    vertices = assembly.scene.body(body).surface_world.vertices
    point, way = vertices[np.argmax(vertices @ [1.0, 0.3, 0.5])], np.array([-1.0, 0.2, -0.1])
    answer = hf.robustness(assembly, body, point, way, engine=engine)
    g = gradients(assembly, answer)
    told = {kink.by for kink in g.kinks}
    size = assembly.scene.body(body).size
    checked = 0
    for other in dict.fromkeys([body, *(one.name for one in assembly.bodies)][:3]):
        for k, words in enumerate(("along x", "along y", "along z", "about x", "about y", "about z")):
            step = 5e-5 * (size if k < 3 else 1.0) * np.eye(6)[k]
            up, down = (moved(assembly, answer, other, sign * step) for sign in (1, -1))
            if f"pose of {other}, {words}" not in told:
                unit = float(answer.force[0]) / (size if k < 3 else 1.0)
                tolerance = 2e-5 if engine == "limit" else 1e-3
                assert g.pose[other][0, k] == pytest.approx(
                    (up - down) / (2 * step.sum()), abs=tolerance * unit, rel=tolerance
                )
                checked += 1
    assert checked >= 3


@pytest.mark.parametrize("name", ["table", "tabletop", "arch", "shelf"])
def test_a_motion_of_the_whole_scene_changes_nothing(name: str) -> None:
    """Along any axis and about the vertical: the sum over all bodies, wherever each one's origin is."""
    scene = shelf() if name == "shelf" else shipped_scene(name)
    body = scene.movable[1]
    vertices = body.surface_world.vertices
    assembly, answer, g = found_for(
        scene, body.name, vertices[np.argmax(vertices @ [1.0, 0.3, 0.5])], [-1.0, 0.2, -0.1]
    )
    both = [np.zeros(6), np.zeros(6)]
    for one in scene.bodies:
        for total, slopes in zip(both, (g.before, g.after), strict=True):
            slope, at = slopes.pose[one.name][0], one.pose[:3, 3]
            total += np.concatenate([slope[:3], slope[3:] + np.cross(at, slope[:3])])
    if not g.kinks:
        np.testing.assert_allclose(both[0][[0, 1, 2, 5]], 0, atol=1e-6 * answer.force[0] / assembly.size)
    assert np.isfinite(both).all()


def test_flush_edges_have_two_sides() -> None:
    """The upper of two equal cubes: moved away from the edge it tips over it tips later, and no later the other way."""
    bodies = [floor(), box("low", (0.1, 0.1, 0.1), 5, (0, 0, 0.05)), box("high", (0.1, 0.1, 0.1), 1, (0, 0, 0.15))]
    _, answer, g = found_for(hf.Scene(bodies, 2.0), "high", [-0.05, 0, 0.19], X)
    r = G * 0.05 / 0.09
    np.testing.assert_allclose(answer.force, r, rtol=1e-8)
    assert "pose of high, along x" in {kink.by for kink in g.kinks}
    np.testing.assert_allclose([g.before.pose["high"][0, 0], g.after.pose["high"][0, 0]], [0, -G / 0.09], atol=1e-2)
    assert g.pose["high"][0, 0] == pytest.approx(0, abs=1e-2)  # neither side promises anything that the other does not


def test_rows_without_a_finite_answer_are_zero() -> None:
    _, answer, g = found_for(cube(), "cube", [[0, 0, 0.1], [-0.05, 0, 0.02]], [[0, 0, -1.0], [1.0, 0, 0]])
    assert not np.isfinite(answer.force[0])
    assert g.known.tolist() == [False, True]
    assert not g.pose["cube"][0].any()
    assert not g.mass["cube"][0].any()
    assert g.mass["cube"][1] > 0


def test_a_load_factor_and_transport_limits() -> None:
    """A sliding cube: both are mu g times what is pushed, and do not depend on the mass for the carrier."""
    assembly = hf.assemble(cube())
    factor = hf.load_factor(assembly, [hf.Load("cube", (0, 0, 0.02), force=(2, 0, 0))], engine="limit")
    g = gradients(assembly, factor)
    np.testing.assert_allclose(g.mass["cube"], 0.6 * G / 2, rtol=1e-6)
    np.testing.assert_allclose(g.friction["floor", "cube"], G / 2, rtol=1e-6)
    limits = hf.transport_limits(assembly, [[1.0, 0, 0]], engine="limit")
    g = gradients(assembly, limits)
    np.testing.assert_allclose(g.force, 0.6 * G, rtol=1e-6)
    np.testing.assert_allclose(g.mass["cube"], 0, atol=1e-6)
    np.testing.assert_allclose(g.friction["floor", "cube"], G, rtol=1e-6)


@pytest.mark.parametrize("name", ["table", "tabletop", "v_groove", "arch"])
def test_corners_of_faces_move_as_contacts_detected_again(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """The closed form is the mean of both sides, and one of its alternatives where no edges are flush."""
    import holdfast.assembly.node_motion as module

    assembly = hf.assemble(shipped_scene(name))
    for contact in assembly.interfaces:
        points = np.vstack([patch.hull for patch in contact.patches])
        normals = np.vstack([np.tile(patch.normal, (len(patch.hull), 1)) for patch in contact.patches])
        closed = node_motion(assembly, [contact], points, normals)
        with monkeypatch.context() as patched:
            patched.setattr(module, "_of_faces", lambda *_: None)
            again = node_motion(assembly, [contact], points, normals)
        smooth = ~again.changed & (np.ptp(closed.shift, axis=0).max(axis=(0, 1)) < 1e-9)
        for one, other in ((closed.shift, again.shift), (closed.turn, again.turn)):
            np.testing.assert_allclose(one[..., smooth].mean(0), other[..., smooth].mean(0), atol=1e-5)


def test_compliant_answers_that_reach_the_limit_have_its_slopes() -> None:
    assembly = hf.assemble(cube())
    points = [[-0.05, 0, 0.02], [-0.05, 0, 0.09]]
    answers = [hf.robustness(assembly, "cube", points, X, engine=engine) for engine in ("limit", "compliant")]
    limit, compliant = (gradients(assembly, answer) for answer in answers)
    assert compliant.from_multipliers.all()
    np.testing.assert_allclose(compliant.mass["cube"], limit.mass["cube"], rtol=1e-3)
    np.testing.assert_allclose(compliant.pose["cube"], limit.pose["cube"], atol=2e-2)


def test_a_smooth_least_push() -> None:
    _, answer, g = found_for(cube(), "cube", [[-0.05, 0, 0.02], [-0.05, 0, 0.09]], X)
    force, weights = g.soft_weights(0.1)
    assert answer.force.min() - 0.1 * np.log(2) <= force <= answer.force.min()
    assert weights.sum() == pytest.approx(1)
    assert (weights >= 0).all()


def test_only_some_bodies() -> None:
    assembly = hf.assemble(shipped_scene("table"))
    corner = assembly.scene.body("slab").surface_world.vertices[0]
    answer = hf.robustness(assembly, "slab", corner, [-1.0, 0, 0], engine="limit")
    g = gradients(assembly, answer, bodies=["slab"])
    assert [*g.pose] == ["slab"] == [*g.mass]
    assert all("slab" in pair for pair in g.friction)


def test_what_it_does_not_take() -> None:
    assembly = hf.assemble(cube())
    with pytest.raises(hf.HoldfastError, match="about no load"):
        gradients(assembly, hf.stability(assembly))  # type: ignore[arg-type]
    answer = hf.robustness(assembly, "cube", [-0.05, 0, 0.02], X, engine=hf.Limit("inscribed", 4))
    with pytest.raises(hf.HoldfastError, match="without options"):
        gradients(assembly, answer)
    with pytest.raises(hf.HoldfastError, match="another assembly"):
        gradients(hf.assemble(shipped_scene("table")), answer)
    tipped = hf.transport_limits(assembly, [[1.0, 0, 0]], tilt_degrees=(0, 5, 0), engine="limit")
    assert gradients(assembly, tipped).known.all()
    answer = hf.robustness(assembly, "cube", [-0.05, 0, 0.02], X, engine="limit")
    pose = displaced(assembly.scene.body("cube").pose, 0.01 * np.eye(6)[0], np.zeros(3))
    for other in (assembly.moved({"cube": pose}), assembly.with_friction({("floor", "cube"): 0.3})):
        with pytest.raises(hf.HoldfastError, match="another assembly"):
            gradients(other, answer)
