"""Certified maps: every bound holds against direct solves, the gap is kept, few solves are needed."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from placed import at

import holdfast as hf
from holdfast.engines.limit.certified import CuttingPlanes, _Face
from holdfast.engines.limit.proof import LoadLimit, LoadProgram
from holdfast.engines.limit_engine import Limit
from holdfast.engines.verdict import Status
from holdfast.native import core
from holdfast.queries.request import push_columns
from holdfast.scene.shipped import shipped_scene


def counted(
    assembly: hf.answers.Assembly, bodies: list[str] | None, spacing: float, gap: float = 0.01
) -> tuple[hf.answers.RobustnessMap, int]:
    """A map and the number of solves it took."""
    solves = 0
    original = LoadProgram.maximise

    def maximise(program: LoadProgram, load: np.ndarray, around: float | None = None) -> object:
        nonlocal solves
        solves += 1
        return original(program, load, around)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(LoadProgram, "maximise", maximise)
        return hf.robustness_map(assembly, bodies, spacing=spacing, engine="limit", accuracy=gap), solves


def checked(
    assembly: hf.answers.Assembly, body: str, spacing: float, gap: float = 0.01
) -> tuple[hf.answers.RobustnessMap, int]:
    """A map whose bounds are checked by 200 direct solves; the number of solves it took."""
    result, solves = counted(assembly, [body], spacing, gap)
    finite = np.isfinite(result.upper)
    assert (result.lower <= result.upper).all()
    assert (result.lower[finite] >= (1 - gap) * result.upper[finite] * (1 - 1e-6)).all()
    assert np.isinf(result.lower[~finite]).all(), "an infinite upper bound is an answer only with an infinite lower one"
    np.testing.assert_array_equal(result.force, result.lower)
    state = Limit().prepare(assembly)
    picked = np.random.default_rng(3).choice(len(result.force), min(200, len(result.force)), replace=False)
    columns = push_columns(assembly, assembly.index[body], result.points[picked], -result.normals[picked])
    for k, column in zip(picked, columns.T, strict=True):
        exact = state.solve(column).factor
        assert result.lower[k] * (1 - 1e-6) <= exact <= result.upper[k] * (1 + 1e-6)
    return result, solves


@pytest.mark.parametrize(
    ("scene", "body"), [("cube", "cube"), ("stack", "cube3"), ("table", "slab"), ("table", "leg_left"), ("arch", "v3")]
)
def test_flat_faces(scene: str, body: str) -> None:
    assembly = hf.assemble(shipped_scene(scene))
    result, solves = checked(assembly, body, 0.005)
    assert solves < 0.35 * len(result.force)


def test_a_wider_gap_needs_fewer_solves() -> None:
    assembly = hf.assemble(shipped_scene("table"))
    assert checked(assembly, "slab", 0.01, 0.1)[1] < checked(assembly, "slab", 0.01, 0.01)[1]


def test_curved_surfaces() -> None:
    floor = shipped_scene("cube").body("floor")
    mesh = trimesh.creation.cylinder(0.05, 0.2, sections=60)
    assembly = hf.assemble(hf.Scene([floor, hf.Body("can", mesh, mass=1, position=(0, 0, 0.1))], 0.5))
    checked(assembly, "can", 0.01)


def test_presses_over_an_edge_are_endless_like_those_beside_them() -> None:
    """Over the edge of a leg only nodes in one line press, which balance no torque about it, not even that of rounding.

    What rounding leaves is then balanced by all nodes, so that the bound is large instead of infinite. A bound of 0
    would be no corner to interpolate from: each press beside the edge took a solve of its own.
    """
    assembly = hf.assemble(shipped_scene("table"))
    result, solves = counted(assembly, None, 0.02)
    assert solves < 0.25 * len(result.force)
    endless = np.isinf(result.upper)
    assert endless.sum() > 100
    assert (result.lower[endless] > 1e6 * assembly.weight).all()
    assert np.isinf(result.force[endless]).all()
    slab, state = assembly.index["slab"], Limit().prepare(assembly)
    for column in push_columns(assembly, slab, result.points[endless], -result.normals[endless]).T:
        assert state.solve(column).status is Status.INFINITE


def test_a_body_that_rolls_proves_nothing_about_pushes_on_its_neighbour() -> None:
    """A lying cylinder that touches a standing one: rolling away, it lifts nothing, so that its motion costs rounding.

    What the solver left of the neighbour's motion beside it then "proved" bounds that were 5 to 9 % too low.
    """
    r, s = 0.04186807639397955, 0.029166665800895268
    lying = np.array([[1, 0, 0], [0, 1.1102230246251565e-16, -1], [0, 1, 1.1102230246251565e-16]])
    bodies = [
        hf.Body("shelf", hf.Box((1.6, 0.5, 0.02)), pose=at(0.4, 0, -0.01), fixed=True),
        hf.Body(
            "tin", hf.Cylinder(r, 0.07902667265652444), mass=1.0660446267386987, pose=at(r, -0.015, 0.03951333632826222)
        ),
        hf.Body(
            "rod", hf.Cylinder(s, 0.12272581819436519), mass=0.6802119277564818, pose=at(2 * r + s, -0.018, s, lying)
        ),
    ]
    assembly = hf.assemble(hf.Scene(bodies, 0.23637189796230593))
    whole = hf.robustness_map(assembly, spacing=0.012, engine="limit")
    rows = np.flatnonzero(np.array(whole.body) == "tin")
    alone = hf.robustness(assembly, "tin", whole.points[rows], -whole.normals[rows], engine="limit")
    assert (whole.upper[rows] >= alone.force * (1 - 1e-6)).all()
    found = hf.robustness_map(assembly, spacing=0.012)
    assert "undecided" not in {str(status) for status in found.status}


def test_cuts_are_numbered_on_from_those_learned_before_and_keep_their_motions() -> None:
    """A load without an upper bound, or without a motion, proves no cut; bodies that hardly move get no row."""

    def limit(upper: float, motion: list[float] | None, *, proved: bool = True, certain: bool = True) -> LoadLimit:
        twists = None if motion is None else np.array(motion)
        return LoadLimit(1.0, 1.0, upper, hf.Status.FINITE, twists, twists if proved else None, certain=certain)

    slides, rolls = [1.0, *[0.0] * 11], [*[0.0] * 6, 2.0, *[0.0] * 5]
    both = [1.0, *[0.0] * 5, 1e-9, *[0.0] * 5]
    planes = CuttingPlanes(np.ones(12))
    assert planes.learn([limit(2.0, slides), limit(0.0, slides), limit(4.0, rolls)]) == [0, None, 1]
    assert planes.learn([]) == []
    assert planes.learn([limit(1.0, None), limit(1.0, both), limit(np.inf, rolls, proved=False)]) == [None, 2, 3]
    for row, expected in zip(planes.rows, ([0.5, 0.0], [0.0, 0.5], [1.0, 0.0], [0.0, 0.0]), strict=True):
        assert row[[0, 6]].tolist() == expected
    assert [motion.tolist() for motion in planes.motions] == [slides, rolls, both, rolls]
    assert planes.certain
    planes.learn([limit(1e12, slides, certain=False), limit(2.0, slides)])
    assert [planes.rows[k][0] for k in (4, 5)] == [1e-12, 0.5], "what hardly moves is told motion by motion"
    assert not planes.certain


def test_bounds_between_corners_pay_for_what_rounding_leaves_of_a_load() -> None:
    """The gauge |w| over a square of moments: above it everywhere, by hardly more where wrenches cost nothing."""
    random = np.random.default_rng(2)
    loads = np.column_stack([np.zeros((30, 2)), np.ones(30), random.uniform(-0.3, 0.3, (30, 2)), np.zeros(30)])
    face = _Face.of(np.arange(30), loads)
    face.values = np.linalg.norm(face.loads, axis=1)
    face.spare, face.endless = np.full((4, 6), np.inf), np.zeros(4, dtype=bool)
    plain, dear = (face.envelope(np.arange(30), loads, np.full(6, slope)) for slope in (0.0, 1e12))
    exact = np.linalg.norm(loads, axis=1)
    assert (plain[0] >= exact).all()
    assert not plain[1].any()
    assert ((dear[0] > plain[0] + 1e-6) & (dear[0] < plain[0] + 1.0)).all()
    face.endless[:] = True
    face.values[:] = 0.0
    above, endless, _ = face.envelope(np.arange(30), loads, np.full(6, 1e12))
    assert endless.all()
    assert (above > 0).all(), "nothing that endless corners carry besides is known"
    face.spare[:] = 1e-9
    assert (face.envelope(np.arange(30), loads, np.full(6, 1e12))[0] == 0).all()


def test_what_a_combination_misses_is_paid_for() -> None:
    """γ(w) = |D w| is a gauge known in closed form: no bound may fall below it, inside or outside the known loads."""
    rng = np.random.default_rng(0)
    D = rng.normal(size=(6, 6))
    ahead = np.array([3.0, 0, 0, 0, 0, 0])
    known = rng.normal(size=(40, 6)) + ahead
    points = np.vstack([rng.normal(size=(60, 6)), rng.normal(size=(60, 6)) * 0.3 + ahead])
    near = np.argsort(((points[:, None] - known) ** 2).sum(2), axis=1)[:, :10]
    gauge = np.linalg.norm(known @ D.T, axis=1)
    axes = np.tile(np.linalg.norm(D, axis=0), (2, 1))
    bound = core.combined(points, known, near.astype(np.int64), gauge, axes, 1e-14)
    exact = np.linalg.norm(points @ D.T, axis=1)
    assert (bound >= exact * (1 - 1e-9)).all()
    np.testing.assert_allclose(
        core.combined(2 * known, known, near[:40] * 0 + np.arange(40)[:, None], gauge, axes, 1e-14), 2 * gauge
    )
