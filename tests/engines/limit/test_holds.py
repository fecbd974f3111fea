"""Bodies held by hands, fingers and suction cups: closed forms of every set, on one body and on two."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import pytest
from scipy.optimize import linprog

import holdfast as hf
from holdfast.base.arrays import Float
from holdfast.base.errors import SceneError
from holdfast.base.rigid import cross, transform
from holdfast.sets import sensitivity, worst_case

G, LIMIT, INF = 9.81, hf.Limit(), float("inf")
CLOSE = {"rel": 1e-6, "abs": 1e-9}
TURN = hf.pose(0.3, -0.2, 1.4, roll=20, pitch=-35, yaw=110)


CUBE = hf.Box((0.1, 0.1, 0.1))


def cup(holds: Iterable[hf.Hold | hf.Grip], mass: float = 0.3, shape: hf.Box | hf.Cylinder = CUBE) -> hf.Scene:
    """A cube of 0.1 m whose centre is at (0, 0, 1), in the air."""
    floor = hf.Body("floor", hf.Box((1, 1, 0.1)), fixed=True, position=(0, 0, -0.05))
    return hf.Scene([floor, hf.Body("cup", shape, mass=mass, position=(0, 0, 1))], 0.5, holds=holds)


def pushed(
    scene: hf.Scene, point: tuple[float, float, float], way: tuple[float, float, float], body: str = "cup"
) -> float:
    """The largest force along ``way`` at a point, which must be proved from both sides."""
    found = hf.load_factor(scene, [hf.Load(body, point, way)], engine=LIMIT)
    assert found.lower <= float(found) <= found.upper
    assert found.lower_bound == found.upper_bound == "proved"
    if np.isfinite(float(found)):
        assert found.upper - found.lower <= 1e-6 * max(found.upper, 0.01)
    return float(found)


def moved(scene: hf.Scene, motion: Float) -> hf.Scene:
    """The same scene at another place, gravity turned with it."""
    whole = scene.moved({body.name: motion @ body.pose for body in scene.bodies})
    return hf.Scene(whole.bodies, whole.friction, motion[:3, :3] @ scene.gravity, holds=whole.holds)


@pytest.mark.parametrize("way", [(1, 0, 0), (0, 0, 1), (0, 0, -1), (0.6, 0, 0.8), (0.36, 0.48, -0.8)])
def test_a_ball_of_forces_at_the_centre_of_mass(way: tuple[float, float, float]) -> None:
    """|s d - m g z| = F."""
    scene = cup([hf.Hold("cup", hf.pose(0, 0, 1, yaw=33, roll=12), forces=5.0, moments=INF)])
    w, d = 0.3 * G, way[2]
    assert pushed(scene, (0, 0, 1), way) == pytest.approx(w * d + np.sqrt((w * d) ** 2 + 25 - w * w), **CLOSE)


@pytest.mark.parametrize(("way", "most"), [((0, -1, 0), 0.2 / 0.05), ((1, 0, 0), 0.2 / 0.05), ((0, 0, 1), 5 + 0.3 * G)])
def test_a_ball_of_moments(way: tuple[float, float, float], most: float) -> None:
    """A push across at the height h over the hold needs the moment s h."""
    scene = cup([hf.Hold("cup", hf.pose(0, 0, 1), forces=5.0, moments=0.2)])
    assert pushed(scene, (0, 0, 1.05), way) == pytest.approx(most, **CLOSE)


@pytest.mark.parametrize(
    ("way", "most"),
    [((1, 0, 0), 3), ((-1, 0, 0), 7), ((0, 1, 0), 0), ((0, -1, 0), 2), ((0, 0, 1), 1 + 0.3 * G), ((0, 0, -1), INF)],
)
def test_a_box_of_forces_that_is_unequal_in_both_senses(way: tuple[float, float, float], most: float) -> None:
    hold = hf.Hold("cup", hf.pose(0, 0, 1), forces=((-3, 7), (0, 2), (-1, INF)), moments=0.1)
    assert pushed(cup([hold]), (0, 0, 1), way) == pytest.approx(most, **CLOSE)


def test_a_box_of_moments_turns_with_its_frame() -> None:
    """About the x axis of a frame that is turned by 90 degrees about z, the body's y axis."""
    hold = hf.Hold("cup", hf.pose(0, 0, 1, yaw=90), forces=INF, moments=(0.1, 0.2, (-0.3, 0.4)))
    for way, most in (((1, 0, 0), 0.1), ((0, 1, 0), 0.2)):
        assert pushed(cup([hold]), (0, 0, 1.05), way) == pytest.approx(most / 0.05, **CLOSE)
    assert pushed(cup([hold]), (0.05, 0, 1), (0, 1, 0)) == pytest.approx(0.3 / 0.05, **CLOSE)
    assert pushed(cup([hold]), (0.05, 0, 1), (0, -1, 0)) == pytest.approx(0.4 / 0.05, **CLOSE)


