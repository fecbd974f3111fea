"""A monitor's margins: closed forms, those of ``transport_limits``, late answers, and bodies that move."""

from __future__ import annotations

import copy
import pickle
import time

import numpy as np
import pytest

import holdfast as hf
from bench.scenes.fitted import rails, row, tabletop, tote
from holdfast.applications.transport import motion_columns, motion_coordinates
from holdfast.base.arrays import Float
from holdfast.engines.groups import prepared

G = 9.81
X, Y = np.eye(3)[:2]
LONG = 100.0  # s: nothing is late, however busy the machine is


def on_a_base(mu: float, *, x: float = 0.0) -> hf.Scene:
    base = hf.Body("base", hf.Box((4, 4, 0.1)), position=(0, 0, -0.05), fixed=True)
    return hf.Scene([base, hf.Body("cube", hf.Box((0.1, 0.1, 0.1)), mass=2.0, position=(x, 0, 0.05))], mu)


def usage(found: hf.answers.Monitored) -> float:
    return 1 - found.margin


@pytest.mark.parametrize("way", [(1, 0, 0), (0, -1, 0), (0.6, 0.8, 0)])
def test_a_cube_slides_at_mu_g(way: tuple[float, float, float]) -> None:
    monitor = hf.Monitor(on_a_base(0.4), seconds=LONG, solves=30)
    for share in (0.2, 0.7, 0.999, 1 - 1e-7):
        found = monitor.update(share * 0.4 * G * np.array(way))
        assert share <= usage(found) <= 1.005 * share
        assert found.holds == (share <= 0.999)
        assert found.status is (hf.Status.STABLE if share <= 0.999 else hf.Status.UNDECIDED)
        assert not found.late
    beyond = monitor.update(1.01 * 0.4 * G * np.array(way))
    assert (beyond.margin, beyond.upper, beyond.status) == (0, 0, hf.Status.UNSTABLE)
    assert beyond.moving == ("cube",)


def test_up_and_down_the_same_weight_holds_less_or_more() -> None:
    """Where the base falls with a, friction is μ (g - a): the share s of the motion is s a_x = μ (g - s a)."""
    monitor = hf.Monitor(on_a_base(0.4), seconds=LONG, solves=30)
    for a in (3.0, -3.0):
        found = monitor.update((1.0, 0, -a))
        assert usage(found) == pytest.approx((1.0 + 0.4 * a) / (0.4 * G) if a > -2.5 else 0.0, abs=6e-3)


def test_a_turning_base_throws_out_what_stands_off_its_middle() -> None:
    """ω² r against μ g, and α r with it at a right angle."""
    monitor = hf.Monitor(on_a_base(0.4, x=0.5), seconds=LONG, solves=30)
    omega, alpha = 1.5, 2.0
    turning = monitor.update(angular_velocity=(0, 0, omega))
    assert usage(turning) == pytest.approx(omega**2 * 0.5 / (0.4 * G), rel=6e-3)
    both = monitor.update(angular_velocity=(0, 0, omega), angular_acceleration=(0, 0, alpha))
    least = np.hypot(omega**2, alpha) * 0.5 / (0.4 * G)  # the torque that turns it is friction, too
    assert least * (1 - 1e-9) <= usage(both) <= 1.05 * least
    about_itself = hf.Monitor(on_a_base(0.4, x=0.5), pivot=(0.5, 0, 0), seconds=LONG, solves=30)
    assert usage(about_itself.update(angular_velocity=(0, 0, omega))) == pytest.approx(0, abs=1e-6)


