"""Carrying over time: closed forms for ramps, jolts, turns and tilts; scaling; three answers."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import holdfast as hf
from holdfast.applications.carrying import carry as asking
from holdfast.scene.shipped.blocks import at, box, floor

G, MU = 9.81, 0.6
ENGINES = ("graph", "limit", "compliant")


def carried(height: float = 0.1, place: tuple[float, float] = (0.0, 0.0), mu: float = MU) -> hf.answers.Assembly:
    cargo = hf.Body("box", hf.Box((0.1, 0.1, height)), mass=2.5, pose=at(*place, height / 2))
    return hf.assemble(hf.Scene([floor(2, 2), cargo], mu))


def ramp(most: float, axis: int = 0) -> np.ndarray:
    """From rest to ``most`` [m/s²] within a second, and back."""
    table = np.zeros((3, 4))
    table[:, 0], table[1, 1 + axis] = (0.0, 1.0, 2.0), most
    return table


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("height", [0.05, 0.3])
def test_a_box_gives_way_when_the_floor_is_as_fast_as_friction_or_its_base_allow(height: float, engine: str) -> None:
    c = hf.carry(carried(height), ramp(10.0), engine=engine)
    limit = G * min(MU, 0.1 / height)
    assert c.outcome is hf.Status.UNSTABLE
    assert c.factor[1] == pytest.approx(limit / 10, rel=1e-4)
    assert np.isinf(c.factor[[0, 2]]).all()
    assert limit / 10 <= c.time * (1 + 1e-4) <= limit / 10 + 2e-3
    assert c.first == ("box",)
    assert c.mode[1] == ("slip" if 0.1 / height > MU else "topple")
    assert c.mechanism[1].twists[0, 0] < 0  # thrown backwards


@pytest.mark.parametrize("engine", ENGINES)
def test_below_that_it_holds_and_tells_how_much_is_left(engine: str) -> None:
    c = hf.carry(carried(), ramp(3.0), engine=engine)
    assert c.outcome is (hf.Status.UNDECIDED if engine == "limit" else hf.Status.STABLE)
    assert (c.time, c.first) == (np.inf, ())
    assert c.used == pytest.approx([0, 3 / (MU * G), 0], rel=0.01)
    assert c.holds == c.held.all() == (engine != "limit")  # an equilibrium that exists need not hold
    assert not c.moves.any()


@pytest.mark.parametrize("engine", ["limit", "compliant"])
@pytest.mark.parametrize("size", [2.0, 12.0])
def test_played_at_the_safe_speed_it_just_holds(size: float, engine: str) -> None:
    assembly, motion = carried(), hf.Profile.from_table(ramp(size))
    scale = hf.carry(assembly, motion, engine=engine).time_scale()
    assert scale == pytest.approx(np.sqrt(MU * G / size), rel=0.01)
    at_most = hf.carry(assembly, motion.at_speed(0.999 * scale), engine=engine)
    assert (at_most.lower >= 1).all()
    assert at_most.outcome is (hf.Status.UNDECIDED if engine == "limit" else hf.Status.STABLE)
    assert hf.carry(assembly, motion.at_speed(1.02 * scale), engine=engine).outcome is hf.Status.UNSTABLE
    half = hf.carry(assembly, motion, engine=engine).time_scale(margin=0.5)
    assert half == pytest.approx(scale * np.sqrt(0.5))


def test_a_safe_speed_needs_a_promise() -> None:
    with pytest.raises(hf.HoldfastError, match="promises no lower bound"):
        hf.carry(carried(), ramp(3.0), engine="graph").time_scale()
    with pytest.raises(hf.HoldfastError, match="margin"):
        hf.carry(carried(), ramp(3.0), engine="limit").time_scale(margin=1.0)


@pytest.mark.parametrize("engine", ["limit", "compliant"])
def test_on_a_turntable_friction_bears_the_way_out(engine: str) -> None:
    """mu g = omega² r; twice as fast, four times the load; and the box leaves outwards."""
    radius, speed = 0.4, 3.0
    c = hf.carry(
        carried(0.02, (radius, 0.0)),
        hf.Profile([0, 1, 2], np.zeros((3, 3)), angular_velocity=[(0, 0, speed), (0, 0, 2 * speed), (0, 0, 0)]),
        engine=engine,
    )
    assert c.factor[:2] == pytest.approx(MU * G / (np.array([1, 4]) * speed**2 * radius), rel=1e-3)
    assert c.time == pytest.approx(np.sqrt(MU * G / radius) / speed - 1, abs=2e-3)
    assert c.mechanism[1].twists[0, 0] > 0


def test_what_turns_about_a_level_axis_tilts() -> None:
    """By the time it has turned by arctan(mu), it slides however slowly it is carried."""
    rate = 0.1
    time = np.linspace(0, 8, 9)
    motion = hf.Profile(time, np.zeros((9, 3)), angular_velocity=np.tile((0, rate, 0), (9, 1)), pivot=(0, 0, 0.025))
    c = hf.carry(carried(0.05), motion, engine="limit")
    assert c.time == pytest.approx(np.arctan(MU) / rate, rel=0.01)  # the centrifugal force is 1e-5 of the weight
    assert c.status[-1] is hf.Status.UNSTABLE
    assert c.verdict.status is hf.Status.STABLE
    assert c.time_scale() == 0
    assert c.mechanism[-1].twists[0, 0] > 0  # a turn about +y lowers the side of +x


def test_gravity_turns_against_the_carrier() -> None:
    motion = hf.Profile([0, 1, 2], np.zeros((3, 3)), angular_velocity=np.tile((0, np.pi / 4, 0), (3, 1)))
    down = np.array((0, 0, -G))
    assert motion.gravity(down) == pytest.approx(np.array([down, G * np.array((1, 0, -1)) / np.sqrt(2), (G, 0, 0)]))
    about_up = hf.Profile([0, 1], np.zeros((2, 3)), angular_velocity=[(0, 0, 1), (0, 0, 5)])
    assert (about_up.gravity(down) == down).all()


def test_proportional_times_are_asked_once(monkeypatch: pytest.MonkeyPatch) -> None:
    widths: list[int] = []
    usual = asking.load_factors

    def counted(*given: Any, **more: Any) -> Any:
        widths.append(given[2].shape[1])
        return usual(*given, **more)

    monkeypatch.setattr(asking, "load_factors", counted)
    table = np.zeros((50, 4))
    table[:, 0] = np.arange(50)
    table[:, 1:] = np.linspace(0, 1, 50)[:, None] * (0.3, 0.7, 0)
    alone = hf.carry(carried(), table, engine="limit")
    assert widths == [2]  # none, and one direction
    assert alone.factor[1:] == pytest.approx(alone.factor[-1] / np.linspace(0, 1, 50)[1:])


def test_every_time_is_that_of_transport_limits() -> None:
    """Carried the other way round: the limit along each acceleration over its size."""
    rng = np.random.default_rng(3)
    assembly = hf.assemble(hf.shipped_scene("table"))
    a = rng.normal(size=(12, 3)) * (3, 3, 1)
    c = hf.carry(assembly, np.column_stack([np.arange(12), a]), engine="limit")
    t = hf.transport_limits(assembly, a, engine="limit")
    assert c.factor * np.linalg.norm(a, axis=1) == pytest.approx(t.acceleration, rel=1e-6)
    assert list(c.moving) == list(t.moving)


def test_doubt_is_neither_yes_nor_no() -> None:
    """What the engine cannot promise is undecided, and undecided rows give no safe speed."""
    c = hf.carry(carried(), ramp((1 - 1e-7) * MU * G), engine="compliant")
    assert c.lower[1] < 1 <= c.factor[1]
    assert c.outcome is hf.Status.UNDECIDED
    assert "not known to hold from 1 s" in c.reason
    wedged = hf.assemble(hf.Scene([floor(2, 2), *_clamped()], MU))
    w = hf.carry(wedged, ramp(1.0), engine="limit")
    assert w.outcome is hf.Status.UNDECIDED
    assert np.isnan(w.used).all()
    assert w.time_scale() == 0


def _clamped() -> list[hf.Body]:
    """A cube held between two walls by nothing but friction, above the floor."""
    walls = [
        hf.Body(f"wall{k}", hf.Box((0.1, 0.1, 1)), pose=at(x, 0, 0.5), fixed=True) for k, x in ((0, -0.1), (1, 0.1))
    ]
    return [*walls, hf.Body("cube", hf.Box((0.1, 0.1, 0.1)), mass=1, pose=at(0, 0, 0.5))]


def test_what_falls_at_rest_gives_way_at_once() -> None:
    hanging = hf.assemble(hf.Scene([floor(2, 2), box("cube", (0.1, 0.1, 0.1), 1, (0, 0, 0.5))], MU))
    c = hf.carry(hanging, ramp(1.0), engine="limit")
    assert c.outcome is hf.Status.UNSTABLE
    assert (c.time, c.first) == (0.0, ("cube",))


@pytest.mark.parametrize("separator", [",", ";", " ", "\t"])
def test_files_say_the_same_as_tables(tmp_path: Path, separator: str) -> None:
    table = np.hstack([ramp(2.5), np.arange(18).reshape(3, 6) / 10])
    names = ["time [s]", "a_x", "ay", "AZ", "alphax", "alphay", "alphaz", "omegax", "omegay", "omegaz"]
    heads = names if separator in ",;" else ["t", *names[1:]]
    order = [0, 3, 2, 1, *range(4, 10)]
    lines = ["# recorded", separator.join(heads[k] for k in order)]
    rows = [separator.join(f"{row[k]:.3f}" for k in order) for row in table]
    if separator == ";":
        rows = [row.replace(".", ",") for row in rows]
    (tmp_path / "drive.csv").write_text("\n".join([*lines, *rows, ""]), encoding="utf-8-sig")
    read = hf.Profile.from_file(tmp_path / "drive.csv")
    given = hf.Profile.from_table(table, name="drive", source="drive.csv")
    assert read == given
    np.testing.assert_array_equal(given.angular_acceleration[2], [1.2, 1.3, 1.4])
    np.testing.assert_array_equal(given.angular_velocity[2], [1.5, 1.6, 1.7])
    (tmp_path / "bare.csv").write_text("\n".join(separator.join(f"{v}" for v in row[:4]) for row in table))
    assert (hf.Profile.from_file(tmp_path / "bare.csv").acceleration == table[:, 1:4]).all()


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("", "no rows"),
        ("t,ax,ay\n0,1,2\n", "no column az"),
        ("t,ax,ay,az,az\n0,1,2,3,4\n", "twice"),
        ("t,ax,ay,az,speed\n0,1,2,3,4\n", "speed"),
        ("0,1,2,3\n1,2,3\n", "row 2 has 3 cells"),
        ("0,1,2,3\n1,2,x,3\n", "needs numbers"),
        ("0,1,2,3\n0,1,2,3\n", "increase"),
    ],
)
def test_other_files_are_told(tmp_path: Path, text: str, told: str) -> None:
    path = tmp_path / "drive.csv"
    path.write_text(text)
    with pytest.raises(hf.HoldfastError, match=told):
        hf.Profile.from_file(path)


def test_a_missing_file_is_told() -> None:
    with pytest.raises(hf.HoldfastError, match=r"profile 'nix.csv': there is no such file.*known: .*road"):
        hf.carry(carried(), "nix.csv")


def test_named_motions_name_their_sources() -> None:
    for name, told in hf.Profile.standards().items():
        motion = hf.Profile.named(name)
        assert "http" in motion.source
        assert "http" in told
        assert (np.diff(motion.time) > 0).all()
        assert not motion.acceleration[[0, -1]].any()
    with pytest.raises(hf.HoldfastError, match="road"):
        hf.Profile.named("raod")
    with pytest.raises(hf.HoldfastError, match="vertical"):
        hf.Profile.named("road", heading=(0, 0, 1))


def test_cargo_is_thrown_forwards_when_the_vehicle_brakes() -> None:
    """0.8 g forwards: the carrier accelerates against its heading; heading and up turn with the scene."""
    road = hf.Profile.named("road", heading=(0, 2, 0))
    assert road.acceleration[1] == pytest.approx((0, -0.8 * 9.80665, 0))
    assert np.abs(road.acceleration).max(0) == pytest.approx(np.array((0.5, 0.8, 0)) * 9.80665)
    side = hf.Profile.named("sea_msc", heading=(1, 0, 0), up=(0, 1, 0))
    assert np.abs(side.acceleration).max(0) == pytest.approx(np.array((0.7, 0.2, 1.2)) * 9.80665)
    c = hf.carry(carried(0.05), "road", engine="limit")
    assert c.first == ("box",)
    assert c.time == pytest.approx(0.05 * MU * G / (0.8 * 9.80665), rel=0.02)  # on the first ramp
    assert c.mechanism[1].twists[0, 0] > 0


def test_turns_about_several_axes_follow_one_another_in_the_axes_of_the_carrier() -> None:
    """First a quarter about z, then one about its own x: gravity then comes from its own y, whatever came before."""
    quarter = np.pi / 2
    rates = [(0, 0, quarter), (0, 0, quarter), (quarter, 0, 0), (quarter, 0, 0)]
    motion = hf.Profile([0, 1, 1 + 1e-9, 2], np.zeros((4, 3)), angular_velocity=rates)
    assert motion.gravity(np.array((0, 0, -G)))[-1] == pytest.approx((0, -G, 0), abs=1e-6)
    other = hf.Profile([0, 1, 1 + 1e-9, 2], np.zeros((4, 3)), angular_velocity=rates[::-1])
    assert other.gravity(np.array((0, 0, -G)))[-1] == pytest.approx((-G, 0, 0), abs=1e-6)


@pytest.mark.parametrize("speed", [0.5, 3.0])
def test_a_faster_motion_turns_as_far_and_loads_by_the_square(speed: float) -> None:
    """The same way in less time: the same turns, and every inertial load of a turning carrier s² as large."""
    motion = hf.Profile([0, 1], [(1, 0, 0)] * 2, [(0, 1, 0)] * 2, [(0, 0, 0), (0.3, 0, 0.4)])
    fast = motion.at_speed(speed)
    assert fast.turns().as_matrix() == pytest.approx(motion.turns().as_matrix())
    assembly = carried(0.05, (0.3, 0.2))
    usual, more = (
        asking.inertial_wrenches(assembly, m.acceleration, m.angular_acceleration, m.angular_velocity, m.pivot)
        for m in (motion, fast)
    )
    assert more == pytest.approx(speed**2 * usual)


def up_by(mean: float, drift: float = 0.0) -> np.ndarray:
    """Two shoves along x, and an upward acceleration of this mean that shakes."""
    table = np.zeros((9, 4))
    table[:, 0] = np.arange(9.0)
    table[[2, 6], 1] = 2.0, -2.0
    table[:, 3] = mean + 3 * (-1.0) ** np.arange(9)
    table[[0, -1], 3] = mean
    return table


@pytest.mark.parametrize(("mean", "told"), [(9.81, True), (9.5, True), (0.0, False), (-9.81, False), (4.0, False)])
def test_accelerations_that_contain_gravity_are_told(mean: float, told: bool) -> None:
    notes = hf.carry(carried(), up_by(mean), engine="limit").notes
    assert any("do these accelerations contain gravity? Take it off" in note for note in notes) is told


def test_gravity_in_a_profile_is_along_the_scenes_own_vertical() -> None:
    table = ramp(8.0)
    table[:, 3] = G
    for rows in (table, table[:1]):
        assert any("upwards by 9.81 m/s²" in note for note in hf.carry(carried(), rows, engine="limit").notes)
        turned = hf.carry(carried().tilted((0, 90, 0)), rows, engine="limit")
        assert not any("contain gravity" in note for note in turned.notes)