def test_a_range_that_excludes_zero_pushes_all_the_time() -> None:
    """A hand that pulls up with 2 to 5 N leaves a weight of 2.943 N; held down by 4 to 5 N, it does not stand."""
    assert hf.stability(cup([hf.Hold("cup", hf.pose(0, 0, 1), forces=(0, 0, (2, 5)))]), engine=LIMIT).stable
    falls = hf.stability(cup([hf.Hold("cup", hf.pose(0, 0, 1), forces=(0, 0, (3, 5)))]), engine=LIMIT)
    assert falls.status is hf.Status.UNSTABLE


def test_how_hard_a_body_may_be_pulled_from_a_hand_far_from_its_frame() -> None:
    """The moment of the weight about the hold, at the lever a, takes its share of the bound: s h = M - m g a."""
    hold = hf.Hold("cup", hf.pose(0.04, 0, 1), forces=50.0, moments=(INF, 0.3, INF))
    assert pushed(cup([hold]), (0, 0, 1), (0, 0, -1)) == pytest.approx(0.3 / 0.04 - 0.3 * G, **CLOSE)


@pytest.mark.parametrize("mass", [0.3, 1e-3, 40.0])
def test_a_pinch_needs_a_grip_force_of_half_the_weight_over_mu(mass: float) -> None:
    """2 μ F >= m g (Q9 of the findings), and what is left may pull down."""
    points, normals = [(0.05, 0, 1), (-0.05, 0, 1)], [(-1, 0, 0), (1, 0, 0)]
    needed = mass * G / (2 * 0.4)
    for share, status in ((1 - 1e-6, hf.Status.UNSTABLE), (1 + 1e-6, hf.Status.STABLE)):
        found = hf.stability(cup([hf.Grip("cup", points, normals, 0.4, share * needed)], mass), engine=LIMIT)
        assert found.status is status
    grip = hf.Grip("cup", points, normals, 0.4, 1.5 * needed)
    assert pushed(cup([grip], mass), (0, 0, 1), (0, 0, -1)) == pytest.approx(0.5 * mass * G, **CLOSE)
    assert pushed(cup([grip], mass), (0, 0, 1), (0, 1, 0)) == pytest.approx(np.sqrt(1.25) * mass * G, **CLOSE)
    assert hf.stability(cup([grip], mass), engine=LIMIT).verdict.balanced == ("cup",)  # it turns about the two points


def test_three_fingers_share_the_weight() -> None:
    angle = 2 * np.pi * np.arange(3) / 3
    ways = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(3)])
    needed, can = 0.3 * G / (3 * 0.5), hf.Cylinder(0.04, 0.1)
    for share, stands in ((1 - 1e-6, False), (1 + 1e-6, True)):
        grip = hf.Grip("cup", (0, 0, 1) + 0.04 * ways, -ways, 0.5, share * needed)
        assert hf.stability(cup([grip], shape=can), engine=LIMIT).stable is stands
    one_weak = hf.Grip("cup", (0, 0, 1) + 0.04 * ways, -ways, 0.5, (9.0, 9.0, 0.1))
    # the other two cannot press without the third
    assert not hf.stability(cup([one_weak], shape=can), engine=LIMIT).stable


@pytest.mark.parametrize("lever", [0.0, 0.01, 0.03])
def test_a_suction_cup_comes_off_and_peels(lever: float) -> None:
    """Vacuum V and a ring of radius r: s (r + a) = (V - m g) r about the edge of the seal; V - m g in the middle."""
    scene = cup([hf.Grip.suction("cup", hf.pose(0, 0, 1.05), force=40.0, radius=0.02, mu=0.5)])
    assert pushed(scene, (lever, 0, 0.95), (0, 0, -1)) == pytest.approx((40 - 0.3 * G) * 0.02 / (0.02 + lever), **CLOSE)
    assert pushed(scene, (0, 0, 1.05), (1, 0, 0)) == pytest.approx(0.5 * (40 - 0.3 * G), rel=1e-4)  # it slides


