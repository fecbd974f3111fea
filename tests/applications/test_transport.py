"""Transport limits: closed forms for tilted, turning and accelerating carriers, and Fig. 15."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import holdfast as hf
from holdfast.scene.shipped import shipped_scene
from holdfast.scene.shipped.blocks import at, box, floor

G, MU = 9.81, 0.6
X, Y, Z = np.eye(3)
ENGINES = ("graph", "limit", "compliant")
LEVER = (np.sqrt(2) + np.log(1 + np.sqrt(2))) / 6  # mean distance from the centre of a square, over its side


def carried(
    height: float = 0.1, mu: float = MU, place: tuple[float, float] = (0.0, 0.0), **body: Any
) -> hf.answers.Assembly:
    """A box of 0.1 x 0.1 m on a tray."""
    cargo = hf.Body("box", hf.Box((0.1, 0.1, height)), mass=2.5, pose=at(*place, height / 2), **body)
    return hf.assemble(hf.Scene([floor(2, 2), cargo], mu))


def shipped(name: str) -> hf.answers.Assembly:
    return hf.assemble(shipped_scene(name))


def turned(
    assembly: hf.answers.Assembly, directions: Any, motion: dict[str, Any], **options: Any
) -> hf.answers.TransportLimits:
    """The limits on a carrier that also moves as ``inertial_loads`` is told."""
    return hf.transport_limits(assembly, directions, standing=hf.sets.inertial_loads(assembly, **motion), **options)


def limits(assembly: hf.answers.Assembly, *directions: np.ndarray, **options: Any) -> np.ndarray:
    names = ("angular_velocity", "angular_acceleration", "pivot")
    motion = {name: options.pop(name) for name in names if name in options}
    if not motion:
        return hf.transport_limits(assembly, np.array(directions), **options).acceleration
    return turned(assembly, np.array(directions), motion, **options).acceleration


# ---- linear acceleration


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("height", [0.05, 0.3])
def test_a_box_slips_or_topples(height: float, engine: str) -> None:
    t = hf.transport_limits(carried(height), 7 * np.array([X, -X, Y, -Y]), engine=engine)
    slips = 0.1 / height > MU
    assert t.acceleration == pytest.approx(G * min(MU, 0.1 / height), rel=1e-4)
    assert set(t.mode) == {"slip" if slips else "topple"}
    assert set(t.moving) == {("box",)}
    if not slips:  # accelerating along +x it turns backwards, about -y
        assert t.mechanism[0].twists[0, 4] < -1
    assert t.mechanism[0].twists[0, 0] < 0
    assert t.verdict.status is hf.Status.STABLE


@pytest.mark.parametrize("engine", ENGINES)
def test_dropping_frees_and_lifting_presses(engine: str) -> None:
    t = hf.transport_limits(carried(), [-Z, Z], engine=engine)
    assert t.acceleration == pytest.approx([G, np.inf], rel=1e-4)
    assert [str(s) for s in t.status] == ["finite", "infinite"]


@pytest.mark.parametrize("engine", ENGINES)
def test_fig_15(engine: str) -> None:
    one = limits(shipped("slope"), Y, -Y, X, -X, engine=engine)
    two = limits(shipped("slope_two"), -Y, X, -X, engine=engine)
    assert one == pytest.approx([3.27, 1.2 * G, 5.78, 5.78], rel=1e-3)
    assert two == pytest.approx([1.2 * G, 5.084, 5.084], rel=1e-3)
    if engine == "limit":  # the second cube holds the first
        assert limits(shipped("slope_two"), Y, engine=engine) == pytest.approx(4.292, rel=1e-3)


def test_the_default_directions_are_the_circle_of_fig_15() -> None:
    t = hf.transport_limits(shipped("slope"), engine="graph")
    assert t.directions.shape == (100, 3)
    assert t.directions[[0, 25, 50, 75]] == pytest.approx(np.array([X, Y, -X, -Y]), abs=1e-12)
    assert t.acceleration[[25, 75]] == pytest.approx([3.27, 11.772], rel=1e-3)
    assert np.argmin(t.acceleration) == 25


# ---- tilt


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("height", [0.1, 0.3])
def test_a_tilted_tray_holds_less_uphill_and_more_downhill(height: float, engine: str) -> None:
    """A turn about +x raises the tray's +y side; what slips or topples there is pulled towards -y."""
    angle, share = 0.2, min(MU, 0.1 / height)
    up, down = limits(carried(height), Y, -Y, tilt_degrees=(np.degrees(angle), 0, 0), engine=engine)
    assert up == pytest.approx(G * (share * np.cos(angle) - np.sin(angle)), rel=1e-4)
    assert down == pytest.approx(G * (share * np.cos(angle) + np.sin(angle)), rel=1e-4)


