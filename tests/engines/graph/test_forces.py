"""Contact forces at rest (eq. 8-11), verdicts with their certificates, and the options that change the problem."""

import numpy as np
import pytest
from engine_scenes import X, Y, Z, block, cube_scene, floor, moved, pose, rescaled, surface_points
from graph_scenes import push, random_motion

from holdfast import Graph, Scene, Status, assemble, robustness, stability
from holdfast.answers import Assembly, Stability
from holdfast.scene.shipped import shipped_scene, shipped_scenes


def balance(assembly: Assembly, answer: Stability) -> float:
    """Largest unbalanced force and torque over weight and size, from a dense G about the world origin."""
    forces = answer.forces
    assert forces is not None
    count = len(forces.points)
    G = np.zeros((6 * len(assembly.bodies), 3 * count))
    row = {body.name: 6 * k for k, body in enumerate(assembly.bodies)}
    for i, (x, y, z) in enumerate(forces.points):
        cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])  # p x f
        receiver_last = zip(assembly.interfaces[forces.interface[i]].bodies, (-1, 1), strict=True)
        for name, sign in receiver_last:
            G[row[name] : row[name] + 6, 3 * i : 3 * i + 3] += sign * np.vstack([np.eye(3), cross])
    wrench = G @ forces.force.ravel()
    worst = 0.0
    for body in assembly.movable:
        centre = body.pose[:3, :3] @ body.com_body + body.pose[:3, 3]
        weight = body.mass * assembly.scene.gravity
        total = wrench[row[body.name] : row[body.name] + 6] + np.concatenate([weight, np.cross(centre, weight)])
        worst = max(worst, float(np.abs(total / np.repeat([1, assembly.size], 3)).max()))
    return worst / assembly.weight


@pytest.mark.parametrize("name", shipped_scenes())
def test_shipped_scenes_are_in_equilibrium_inside_their_cones(name: str) -> None:
    assembly = assemble(shipped_scene(name))
    answer = stability(assembly, engine="graph")
    assert answer.status is Status.STABLE
    assert balance(assembly, answer) < 1e-9
    assert answer.residual < 1e-9
    forces = answer.forces
    assert forces is not None
    normal = (forces.force * forces.normal).sum(1)
    tangential = np.linalg.norm(forces.force - normal[:, None] * forces.normal, axis=1)
    mu = np.array(assembly.mu)[forces.interface]
    assert normal.min() > -1e-9 * assembly.weight
    assert (tangential - mu * normal).max() < 1e-9 * assembly.weight
    assert forces.usage.max() <= 1 + 1e-6


def leaning(mu: float, ratio: float, azimuth: float) -> Scene:
    """A flat box under gravity that leans by tan = mu · ratio towards an azimuth."""
    tangent = mu * ratio
    lean = np.array([tangent * np.cos(azimuth), tangent * np.sin(azimuth), -1]) / np.hypot(1, tangent)
    return Scene([floor(), block("box", (0.2, 0.2, 0.02), (0, 0, 0.01))], mu, 9.81 * lean)


def certified(assembly: Assembly, answer: Stability) -> None:
    """Re-checks the collapse with nothing but the twists: it gains power and no patch corner can resist it."""
    mechanism = answer.mechanism
    assert mechanism is not None
    power = sum(body.mass * assembly.scene.gravity @ mechanism.twists[k, :3] for k, body in enumerate(assembly.movable))
    assert power > 0
    for interface, (a, b), mu in zip(assembly.interfaces, assembly.ends, assembly.mu, strict=True):
        for patch in interface.patches:
            for p in patch.hull:
                u = np.zeros(3)
                for k, sign in ((b, 1), (a, -1)):
                    if k >= 0:
                        v, w = mechanism.twists[k, :3], mechanism.twists[k, 3:]
                        u += sign * (v + np.cross(w, p - assembly.movable[k].com_world))
                u_n = u @ patch.normal
                assert u_n - mu * np.linalg.norm(u - u_n * patch.normal) >= -1e-5


@pytest.mark.parametrize("azimuth", np.linspace(0.05, 2 * np.pi, 9))
@pytest.mark.parametrize("mu", [0.3, 0.8])
def test_a_slope_slips_at_tan_theta_equal_mu_in_every_direction(mu: float, azimuth: float) -> None:
    motion = random_motion(int(100 * azimuth))
    for place in (pose((0, 0, 0)), motion):
        stands = assemble(moved(leaning(mu, 1 - 1e-4, azimuth), place))
        answer = stability(stands, engine="graph")
        assert answer.status is Status.STABLE
        assert balance(stands, answer) < 1e-7
        slides = assemble(moved(leaning(mu, 1 + 1e-4, azimuth), place))
        answer = stability(slides, engine="graph")
        assert answer.status is Status.UNSTABLE
        assert answer.certificate is not None
        assert answer.certificate.power > 0
        certified(slides, answer)


