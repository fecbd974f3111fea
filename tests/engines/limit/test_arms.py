"""Bodies that hold each other: arms whose joints bear any force and moment but along the axis of a motor."""

from __future__ import annotations

import numpy as np
import pytest
from placed import FLOOR
from scipy.optimize import linprog

import holdfast as hf
from holdfast.base.arrays import Float
from holdfast.base.errors import SceneError
from holdfast.base.rigid import cross
from holdfast.scene.formats.joints import joint_hold

G, LIMIT, INF = 9.81, hf.Limit(), float("inf")
CLOSE = {"rel": 1e-6, "abs": 1e-8}
Y = np.array([0.0, 1.0, 0.0])


def arm(angles: list[float], torques: list[float], lengths: list[float], masses: list[float]) -> hf.Scene:
    """Straight links in a vertical plane from (0, 0, 1) on, with angles [deg] over the level, turning about y."""
    bodies, holds, at = [FLOOR], [], np.array([0.0, 0.0, 1.0])
    for k, (angle, length, mass) in enumerate(zip(angles, lengths, masses, strict=True)):
        along = np.array([np.cos(np.radians(angle)), 0, np.sin(np.radians(angle))])
        pose = hf.pose(*(at + length / 2 * along), pitch=-angle)
        bodies.append(hf.Body(f"link{k}", hf.Box((length, 0.05, 0.04)), mass=mass, pose=pose))
        own = (-torques[k], torques[k])
        holds.append(joint_hold(f"link{k}", f"link{k - 1}" if k else None, at, Y, own, slides=False))
        at = at + length * along
    return hf.Scene(bodies, 0.5, holds=holds)


def end(scene: hf.Scene, body: str) -> Float:
    """The middle of the face at the far end of a link."""
    link = scene.body(body)
    return np.asarray(link.pose[:3, :3] @ [link.shape.size[0] / 2, 0, 0] + link.pose[:3, 3])


def least(scene: hf.Scene, body: str, point: Float, way: Float | tuple[float, float, float]) -> float:
    found = hf.load_factor(scene, [hf.Load(body, point, way)], engine=LIMIT)
    assert found.lower <= float(found) * (1 + 1e-9) <= found.upper * (1 + 2e-9)
    return float(found)


@pytest.mark.parametrize(("way", "most"), [(-1, (10 - G * 0.3) / 0.6), (1, (10 + G * 0.3) / 0.6)])
def test_a_lever_bears_what_its_motor_gives_and_its_own_weight_takes(way: int, most: float) -> None:
    scene = arm([0], [10], [0.6], [1])
    assert least(scene, "link0", end(scene, "link0"), (0, 0, way)) == pytest.approx(most, **CLOSE)
    assert least(scene, "link0", end(scene, "link0"), (1, 0, 0)) == INF


@pytest.mark.parametrize(("torque", "status"), [(0.999, hf.Status.UNSTABLE), (1.001, hf.Status.STABLE)])
def test_an_arm_whose_motors_cannot_carry_it_is_proved_to_fall(torque: float, status: hf.Status) -> None:
    scene = arm([20, -40], [50, torque * G * 0.8 * 0.2 * np.cos(np.radians(40))], [0.5, 0.4], [2, 0.8])
    found = hf.stability(scene, engine=LIMIT)
    assert found.status is status
    if status is hf.Status.UNSTABLE:
        assert found.verdict.mechanism is not None
        assert found.verdict.mechanism.moving == ("link1",)


@pytest.mark.parametrize("angles", [[30.0, -20.0], [70.0, 110.0], [90.0, 0.0], [0.0, 0.0], [45.0, 45.0]])
@pytest.mark.parametrize("way", [(0, 0, -1), (0.6, 0, 0.8), (-1, 0, 0)])
def test_two_links_press_as_their_jacobian_says(angles: list[float], way: tuple[float, float, float]) -> None:
    """|J_i · w + g_i| <= τ_i, stretched or bent: the lever of the push about each joint, and the weights'."""
    scene = arm(angles, [40, 12], [0.5, 0.4], [2, 1])
    tip, second = end(scene, "link1"), end(scene, "link0")
    best = INF
    for joint, torque, links in ((np.array([0, 0, 1.0]), 40, ("link0", "link1")), (second, 12, ("link1",))):
        weights = sum(scene.body(name).mass * G * (scene.body(name).pose[:3, 3] - joint)[0] for name in links)
        lever = float(cross(tip - joint, np.array(way, dtype=np.float64)) @ Y)
        if abs(lever) > 1e-12:
            best = min(best, (torque - np.sign(lever) * weights) / abs(lever))
    assert least(scene, "link1", tip, way) == pytest.approx(best, **CLOSE)