@pytest.mark.parametrize("degrees", [5.0, 20.0, 21.7, 22.0, 40.0])
def test_a_slope_by_the_vector_of_gravity(degrees: float) -> None:
    """At the share s of what differs from level rest: s sin θ = μ (1 - s (1 - cos θ))."""
    angle = np.radians(degrees)
    found = hf.Monitor(on_a_base(0.4), seconds=LONG, solves=30).update(
        gravity=(G * np.sin(angle), 0, -G * np.cos(angle))
    )
    share = (np.sin(angle) + 0.4 * (1 - np.cos(angle))) / 0.4
    assert usage(found) == pytest.approx(min(share, 1.0), rel=6e-3)
    assert found.holds == (degrees < 21.75)  # tan 21.8 degrees is 0.4
    # the same as that acceleration of a level base
    felt = hf.Monitor(on_a_base(0.4), seconds=LONG, solves=30).update((-G * np.sin(angle), 0, G * np.cos(angle) - G))
    assert usage(felt) == pytest.approx(usage(found), rel=1e-9)


def motions(count: int, seed: int) -> tuple[Float, Float, Float, Float]:
    """Accelerations, angular velocities and accelerations, and changes of gravity, (n, 3) each."""
    rng = np.random.default_rng(seed)
    a, omega, alpha = 2 * rng.normal(size=(count, 3)), 0.7 * rng.normal(size=(count, 3)), rng.normal(size=(count, 3))
    return a, omega, alpha, rng.normal(size=(count, 3)) * (0.5, 0.5, 0.2)


def capacities(assembly: hf.answers.Assembly, moved: tuple[Float, Float, Float, Float]) -> tuple[Float, Float]:
    """The share (n,) that each motion uses of what holds, and that it certainly uses, asked as loads all at once."""
    a, omega, alpha, change = moved
    x = motion_coordinates(a - change, alpha, omega)
    size = np.linalg.norm(x, axis=1)
    loads = motion_columns(assembly, np.zeros(3)) @ (x / size[:, None]).T
    with np.errstate(divide="ignore"):
        used = size / prepared(hf.Compliant(), assembly).load_factor(loads).lower
        return used, size / prepared(hf.Limit(), assembly).load_factor(loads).upper


@pytest.mark.parametrize("name", ["stack", "table", "slope_two", "cantilever", "arch", "tabletop"])
def test_a_margin_is_that_of_lower_and_what_moves_is_proved(name: str) -> None:
    assembly = hf.assemble(hf.shipped_scene(name))
    monitor, moved, gravity = hf.Monitor(assembly, seconds=LONG, solves=1), motions(40, 3), assembly.scene.gravity
    used, proved = capacities(assembly, moved)
    found = [
        monitor.update(a, omega, gravity + change, angular_acceleration=alpha)
        for a, omega, alpha, change in zip(*moved, strict=True)
    ]
    np.testing.assert_allclose([usage(one) for one in found], np.minimum(used, 1), rtol=1e-6, atol=1e-9)
    assert [one.holds for one in found] == (used < 1).tolist()
    assert [one.status is hf.Status.UNSTABLE for one in found] == (proved > 1).tolist()
    assert all(1 - one.upper <= most * (1 + 1e-6) for one, most in zip(found, proved, strict=True))


@pytest.mark.parametrize("air", [0.0, 1e-6, 1e-5, 1e-4, 1e-3])
def test_rails_that_nothing_presses_lend_nothing(air: float) -> None:
    """Along rails the friction is that of the tray, μ g, however much an equilibrium could squeeze."""
    right = 0.4 * G
    for scene, way in ((rails(air), X), (row(2, air), Y), (tote(air, along=1), X)):
        monitor = hf.Monitor(scene, seconds=LONG, solves=0)
        assert monitor.update(0.9 * right * way).holds
        for beyond in (1.001, 9.0 / right, 1000 / right):
            found = monitor.update(beyond * right * way)
            assert (found.holds, found.margin) == (False, 0.0)


@pytest.mark.parametrize("scene", [rails(5e-5), tote(2e-5, along=1), row(2), tabletop(1)])
def test_it_agrees_with_transport_limits(scene: hf.Scene) -> None:
    limits = hf.transport_limits(scene, np.random.default_rng(6).normal(size=(8, 3)) * (1, 1, 0.3))
    monitor = hf.Monitor(scene, seconds=LONG, solves=0)
    for way, lower in zip(limits.directions, limits.lower, strict=True):
        if 0 < lower < np.inf:
            assert not monitor.update(1.0001 * lower * way).holds
            assert monitor.update(0.98 * lower * way).holds
            assert usage(monitor.update(0.5 * lower * way)) == pytest.approx(0.5, rel=1e-6)