def test_an_overhanging_plate_falls_with_a_certificate_and_scores_zero() -> None:
    column = block("column", (0.1, 0.1, 0.1), (0, 0, 0.05), fixed=True)
    for offset, status in ((0.0499, Status.STABLE), (0.0501, Status.UNSTABLE)):
        assembly = assemble(Scene([column, block("plate", (0.3, 0.1, 0.02), (offset, 0, 0.11))], 0.6))
        answer = stability(assembly, engine="graph")
        assert answer.status is status
        if status is Status.UNSTABLE:
            certified(assembly, answer)
            assert answer.moving == ("plate",)
            assert push(assembly, "plate", (-0.05, 0, 0.12), -Z) == 0  # though this push would hold it


def test_pressure_under_a_centred_cube_is_uniform() -> None:
    for sampling in ("hull", "quadrature"):
        rest = Graph(sampling=sampling).prepare(assemble(cube_scene())).rest  # type: ignore[arg-type]
        np.testing.assert_allclose(rest.forces[:, 0], 9.81 * rest.nodes.weights / 0.01, rtol=1e-6)
        np.testing.assert_allclose(rest.forces[:, 1:], 0, atol=1e-8)


def test_pressure_under_an_eccentric_weight_is_linear() -> None:
    """Weighted least squares with exact second moments is Navier's formula: p = N/A (1 + 12 e x / L²)."""
    rest = Graph().prepare(assemble(cube_scene(gravity=(1.0, 0, -9.81)))).rest
    x = rest.nodes.points[:, 0]
    expected = rest.nodes.weights / 0.01 * (9.81 + 12 * 1.0 * 0.05 * x / 0.01)
    np.testing.assert_allclose(rest.forces[:, 0], expected, rtol=1e-5)


@pytest.mark.parametrize("name", ["table", "wall2x2", "slope", "cantilever"])
def test_all_masses_times_gamma_multiply_r_by_gamma(name: str) -> None:
    scene = shipped_scene(name)
    rng = np.random.default_rng(9)
    for body in scene.movable:
        p, e = surface_points(body, 12, rng), rng.normal(size=(12, 3))
        r, lighter, margin = (
            robustness(assemble(s), body.name, p, e, engine=engine).force
            for s, engine in (
                (scene, Graph()),
                (rescaled(scene, mass=0.7), Graph()),
                (scene, Graph(mass_margin=0.3)),
            )
        )
        np.testing.assert_allclose(lighter, 0.7 * r, rtol=1e-4)
        np.testing.assert_allclose(margin, 0.7 * r, rtol=1e-4)


def pile(*, base_fixed: bool) -> Scene:
    base = block("base", (0.2, 0.2, 0.1), (0, 0, 0.05), 50, fixed=base_fixed)
    top = [block(f"cube{k}", (0.1, 0.1, 0.1), (0.01 * k, 0, 0.05 + 0.1 * k)) for k in (1, 2)]
    return Scene([floor(), base, *top], 0.6)


def test_immobile_above_is_like_fixing_the_heavy_body_in_the_graph() -> None:
    movable, fixed = assemble(pile(base_fixed=False)), assemble(pile(base_fixed=True))
    rng = np.random.default_rng(10)
    engine = Graph(immobile_above=10)
    for name in ("cube1", "cube2"):
        p, e = surface_points(movable.scene.body(name), 25, rng), rng.normal(size=(25, 3))
        answer = robustness(movable, name, p, e, engine=engine)
        np.testing.assert_allclose(answer.force, robustness(fixed, name, p, e, engine="graph").force, rtol=1e-4)
        assert any("base" in note for note in answer.notes)
    answer = robustness(movable, "base", (-0.1, 0, 0.05), X, engine=engine)
    assert answer.status[0] is Status.INFINITE
    assert push(movable, "base", (-0.1, 0, 0.05), X) == pytest.approx(0.6 * 52 * 9.81)


def test_immobile_bodies_elsewhere_in_the_order() -> None:
    """The numbering of the mobile bodies must survive bodies taken out from the middle."""
    scene = pile(base_fixed=False)
    shuffled = Scene([scene.bodies[k] for k in (2, 1, 3, 0)], 0.6)
    for name, z in (("cube1", 0.19), ("cube2", 0.29)):
        x = (0.01 if name == "cube1" else 0.02) - 0.05
        one, two = (push(assemble(s), name, (x, 0, z), X, immobile_above=10) for s in (scene, shuffled))
        assert one == pytest.approx(two, rel=1e-6)


def test_isolated_judges_every_body_between_fixed_neighbours() -> None:
    """Stack of three: in isolation a cube's two interfaces act in parallel, as a graph the weaker ones yield."""
    assembly = assemble(shipped_scene("stack"))
    for k, alone in ((1, 0.6 * 9.81 * (3 + 2)), (2, 0.6 * 9.81 * (2 + 1)), (3, 0.6 * 9.81)):
        point = (-0.05, 0, 0.1 * k - 0.05)
        assert push(assembly, f"cube{k}", point, X, isolated=True) == pytest.approx(alone)
    assert push(assembly, "cube2", (-0.05, 0, 0.15), X) == pytest.approx(9.81)  # all three turn over the lowest edge
    assert push(assembly, "cube1", (0, -0.05, 0.05), Y) == pytest.approx(0.6 * 9.81 * 3)
    alone = robustness(assembly, "cube1", (0, 0.05, 0.05), -Y, engine=Graph(isolated=True))
    assert any("alone" in note for note in alone.notes)