def test_links_that_meet_at_a_joint_do_not_touch_there() -> None:
    """Their faces would carry the moment that the motor has to: with 0.5 N m at the elbow it stood and bore 16.7 N."""
    for torque, status in ((0.5, hf.Status.UNSTABLE), (1.48, hf.Status.STABLE)):
        whole = arm([0, 0], [20, torque], [0.4, 0.3], [1.5, 1.0])
        assert hf.stability(whole, engine=LIMIT).status is status
        later = hf.assemble(hf.Scene(whole.bodies, 0.5)).with_holds(*whole.holds)
        assert len(later.interfaces) == 0
        assert hf.stability(later, engine=LIMIT).status is status


def test_a_stretched_arm_bears_any_push_along_itself() -> None:
    scene = arm([90, 90], [5, 5], [0.5, 0.4], [2, 1])
    assert least(scene, "link1", end(scene, "link1"), (0, 0, -1)) == INF
    assert least(scene, "link1", end(scene, "link1"), (1, 0, 0)) == pytest.approx(5 / 0.9, **CLOSE)


def test_a_slide_bears_what_its_motor_pushes() -> None:
    cart = hf.Body("cart", hf.Box((0.1, 0.1, 0.1)), mass=2.0, position=(0, 0, 1))
    up = joint_hold("cart", None, np.array([0.0, 0, 1]), np.array([0.0, 0, 2]), (-5.0, 60.0), slides=True)
    scene = hf.Scene([FLOOR, cart], 0.5, holds=[up])
    assert least(scene, "cart", np.array([0.03, 0, 1.05]), (0, 0, -1)) == pytest.approx(60 - 2 * G, **CLOSE)
    assert least(scene, "cart", np.array([0, 0, 1.05]), (0, 0, 1)) == pytest.approx(5 + 2 * G, **CLOSE)
    assert least(scene, "cart", np.array([0, 0, 1.05]), (1, 0.2, 0)) == INF


def tray(torque: float) -> hf.Scene:
    scene = arm([0], [torque], [0.5], [1])
    return scene.with_body(hf.Body("cup", hf.Box((0.05, 0.05, 0.1)), mass=0.3, position=(0.4, 0, 1.07)))


def test_an_arm_that_carries_a_cup_on_its_tray() -> None:
    """A push down on the cup is the motor's, one across is friction's: μ m g; at half the width it would also tip."""
    needed = G * (0.25 + 0.3 * 0.4)
    assert hf.stability(tray(0.9999 * needed), engine=LIMIT).status is hf.Status.UNSTABLE
    scene = tray(needed + 2)
    assert hf.stability(scene, engine=LIMIT).stable
    assert least(scene, "cup", np.array([0.4, 0, 1.12]), (0, 0, -1)) == pytest.approx(2 / 0.4, **CLOSE)
    assert least(scene, "cup", np.array([0.425, 0, 1.04]), (-1, 0, 0)) == pytest.approx(0.5 * 0.3 * G, **CLOSE)


@pytest.mark.parametrize("way", [(0, 0, -1), (0, 1, 0), (0, 0.6, 0.8)])
def test_a_hand_at_the_end_of_an_arm(way: tuple[float, float, float]) -> None:
    """The hand is one ball of forces, |s d - m g z| = F, and the arm beyond it is a lever: the less of both."""
    held = tray(30)
    held = held.moved({"cup": hf.pose(0.4, 0, 1.5)})
    for force in (5.0, 400.0):
        hand = hf.Hold("cup", hf.pose(0.4, 0, 1.5, roll=30), forces=force, moments=INF, on="link0")
        scene = hf.Scene(held.bodies, 0.5, holds=[*held.holds, hand])
        w, d = 0.3 * G, way[2]
        hands = w * d + np.sqrt((w * d) ** 2 + force**2 - w * w)
        arms = (30 + np.sign(d) * G * (0.25 + 0.12)) / abs(0.4 * d) if d else INF
        assert least(scene, "cup", np.array([0.4, 0, 1.5]), way) == pytest.approx(min(hands, arms), **CLOSE)


def test_a_hand_on_another_body_takes_as_much_as_it_gives() -> None:
    """A box of forces between a block and the slab under it moves neither of them together."""
    bodies = [
        FLOOR,
        hf.Body("slab", hf.Box((0.8, 0.8, 0.05)), mass=2.0, position=(0, 0, 0.025)),
        hf.Body("block", hf.Box((0.1, 0.1, 0.1)), mass=1.0, position=(0.1, 0, 0.1)),
    ]
    for forces, most in (
        ((3, 3, 0), 0.5 * G + 3),
        ((0, 0, (-4, 1)), 0.5 * (G + 4)),
        (4.0, 0.5 * G + 4 * np.sqrt(1.25)),
    ):
        hand = hf.Hold("block", hf.pose(0.1, 0, 0.05), forces=forces, moments=INF, on="slab")
        scene = hf.Scene(bodies, 0.5, holds=[hand])
        assert least(scene, "block", np.array([0.1, 0, 0.05]), (1, 0, 0)) == pytest.approx(most, **CLOSE)
        assert least(scene, "slab", np.array([0.4, 0, 0.025]), (1, 0, 0)) == pytest.approx(0.5 * 3 * G, **CLOSE)