def test_the_same_direction_is_asked_once_and_any_other_anew() -> None:
    monitor = hf.Monitor(hf.shipped_scene("table"), seconds=LONG, solves=2)
    (watched,) = monitor._watched.values()
    asked = len(watched.holds.known)
    for size in (0.3, 1.0, 2.0):
        monitor.update((size, 0.2 * size, 0))
    assert len(watched.holds.known) == asked + 1
    monitor.update((1.0, 0.21, 0))
    assert len(watched.holds.known) == asked + 2


def test_a_group_that_takes_too_long_says_so_at_once() -> None:
    monitor = hf.Monitor(on_a_base(0.4), seconds=1e-6, solves=3)
    begun = time.perf_counter()
    found = monitor.update((0.7, -0.9, 0.2))
    assert time.perf_counter() - begun < 0.1
    assert (found.margin, found.status, found.late) == (0, hf.Status.UNDECIDED, True)
    assert "no time to ask about cube" in found.reason
    assert "late" in found.summary().headline


def test_a_group_that_was_slow_is_asked_again_a_second_later(monkeypatch: pytest.MonkeyPatch) -> None:
    """The machine was busy while it was prepared, and is not any more."""
    now = [0.0]
    monkeypatch.setattr(time, "perf_counter", lambda: now[0])
    monitor = hf.Monitor(on_a_base(0.4), seconds=0.02, solves=3)
    (watched,) = monitor._watched.values()
    watched.holds.times.extend([0.03] * 9)
    assert monitor.update((1.0, 0, 0)).late
    now[0] += 1.1
    found = monitor.update((1.0, 0.1, 0))
    assert (found.holds, found.late) == (True, False)


@pytest.mark.parametrize("scene", [on_a_base(0.4), on_a_base(0.4).moved({"cube": hf.pose(0, 0, 0.5)})])
def test_it_can_be_copied_and_pickled(scene: hf.Scene) -> None:
    press = hf.Load("cube", (0, 0, 0.1), force=(0, 0, -2.0 * G))
    monitor = hf.Monitor(scene, standing=[press], pivot=(0.1, 0, 0), seconds=LONG, solves=1)
    spin = {"angular_velocity": (0, 0, 1.0), "poses": {"cube": hf.pose(0.3, 0, 0.05)}}
    monitor.update(**spin)
    for other in (pickle.loads(pickle.dumps(monitor)), copy.deepcopy(monitor)):
        assert other.notes == monitor.notes
        assert other.update((1, 0, 0), **spin).margin == monitor.update((1, 0, 0), **spin).margin


def test_rest_uses_nothing() -> None:
    found = hf.Monitor(hf.shipped_scene("table")).update()
    assert (found.margin, found.upper, found.holds, found.moving) == (1, 1, True, ())


def test_what_does_not_stand_has_no_margin() -> None:
    monitor = hf.Monitor(on_a_base(0.4).moved({"cube": hf.pose(0, 0, 0.5)}))
    assert (monitor.update().status, monitor.update().moving) == (hf.Status.UNSTABLE, ("cube",))
    moving = monitor.update((1, 0, 0))
    assert (moving.margin, moving.status) == (0, hf.Status.UNDECIDED)
    assert "cube" in moving.reason


def test_only_the_groups_that_are_named_count() -> None:
    ball = hf.Body("ball", hf.Sphere(0.05), mass=0.1, position=(1, 1, 0.05))
    scene = on_a_base(0.4).with_body(ball)
    assert hf.Monitor(scene, seconds=LONG, solves=30).update((1, 0, 0)).margin == 0
    monitor = hf.Monitor(scene, bodies=["cube"], seconds=LONG, solves=30)
    assert usage(monitor.update((1, 0, 0))) == pytest.approx(1 / (0.4 * G), rel=6e-3)
    assert "ball" in monitor.notes[-1]
    with pytest.raises(hf.HoldfastError, match="fixed"):
        hf.Monitor(scene, bodies=["base"])