def test_a_suction_cup_as_a_plain_bound_pulls_so_much_and_pushes_any() -> None:
    hold = hf.Hold("cup", hf.pose(0, 0, 1.05), forces=(9, 9, (-INF, 40)), moments=0.5)
    assert pushed(cup([hold]), (0, 0, 1), (0, 0, -1)) == pytest.approx(40 - 0.3 * G, **CLOSE)
    assert pushed(cup([hold]), (0, 0, 1), (0, 0, 1)) == INF


def stack(holds: Iterable[hf.Hold | hf.Grip]) -> hf.Scene:
    """A wide slab of 2 kg on the floor, a block of 1 kg on it."""
    bodies = [
        hf.Body("floor", hf.Box((3, 3, 0.1)), fixed=True, position=(0, 0, -0.05)),
        hf.Body("slab", hf.Box((0.8, 0.8, 0.05)), mass=2.0, position=(0, 0, 0.025)),
        hf.Body("block", hf.Box((0.4, 0.4, 0.1)), mass=1.0, position=(0, 0, 0.1)),
    ]
    return hf.Scene(bodies, 0.5, holds=holds)


def test_two_bodies_the_hand_presses_and_pulls_where_that_helps_most() -> None:
    """A hand on the block with |F| <= 3 holds the slab by friction: μ (W + p) + h with p² + h² = 9."""
    held = stack([hf.Hold("block", hf.pose(0, 0, 0.1), forces=3.0, moments=INF)])
    most = 0.5 * 3 * G + 3 * np.sqrt(1.25)
    assert pushed(stack([]), (0.4, 0, 0.025), (1, 0, 0), "slab") == pytest.approx(0.5 * 3 * G, **CLOSE)
    assert pushed(held, (0.4, 0, 0.025), (1, 0, 0), "slab") == pytest.approx(most, **CLOSE)


def test_a_motion_of_what_is_held_names_contacts_alone() -> None:
    held = stack([hf.Hold("block", hf.pose(0, 0, 0.1), forces=3.0, moments=INF)])
    found = hf.robustness(held, "slab", (0.4, 0, 0.025), (1, 0, 0), engine=LIMIT)
    motion = found.mechanism[0]
    assert set(motion.moving) == {"slab", "block"}
    assert motion.twists.shape == (2, 6)
    assert "floor-slab" in motion.text or "slab-floor" in motion.text


def test_answers_do_not_depend_on_where_the_scene_is() -> None:
    scenes = [
        cup([hf.Hold("cup", hf.pose(0.01, 0.02, 1.03, pitch=15), forces=((-3, 7), 6, (-9, INF)), moments=0.4)]),
        cup([hf.Grip("cup", [(0.05, 0.01, 1), (-0.05, 0, 1)], [(-1, 0, 0), (1, 0, 0)], 0.6, 9.0)]),
        cup([hf.Grip.suction("cup", hf.pose(0, 0, 1.05), 40.0, 0.02, 0.5)]),
    ]
    for scene in scenes:
        there = moved(scene, TURN)
        for way in ((0, 0, -1), (0.3, 0.2, -1), (1, 0.1, 0.4)):
            point, turned = transform(TURN, np.array([(0.02, 0, 1.05)]))[0], TURN[:3, :3] @ way
            here = float(hf.load_factor(scene, [hf.Load("cup", (0.02, 0, 1.05), way)], engine=LIMIT))
            other = float(hf.load_factor(there, [hf.Load("cup", point, turned)], engine=LIMIT))
            assert other == pytest.approx(here, rel=1e-6, abs=1e-6)