def test_a_tilt_is_a_rotation_vector_in_degrees() -> None:
    turn = Rotation.from_rotvec(np.radians((10, -5, 20))).as_matrix()
    np.testing.assert_array_equal(carried().tilted((10, -5, 20)).scene.gravity, turn.T @ carried().scene.gravity)


def test_the_default_directions_of_a_tilted_tray_are_level() -> None:
    tilt = np.array((12, -6, 24))
    turn = Rotation.from_rotvec(np.radians(tilt)).as_matrix()
    ways = hf.transport_limits(carried(), tilt_degrees=tilt, engine="graph").directions
    assert (ways @ turn.T)[:, 2] == pytest.approx(0, abs=1e-12)


# ---- rotation


@pytest.mark.parametrize("engine", ENGINES)
def test_a_turntable_uses_up_friction_outwards(engine: str) -> None:
    radius, rate = 0.4, 3.0
    out, slip = rate**2 * radius, MU * G
    found = limits(carried(place=(radius, 0)), X, -X, Y, -Y, angular_velocity=(0, 0, rate), engine=engine)
    across = np.sqrt(slip**2 - out**2)
    assert found[:2] == pytest.approx([slip + out, slip - out], rel=1e-3)
    if engine == "graph":  # cautious: its contact forces use friction unevenly, and it counts what each node has left
        assert (0.85 * across < found[2:]).all()
        assert (found[2:] < across).all()
    else:
        assert found[2:] == pytest.approx(across, rel=1e-3)


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("sense", [1, -1])
def test_starting_to_turn_drags_along_the_circle(sense: int, engine: str) -> None:
    """A point mass in all but name: no inertia of its own, so that nothing twists."""
    radius, rate = 0.5, 4.0
    assembly = carried(place=(radius, 0), inertia=1e-9 * np.eye(3))
    found = limits(assembly, Y, -Y, angular_acceleration=(0, 0, sense * rate), engine=engine)
    assert found == pytest.approx([MU * G - sense * rate * radius, MU * G + sense * rate * radius], rel=1e-3)


@pytest.mark.parametrize("sense", [1, -1])
def test_a_cube_on_the_pivot_twists_off(sense: int) -> None:
    """Its own inertia against the torsion of a square under even pressure; a quarter-turned inertia would not do."""
    critical = MU * G * LEVER * 0.1 / (0.1**2 / 6)
    for share, status in ((0.97, hf.Status.STABLE), (1.03, hf.Status.UNSTABLE)):
        turning = {"angular_acceleration": (0, 0, sense * share * critical), "pivot": (0.2, 0.1, 0)}
        assert turned(carried(place=(0.2, 0.1)), X, turning).verdict.status is status


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("sense", [1, -1])
def test_rocking_the_tray_tips_a_tall_box(sense: int, engine: str) -> None:
    """About an axis through its base along x: force m α h/2 and torque I α turn the same way."""
    height, mu = 0.3, 2.0
    inertia, mass = (0.1**2 + height**2) / 12, 1.0
    critical = mass * G * 0.05 / (mass * height**2 / 4 + mass * inertia)
    for share, status in ((0.99, hf.Status.STABLE), (1.01, hf.Status.UNSTABLE)):
        motion = {"angular_acceleration": (sense * share * critical, 0, 0)}
        t = turned(carried(height, mu), [Y, -Y], motion, engine=engine)
        assert t.verdict.status is status
        if status is hf.Status.STABLE:  # a turn about +x moves the top towards -y: inertia pulls it towards +y
            assert (t.acceleration[0] - t.acceleration[1]) * sense > 0.5 * G / 3


def test_inertial_loads_are_those_of_the_masses_a_body_is_made_of() -> None:
    """Every body as eight point masses at the Gauss points, which have its mass, centre and inertia."""
    rng = np.random.default_rng(5)
    turn = Rotation.random(random_state=7).as_matrix()
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = turn, (0.3, -0.2, 0.5)
    size = np.array([0.1, 0.2, 0.4])
    scene = hf.Scene([floor(), hf.Body("box", hf.Box(size), mass=2.5, pose=pose)], MU)
    a, alpha, omega, pivot = rng.normal(size=(4, 3))
    (load,) = hf.sets.inertial_loads(
        hf.assemble(scene), acceleration=a, angular_acceleration=alpha, angular_velocity=omega, pivot=pivot
    )
    corners = np.array(np.meshgrid(*[[-1, 1]] * 3)).reshape(3, -1).T
    points = corners * size / (2 * np.sqrt(3)) @ turn.T + pose[:3, 3]
    arms = points - pivot
    forces = -(2.5 / 8) * (a + np.cross(alpha, arms) + np.cross(omega, np.cross(omega, arms)))
    assert load.point == pytest.approx(pose[:3, 3])
    assert load.force == pytest.approx(forces.sum(0), rel=1e-9)
    assert load.moment == pytest.approx(np.cross(points - pose[:3, 3], forces).sum(0), rel=1e-9, abs=1e-12)