def test_standing_loads_act_throughout() -> None:
    """Pressed down with its own weight, a cube holds twice as much."""
    press = hf.Load("cube", (0, 0, 0.1), force=(0, 0, -2.0 * G))
    found = hf.Monitor(on_a_base(0.4), standing=[press], seconds=LONG, solves=30).update((1.0, 0, 0))
    assert usage(found) == pytest.approx(1 / (2 * 0.4 * G), rel=6e-3)


def test_poses_that_change_are_followed_and_only_their_groups_prepared_anew() -> None:
    still = hf.Body("still", hf.Box((0.1, 0.1, 0.1)), mass=1.0, position=(0, 1, 0.05))
    monitor = hf.Monitor(on_a_base(0.4).with_body(still), seconds=LONG, solves=30)
    spin = (0, 0, 1.2)
    before = dict(monitor._watched)
    out = hf.pose(1.5, 0, 0.05)
    found = monitor.update(angular_velocity=spin, poses={"cube": out})
    assert usage(found) == pytest.approx(1.2**2 * 1.5 / (0.4 * G), rel=6e-3)
    assert found.moving == ("cube",)
    assert len(monitor._watched.keys() & before.keys()) == 1
    assert monitor.update(angular_velocity=spin).margin == pytest.approx(found.margin, abs=1e-3), "poses stay"
    known = dict(monitor._watched)
    monitor.update(angular_velocity=spin, poses={"cube": hf.pose(1.5 + 1e-6, 0, 0.05)})
    assert monitor._watched == known, "a micrometre is no motion"
    monitor.update(angular_velocity=spin, poses={"cube": hf.pose(1.5 + 25e-6, 0, 0.05)})
    assert monitor._watched.keys() != known.keys(), "but more than a tenth of the gap of 0.173 mm is"
    lifted = monitor.update(poses={"cube": hf.pose(1.5, 0, 0.5)})
    assert (lifted.margin, lifted.status, lifted.moving) == (0, hf.Status.UNSTABLE, ("cube",))


def test_a_contact_that_may_not_exist_is_not_relied_on() -> None:
    """A cube between two posts, one of which may be out of reach by as much as the gap allows."""
    posts = [hf.Body(f"post {x}", hf.Box((0.1, 0.1, 0.1)), position=(x, 0, 0.05), fixed=True) for x in (-0.1045, 0.1)]
    scene = on_a_base(0.4)
    assembly = hf.assemble(hf.Scene([*scene.bodies, *posts], 0.4), gap=0.005)
    assert not all(interface.certain for interface in assembly.interfaces)
    found = hf.Monitor(assembly, seconds=LONG).update((2.0, 0, 0))  # pressed against the doubtful post
    bounds = hf.load_factor(assembly, hf.sets.inertial_loads(assembly, acceleration=(2.0, 0, 0)))
    assert found.margin == pytest.approx(max(1 - 1 / bounds.lower, 0), abs=2e-3)


def test_uncertain_poses_and_scenes_without_movable_bodies_are_refused() -> None:
    with pytest.raises(hf.HoldfastError, match="pose_sigma"):
        hf.Monitor(hf.assemble(on_a_base(0.4), pose_sigma=1e-4))
    for nothing in (lambda: hf.Monitor(on_a_base(0.4).without("cube")), lambda: hf.Monitor(on_a_base(0.4), bodies=[])):
        with pytest.raises(hf.HoldfastError, match=r"can move|is empty"):
            nothing()


def test_a_moment_is_no_truth_value() -> None:
    with pytest.raises(hf.HoldfastError, match="holds"):
        bool(hf.Monitor(on_a_base(0.4), solves=0).update())