def test_beside_an_independent_linear_program() -> None:
    """Random boxes of forces and moments at random frames, on a body in the air."""
    rng = np.random.default_rng(5)
    for _ in range(25):
        holds, sets = [], []
        for _ in range(int(rng.integers(1, 4))):
            frame = hf.pose(*rng.uniform(-0.05, 0.05, 2), 1.0, roll=rng.uniform(0, 360), pitch=rng.uniform(-80, 80))
            low, high = (
                -rng.uniform(0, 8, 6) * [1, 1, 1, 0.1, 0.1, 0.1],
                rng.uniform(0, 8, 6) * [1, 1, 1, 0.1, 0.1, 0.1],
            )
            low[rng.random(6) < 0.1], high[rng.random(6) < 0.1] = -INF, INF
            pairs = [(float(a), float(b)) for a, b in zip(low, high, strict=True)]
            holds.append(hf.Hold("cup", frame, forces=tuple(pairs[:3]), moments=tuple(pairs[3:])))
            sets.append((frame, pairs))
        load = np.concatenate([rng.normal(size=3), 0.05 * rng.normal(size=3)])
        columns, bounds = [], []
        for frame, pairs in sets:
            for k, axis in enumerate(frame[:3, :3].T):
                columns.append(np.concatenate([axis, cross(frame[:3, 3] - [0, 0, 1], axis)]))
                bounds.append(pairs[k])
            for k, axis in enumerate(frame[:3, :3].T):
                columns.append(np.concatenate([np.zeros(3), axis]))
                bounds.append(pairs[3 + k])
        A, b = np.column_stack([*columns, load]), np.array([0, 0, 0.3 * G, 0, 0, 0])
        none = linprog(np.zeros(len(columns)), A_eq=A[:, :-1], b_eq=b, bounds=bounds)
        true = linprog(np.append(np.zeros(len(columns)), -1), A_eq=A, b_eq=b, bounds=[*bounds, (0, None)])
        found = hf.load_factor(cup(holds), [hf.Load("cup", (0, 0, 1), load[:3], load[3:])], engine=LIMIT)
        if none.status == 2:
            assert found.status is hf.Status.UNSTABLE
        elif true.status == 3:
            assert found.status is hf.Status.INFINITE
        else:
            assert float(found) == pytest.approx(-true.fun, rel=1e-6, abs=1e-8)
            assert found.lower <= -true.fun * (1 + 1e-9)
            assert found.upper >= -true.fun * (1 - 1e-9)


def test_a_certified_map_of_what_is_held() -> None:
    scene = stack([hf.Hold("block", hf.pose(0, 0, 0.1), forces=3.0, moments=0.3)])
    whole = hf.robustness_map(scene, ["block"], spacing=0.1, accuracy=0.02, engine=LIMIT)
    exact = hf.robustness(scene, "block", whole.points, -whole.normals, engine=LIMIT)
    assert (whole.lower <= exact.upper * (1 + 1e-9)).all()
    assert (whole.upper >= exact.lower * (1 - 1e-9)).all()
    assert whole.lower == pytest.approx(exact.force, rel=0.02)


def test_derivatives_and_worst_cases_of_what_is_held() -> None:
    scene = hf.assemble(cup([hf.Hold("cup", hf.pose(0, 0, 1), forces=5.0, moments=INF)]))
    found = sensitivity(scene, "cup", (0, 0, 1.05), (0, 0, -1))
    assert found.d_mass["cup"] == pytest.approx(-G, rel=1e-5)
    worst = worst_case(scene, "cup", (0, 0, 1.05), (0, 0, -1), mass_range={"cup": (0.2, 0.4)}, exists=True)
    assert float(worst.lower[0]) == pytest.approx(5 - 0.4 * G, rel=1e-6)


def test_a_polygon_for_the_cone_errs_on_its_side() -> None:
    scene = stack([hf.Hold("block", hf.pose(0, 0, 0.1), forces=3.0, moments=INF)])
    loads = [hf.Load("slab", (0.4, 0, 0.025), (1, 0.3, 0))]
    inside, exact, outside = (
        float(hf.load_factor(scene, loads, engine=hf.Limit(cone, 16)))
        for cone in ("inscribed", "exact", "circumscribed")
    )
    assert inside < exact < outside
    assert outside < 1.05 * inside