@pytest.mark.parametrize("joints", [3, 4, 5, 6, 7])
def test_random_arms_beside_an_independent_linear_program(joints: int) -> None:
    """Torques τ and the box h of a hand at the last link: Jᵀ (s w + h) + g + τ = 0, any axes, turning and sliding.

    Motors give twice as much one way as the other.
    """
    rng = np.random.default_rng(joints)
    for trial in range(4):
        points, axes = rng.normal(size=(2, joints, 3))
        axes /= np.linalg.norm(axes, axis=1)[:, None]
        if trial == 3:
            axes[1], points[1] = axes[0], points[0] + 0.3 * axes[0]  # singular: two joints about one line
        slides = rng.random(joints) < 0.2
        coms, masses = rng.normal(size=(joints, 3)), rng.uniform(0.2, 3, joints)
        bodies = [hf.Body(f"{k}", hf.Sphere(0.02), mass=masses[k], position=coms[k]) for k in range(joints)]
        apart = [(f"{j}", f"{k}") for k in range(joints) for j in range(k)]
        bodies.append(hf.Body("floor", hf.HalfSpace(), fixed=True, position=(0, 0, -9)))

        def column(k: int, link: int, point: Float, force: Float, moment: Float) -> float:
            if k > link:
                return 0.0
            turning = cross(point - points[k], force) + moment  # noqa: B023
            return float(axes[k] @ (force if slides[k] else turning))  # noqa: B023

        none, down = np.zeros(3), np.array([0, 0, -G])
        g = np.array([sum(column(k, j, coms[j], masses[j] * down, none) for j in range(joints)) for k in range(joints)])
        tau, box, at = 1.2 * np.abs(g) + rng.uniform(0.1, 5, joints), rng.uniform(0, 4, 3), rng.normal(size=3)
        holds = [
            joint_hold(
                f"{k}", f"{k - 1}" if k else None, points[k], axes[k], (-tau[k], 2 * tau[k]), slides=bool(slides[k])
            )
            for k in range(joints)
        ]
        holds.append(hf.Hold(f"{joints - 1}", hf.pose(*at), forces=tuple(box)))
        scene = hf.Scene(bodies, 0.5, excluded=apart, holds=holds)
        force, moment, where = rng.normal(size=(3, 3))
        hand = [[column(k, joints - 1, at, axis, none) for axis in np.eye(3)] for k in range(joints)]
        load = [column(k, joints - 1, where, force, moment) for k in range(joints)]
        A = np.column_stack([np.eye(joints), hand, load])
        sides = [*((-t, 2 * t) for t in tau), *((-h, h) for h in box), (0, None)]
        true = -linprog(-np.eye(joints + 4)[-1], A_eq=A, b_eq=-g, bounds=sides).fun
        found = hf.load_factor(scene, [hf.Load(f"{joints - 1}", where, force, moment)], engine=LIMIT)
        assert float(found) == pytest.approx(true, **CLOSE)
        assert found.lower <= true * (1 + 1e-9)
        assert found.upper >= true * (1 - 1e-9)


def test_an_arm_beside_an_unrelated_stack_is_a_group_of_its_own() -> None:
    alone = tray(30)
    scene = alone.with_body(hf.Body("crate", hf.Box((0.2, 0.2, 0.2)), mass=4, position=(0, 2, 0.1)))
    assert hf.assemble(scene).groups == (("link0", "cup"), ("crate",))
    there = (np.array([0.4, 0, 1.12]), (0.2, 0, -1))
    assert least(scene, "cup", *there) == least(alone, "cup", *there)


def test_what_holds_each_other_in_the_air_falls() -> None:
    a, b = (hf.Body(name, hf.Sphere(0.1), mass=1, position=(x, 0, 1)) for name, x in (("a", 0), ("b", 1)))
    scene = hf.Scene([FLOOR, a, b], 0.5, holds=[hf.Hold("b", hf.pose(1, 0, 1), forces=INF, moments=INF, on="a")])
    assert hf.stability(scene, engine=LIMIT).status is hf.Status.UNSTABLE
    assert scene.without("a").holds == ()


def test_taking_apart_what_holds_each_other_is_refused() -> None:
    scene = hf.Scene(tray(30).bodies, 0.5, holds=[hf.Hold("cup", hf.pose(0.4, 0, 1), forces=1.0, on="link0")])
    with pytest.raises(SceneError, match="leave out holds with on="):
        hf.can_remove(scene, "cup", engine=LIMIT)