# ---- frames, sets, verdicts


@pytest.mark.parametrize("engine", ENGINES)
def test_the_frame_does_not_matter(engine: str) -> None:
    turn = Rotation.from_rotvec((0.3, -0.8, 0.5)).as_matrix()
    frame = np.eye(4)
    frame[:3, :3], frame[:3, 3] = turn, (1.0, -2.0, 0.5)
    plain = shipped_scene("slope")
    moved = [hf.Body(b.name, b.shape, b.mass, pose=frame @ b.pose, fixed=b.fixed) for b in plain.bodies]
    there = hf.assemble(hf.Scene(moved, plain.friction, turn @ plain.gravity))
    ways, motion = np.array([X, Y, X - 2 * Y]), {"angular_acceleration": (1.0, 0.5, 2.0), "angular_velocity": (0, 1, 1)}
    here = limits(hf.assemble(plain), *ways, pivot=(0.1, 0, 0), engine=engine, **motion)
    other = {name: turn @ value for name, value in motion.items()}
    pivot = turn @ (0.1, 0, 0) + frame[:3, 3]
    assert limits(there, *(ways @ turn.T), pivot=pivot, engine=engine, **other) == pytest.approx(here, rel=2e-3)


def test_the_set_and_the_limits_agree_on_a_tilted_turning_tray() -> None:
    assembly, turning = shipped("table"), {"angular_acceleration": (0.5, 0, 1), "angular_velocity": (0, 0, 0.8)}
    tilt = (3, -6, 0)
    found = hf.sets.sustainable_accelerations(
        assembly.tilted(tilt), exists=True, standing=hf.sets.inertial_loads(assembly, **turning)
    )
    t = turned(assembly, None, turning, tilt_degrees=tilt, engine="limit")
    reach = 1 / found.usage(t.directions)
    assert (reach <= t.acceleration * (1 + 1e-6)).all()
    assert (reach >= t.acceleration * (1 - found.accuracy) - 1e-6).all()


@pytest.mark.parametrize("engine", ENGINES)
def test_standing_loads_act_all_the_while(engine: str) -> None:
    down = hf.Load("box", (0, 0, 0.1), -10 * Z)
    assert limits(carried(), X, standing=[down], engine=engine) == pytest.approx(MU * (2.5 * G + 10) / 2.5, rel=1e-4)


def test_what_is_not_known_stays_so() -> None:
    turned = np.array([np.cos(np.pi / 8), 0, np.sin(np.pi / 8), 0])
    below = hf.Body("below", hf.Box((0.1, 0.1, 0.1)), pose=at(0, 0, 0.05 * np.sqrt(2), turned), fixed=True)
    above = hf.Body("above", hf.Box((0.1, 0.1, 0.1)), mass=1, pose=at(0, 0, 0.15 * np.sqrt(2), turned))
    for engine in ENGINES:
        t = hf.transport_limits(hf.assemble(hf.Scene([below, above], 0.5)), [X, Y], engine=engine)
        assert t.verdict.status is hf.Status.UNDECIDED
        assert set(t.status) == {hf.Status.UNDECIDED}
        assert t.acceleration == pytest.approx(0)
        assert (t.upper == np.inf).all()


def test_what_falls_is_carried_nowhere() -> None:
    tower = [floor(), box("a", (0.1, 0.1, 0.1), 1, (0, 0, 0.05)), box("b", (0.1, 0.1, 0.1), 1, (0.06, 0, 0.15))]
    for engine in ENGINES:
        t = hf.transport_limits(hf.assemble(hf.Scene(tower, 0.5)), engine=engine)
        assert t.verdict.status is hf.Status.UNSTABLE
        assert set(t.status) == {hf.Status.UNSTABLE}
        assert not t.acceleration.any()
        assert not t.upper.any()
        assert "b" in t.moving[0]