@pytest.mark.parametrize(("share", "status"), [(0.999, "unstable"), (1.01, "stable"), (1.3, "stable"), (5.0, "stable")])
def test_a_hand_on_a_slope_that_is_too_steep(share: float, status: str) -> None:
    """F = m g sin(θ - φ) is needed along the edge of the friction cone; with more, the weight may grow as much."""
    ramp = hf.pose(0, 0, 0, pitch=40)
    needed = G * np.sin(np.radians(40) - np.arctan(0.5))
    hand = hf.Hold("block", ramp @ hf.pose(0, 0, 0.05), forces=share * needed, moments=INF)
    bodies = [
        hf.Body("ramp", hf.Box((2, 1, 0.1)), fixed=True, pose=ramp @ hf.pose(0, 0, -0.05)),
        hf.Body("block", hf.Box((0.1, 0.1, 0.1)), mass=1.0, pose=ramp @ hf.pose(0, 0, 0.05)),
    ]
    scene = hf.Scene(bodies, 0.5, holds=[hand])
    assert str(hf.stability(scene, engine=LIMIT).status) == status
    if status == "stable":
        assert pushed(scene, tuple((ramp @ [0, 0, 0.05, 1])[:3]), (0, 0, -1), "block") == pytest.approx(
            G * (share - 1), **CLOSE
        )


def test_a_faint_hand_does_not_vouch_for_forces_that_nothing_brings_about() -> None:
    """The wedged block rests on self-stress alone; a hand of 1 mN is no reason to say that it stands."""
    wedged = hf.assemble(hf.shipped_scene("wedged"))
    (name,) = (body.name for body in wedged.movable)
    faint = wedged.with_holds(hf.Hold(name, hf.pose(*wedged.com[0]), forces=1e-3, moments=1e-3))
    assert hf.stability(faint, engine=LIMIT).status is hf.Status.UNDECIDED


def test_the_margin_of_a_pinch_counts_the_friction_of_its_fingers() -> None:
    """2 μ F carries m g: friction may be lower by the share 1 - m g / (2 μ F)."""
    points = [(x, 0, z) for x in (0.05, -0.05) for z in (0.98, 1.02)]  # on two points it is only balanced
    grip = hf.Grip("cup", points, [(-np.sign(x), 0, 0) for x, _, _ in points], 0.5, 4.5)
    assert hf.stability(cup([grip]), engine=LIMIT).margin == pytest.approx(1 - 0.3 * G / 9.0, abs=1e-3)


@pytest.mark.parametrize(
    ("point", "normal", "said"),
    [
        ((0.05, 0, 1), (1, 0, 0), r"grip of 'cup': normal 1, \[1., 0., 0.\], does not press on the body"),
        ((0.05, 0, 1), (-0.6, 0, 0.8), "normal 1, .* does not press on the body"),
        ((0.05, 0, 1.05), (0, 0, 1), "normal 1, .* does not press on the body"),  # at the rim
        ((0.06, 0, 1), (-1, 0, 0), "grip of 'cup': point 1 at .* is 10 mm from the surface; needs points on the body"),
        ((0.03, 0, 1), (-1, 0, 0), "grip of 'cup': point 1 at .* is 20 mm from the surface"),
    ],
)
def test_fingers_that_are_not_on_the_body_or_do_not_press_on_it_are_refused(
    point: tuple[float, float, float], normal: tuple[float, float, float], said: str
) -> None:
    scene = cup([hf.Grip("cup", [(-0.05, 0, 1), point], [(1, 0, 0), normal], 0.5, 9.0)])
    with pytest.raises(SceneError, match=said):
        hf.stability(scene, engine=LIMIT)


@pytest.mark.parametrize("shape", [hf.Sphere(0.05), hf.Capsule(0.03, 0.1), hf.Cylinder(0.04, 0.1), hf.Box((0.1,) * 3)])
def test_fingers_press_against_faces_edges_and_corners(shape: hf.Sphere) -> None:
    """Along the normals of faces in their middle, and between those of all faces at a vertex."""
    rng = np.random.default_rng(1)
    body = hf.Body("it", shape, mass=1, pose=hf.pose(0.2, -0.1, 0, roll=31, pitch=12))
    surface = body.surface_world
    corners, faces = surface.vertices[surface.faces], rng.integers(0, len(surface.faces), 8)
    at, into = corners[faces].mean(1), -surface.normals[faces]
    ends = rng.integers(0, len(surface.vertices), 8)
    inwards = [-surface.normals[(surface.faces == end).any(1)].sum(0) for end in ends]
    scene = hf.Scene([hf.Body("floor", hf.HalfSpace(), fixed=True, position=(0, 0, -1)), body], 0.5)
    grip = hf.Grip("it", np.concatenate([at, surface.vertices[ends]]), np.concatenate([into, inwards]), 0.9)
    assert hf.stability(hf.Scene(scene.bodies, 0.5, holds=[grip]), engine=LIMIT).stable