@pytest.mark.parametrize(
    ("options", "match"),
    [
        ({"directions": np.zeros((0, 3))}, "is empty; needs"),
        ({"engine": "graph", "bounds": True}, "not ordered against limit"),
    ],
)
def test_questions_that_make_no_sense(options: dict[str, Any], match: str) -> None:
    with pytest.raises(hf.HoldfastError, match=match):
        hf.transport_limits(carried(), **options)


# ---- time scaling


def test_a_path_is_slowed_down_to_what_the_box_bears() -> None:
    """Accelerations grow with the square of the speed; a box that slips bears mu g in every level direction."""
    angle = np.linspace(0, 6, 40)
    path = 9.0 * np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    found = hf.sets.sustainable_accelerations(carried(), accuracy=0.01)
    s = hf.sets.safe_time_scale(path, found)
    assert np.sqrt(MU * G / 9 * 0.9) <= s <= np.sqrt(MU * G / 9)
    assert set(found.contains(s**2 * path)) == {True}
    assert not all(found.contains((1.001 * s) ** 2 * path))
    assert hf.sets.safe_time_scale(path, found, margin=0.19) == pytest.approx(0.9 * s)
    assert hf.sets.safe_time_scale(path / 4, found) == pytest.approx(2 * s)
    assert hf.sets.safe_time_scale(0 * path, found) == np.inf


def test_limits_along_the_path_itself_will_do() -> None:
    path = np.array([[2.0, 0, 0], [0, 0, 0], [0, -9.0, 0], [0, 0, 3.0]])
    moving = path[[0, 2, 3]]
    t = hf.transport_limits(carried(), moving)
    assert hf.sets.safe_time_scale(path, t) == pytest.approx(np.sqrt(t.lower[1] / 9))
    assert np.sqrt(MU * G / 9) * 0.995 < hf.sets.safe_time_scale(path, t) < np.sqrt(MU * G / 9)
    fallen = hf.transport_limits(carried(), moving, tilt_degrees=(60, 0, 0))
    assert hf.sets.safe_time_scale(path, fallen) == 0
    with pytest.raises(hf.HoldfastError, match="along other directions"):
        hf.sets.safe_time_scale(-path, t)
    with pytest.raises(hf.HoldfastError, match="along other directions"):
        hf.sets.safe_time_scale(path[:3], t)
    for engine in ("graph", "limit"):
        with pytest.raises(hf.HoldfastError, match="does not say what holds"):
            hf.sets.safe_time_scale(path, hf.transport_limits(carried(), moving, engine=engine))
    with pytest.raises(hf.HoldfastError, match="does not say what holds"):
        hf.sets.safe_time_scale(path, hf.sets.sustainable_accelerations(carried(), exists=True, accuracy=0.3))
    with pytest.raises(hf.HoldfastError, match="limits: is a float"):
        hf.sets.safe_time_scale(path, 3.0)  # type: ignore[arg-type]
    with pytest.raises(hf.HoldfastError, match="margin"):
        hf.sets.safe_time_scale(path, t, margin=1.0)


# ---- of some bodies alone


def _with_an_orange() -> hf.Scene:
    tray, low = floor(2, 2), box("low", (0.1, 0.1, 0.05), 1, (0, 0, 0.025))
    top = box("top", (0.04, 0.04, 0.08), 0.2, (0, 0, 0.09))
    orange = hf.Body("orange", hf.Sphere(0.04), mass=0.2, pose=at(0.3, 0, 0.04))
    return hf.Scene([tray, low, top, orange], MU)


def test_an_orange_does_not_hide_what_the_boxes_beside_it_withstand() -> None:
    scene = _with_an_orange()
    ways = np.array([X, Y, -X - Y])
    whole = hf.transport_limits(scene, ways)
    some = hf.transport_limits(scene, ways, bodies=["low"])
    without = hf.transport_limits(hf.assemble(scene).without(["orange"]), ways)
    assert whole.acceleration == pytest.approx(0, abs=1e-6)
    assert some.acceleration == pytest.approx(without.acceleration, rel=1e-9)
    assert some.acceleration[0] == pytest.approx(
        G * 0.02 / 0.04, rel=0.03
    )  # the top box tips: half its width over half its height
    assert some.acceleration[0] <= G * 0.02 / 0.04 * (1 + 1e-6)
    assert some.notes[-1].endswith("orange")


@pytest.mark.parametrize(
    ("bodies", "match"), [([], "is empty"), (["floor"], "is fixed"), ("low", "is the text"), (["lo"], "no body")]
)
def test_bodies_that_cannot_be_asked_about(bodies: Any, match: str) -> None:
    with pytest.raises(hf.errors.SceneError, match=match):
        hf.transport_limits(_with_an_orange(), X, bodies=bodies)
