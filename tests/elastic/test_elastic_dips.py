"""Falls of the load between the points of a path: whether it hides maxima, where its peak is, and where it ends."""

from __future__ import annotations

import numpy as np
import pytest
from elastic_blocks import Walk, at, push
from path_events import Event

import holdfast as hf
from holdfast.elastic.system import CLOSE
from holdfast.engines.compliant.elastic_model import Springs
from holdfast.engines.compliant.grid import Grid
from holdfast.native import core
from holdfast.queries.request import push_columns
from holdfast.scene.shipped import shipped_scene

X = (1.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("heights", "first"),
    [
        ((1.0, 2.0, 3.0), 0.0),
        ((1.0, 2.0, 1.99, 1.5), 0.0),  # never above it again: it is the peak itself
        ((1.0, 2.0, 1.999, 3.0), 0.0),  # by less than 0.2 %
        ((1.0, 2.0, 1.99, 1.985, 3.0, 2.9, 4.0), 2.0),
        ((1.0, 2.0, 1.997, 2.0001, 1.9, 3.0), 2.0),
    ],
)
def test_the_first_maximum_is_that_from_which_the_load_dips_before_it_rises_again(
    heights: tuple[float, ...], first: float
) -> None:
    walk = Walk(0.2, push(X))
    now = walk.stepper.now
    for s in heights:
        walk.work.rhs[0, 1] = 1.0
        core.land(walk.model, walk.work, walk.stepper, s, 1.0)
    assert now.first == pytest.approx(first, rel=1e-3)
    assert now.highest == max(heights)


@pytest.mark.parametrize(
    ("onward", "load", "passed"),
    [
        (0.045, 1.5, True),
        (-0.1, 1.5, True),
        (0.055, 1.5, False),  # the load still rises
        (0.045, 2.01 / 1.05, False),  # there was hardly any room for a maximum
    ],
)
def test_a_step_to_a_level_may_have_passed_over_a_maximum(onward: float, load: float, passed: bool) -> None:
    """From the load 1 at the slope 1 along a step of 1: it may have gone on to 2."""
    assert core.passes_over(at(s=1.0), 1.0, load, onward) == passed


@pytest.mark.parametrize(
    ("rise", "s", "falls", "hidden"),
    [
        (0.4, 99.9, -0.4, False),  # the maximum lies at 100.05
        (9.0, 99.5, -8.0, True),  # it lies at 101.9, from which 99.5 is a clear fall
        (9.0, 99.5, 1.0, True),  # the load rises at both ends, and ends lower
        (9.0, 103.0, 1.0, False),  # it may have bent once
        (-1.0, 98.9, -9.0, False),
        (-2.0, 100.8, -2.0, False),  # a minimum of 99.87, and behind it a maximum of 100.93
        (-9.0, 100.2, -1.0, True),  # it falls at both ends, and ends higher: a minimum lies at 98.9
        (-9.0, 99.9, 8.0, True),  # the minimum lies at 97.9
        (-0.4, 99.9, 0.4, False),
        (-9.0, 98.5, 8.0, False),  # that it has clearly fallen is seen anyway
    ],
)
@pytest.mark.parametrize("dipped", [0.0, 90.0])
def test_a_step_may_hide_how_far_the_load_falls(
    rise: float, s: float, falls: float, hidden: bool, dipped: float
) -> None:
    now = at(s=100.0, highest=100.0, crest=100.0, trough=100.0, dipped=dipped)
    assert core.hides_dip(now, rise, s, falls) == hidden
    small = core.hides_dip(at(s=100.0, highest=100.0, crest=100.0, trough=100.0, dipped=dipped), 0.8, 99.95, -0.8)
    assert small == (dipped == 0)  # 0.22 below the maximum: a dip, and perhaps the first


@pytest.mark.parametrize(
    ("rise", "falls", "doubt"), [(9.0, -8.0, True), (0.1, -0.1, False), (9.0, 8.0, True), (0.1, 0.1, False)]
)
def test_a_step_that_may_hide_a_fall_is_doubted_however_straight_it_was(rise: float, falls: float, doubt: bool) -> None:
    walk = Walk(0.2, push(X))
    now = walk.stepper.now
    now.s = now.highest = now.crest = now.trough = 100.0
    now.slope, now.step, now.turned, now.orientation = rise / 2, 2.0, 0.0, 1.0
    walk.work.rhs[:, 1] = 0.0
    walk.work.rhs[0, 1], walk.work.rhs[6, 1] = 1.0, falls / now.step
    assert core.doubtful(walk.model, walk.work, walk.stepper, core.Iteration(True, 99.85, 3, 3, 0, 1.0)) == doubt


@pytest.mark.parametrize(
    ("body", "point", "along", "peak", "later"),
    [
        ("v5", (0.2302, -0.075, 0.1585), (0.0, 1.0, 0.0), 55.78, 56.13),
        ("v3", (-0.0542, -0.0214, 0.192), (0.13, -0.276, 0.952), 37.64, 40.06),
    ],
)
def test_a_path_ends_where_the_load_has_clearly_fallen_between_points(
    body: str, point: tuple[float, ...], along: tuple[float, ...], peak: float, later: float
) -> None:
    """Points lie 0.4 % below the crest; from the highest of them the load had fallen by 0.8 % before it rose to more.

    The peaks are those of paths in steps of a sixth.
    """
    assembly = hf.assemble(shipped_scene("arch"))
    grid = Grid.of(assembly, assembly.weight_wrench(), Springs(7))
    unit = np.array([along]) / np.linalg.norm(along)
    found = grid.paths(push_columns(assembly, assembly.index[body], np.array([point]), unit))
    assert found.peak[0] == pytest.approx(peak, rel=2e-3)
    assert found.peak[0] < 0.997 * later


@pytest.mark.parametrize(("trough", "fell"), [(0.995, False), (0.985, True)])
def test_whether_the_load_has_fallen_from_its_crest_is_told_by_the_refined_peak(trough: float, fell: bool) -> None:
    """A block that slides keeps its load; here its crest is thought to have been higher, as between two points."""
    walk = Walk(0.2, push(X))
    now, stepper, work = walk.stepper.now, walk.stepper, walk.work
    while not now.closed:
        if walk.step() is Event.ADVANCED:
            core.set_next_step(now)
    assert not core.fell_from_crest(walk.model, work, stepper, walk.fronts)  # nothing suggests so
    now.crest, now.trough = 1.02 * now.highest, trough * now.highest
    tangent, plane, highest = stepper.tangent.copy(), work.c.copy(), now.highest
    assert core.fell_from_crest(walk.model, work, stepper, walk.fronts) == fell
    assert now.crest == now.highest >= highest
    np.testing.assert_array_equal(stepper.tangent, tangent)
    np.testing.assert_allclose(work.c, plane, rtol=1e-12)


def test_the_trough_is_the_lowest_point_since_the_crest() -> None:
    now = at(s=0.0)
    steps = [(1.0, 1.0, 1.0), (1.0, 2.0, 1.0), (0.5, 2.0, -0.5), (-0.5, 1.5, -0.1), (-0.1, 1.8, 0.3), (0.3, 2.5, 0.3)]
    seen = []
    for rise, s, falls in steps:
        core.measure_dip(now, rise, s, falls)
        now.s = s
        seen.append((now.crest, now.trough))
    assert seen == [(1, 1), (2, 2), (2.125, 2), (2.125, 1.5), (2.125, 1.5), (2.5, 2.5)]


def test_what_is_reached_before_contacts_have_slid_three_times_as_far_as_they_give() -> None:
    """A step on a straight path that leads from 1 to 5 times as far crosses 3 midway; what follows does not count."""
    now = at(s=10.0, slid=1.0, before=10.0)
    core.measure_sliding(now, 4.0, 14.0, 4.0, 5.0)
    assert (now.before, now.slid) == (pytest.approx(12.0), 5.0)
    near = at(s=10.0, slid=1.0, before=10.0)
    core.measure_sliding(near, 4.0, 14.0, 4.0, 2.9)
    assert (near.before, near.slid) == (14.0, 2.9)
    lower = at(s=10.0, slid=1.0, before=11.0)
    core.measure_sliding(lower, -4.0, 6.0, -4.0, 2.0)
    assert lower.before == 11.0


@pytest.mark.parametrize(
    ("seen", "estimate", "perhaps"),
    [(0.005, 0.005, False), (0.005, 0.0071, True), (0.005, 0.0063, False), (0.0, 0.003, False), (0.0099, 0.02, True)],
)
def test_a_fall_may_be_some_times_deeper_between_points_than_estimated(
    seen: float, estimate: float, perhaps: bool
) -> None:
    assert core.may_have_fallen(seen, estimate) == perhaps
    assert core.fall(99.0, 100.0) == pytest.approx(0.01)


def test_a_maximum_between_points_is_a_new_peak_where_it_is() -> None:
    """From there on a higher one is waited for, not from the point behind it."""
    now = at(s=1.0, highest=1.0, crest=1.0, trough=1.0, noted=1.0, length=30.0, at_peak=10.0, late=3)
    now.step = 15.0
    core.measure_dip(now, 1.0, 1.0, -2.0)
    assert now.peaked
    assert now.topped
    assert now.noted == now.crest == pytest.approx(1 + 2 / 3**1.5)
    assert now.at_peak == pytest.approx(30 - 15 * (1 - 1 / 3**0.5))
    assert now.late == 0
    core.measure_dip(now, -0.1, 0.85, -0.2)
    assert not now.peaked
    assert not now.topped


def test_the_peak_is_sought_where_the_load_was_highest_between_points() -> None:
    """The crest lies behind the second point, which is lower than the first; a higher point is the peak after all."""
    walk = Walk(0.2, push(X))
    now = walk.stepper.now
    now.orientation, now.step = 1.0, 1.0
    now.closed = False
    for s, slope in ((1.0, 0.001), (0.9995, 0.05), (0.9998, -0.05), (0.999, -0.01)):
        walk.work.rhs[:] = 0.0
        walk.work.rhs[0, 1], walk.work.rhs[6, 1] = 1.0, slope
        now.step = 1.0
        core.land(walk.model, walk.work, walk.stepper, s, 1.0)
    assert now.closed
    assert (now.rising_s, now.falling_s) == (0.9995, 0.9998)
    assert now.highest == 1.0
    assert now.crest == pytest.approx(0.9995 + 0.0125, abs=5e-4)
    walk.work.rhs[6, 1] = 0.02
    core.land(walk.model, walk.work, walk.stepper, 1.001, 1.0)  # below the crest, above all points
    assert not now.closed
    assert now.rising_s == now.highest == 1.001


def test_the_peak_is_sought_within_a_step_behind_which_the_load_rises_again() -> None:
    walk = Walk(0.2, push(X))
    now = walk.stepper.now
    now.orientation = 1.0
    for s, slope in ((1.0, 0.5), (0.9, 0.1)):
        walk.work.rhs[:] = 0.0
        walk.work.rhs[0, 1], walk.work.rhs[6, 1] = 1.0, slope
        now.step = 1.0
        core.land(walk.model, walk.work, walk.stepper, s, 1.0)
    assert now.closed
    assert (now.rising_s, now.falling_s, now.falling_slope) == (1.0, 0.9, 0.1)


@pytest.mark.parametrize(
    ("shift", "bend", "rise", "falls", "astray"),
    [
        (0.0, 0.0, 0.6, 0.0, False),  # midway it is in balance
        (1.0, 0.0, 0.6, 0.0, True),  # midway it is back where it was at rest
        (1.0, 1.0, 0.6, 0.0, False),  # both ends are, and their directions lead to the point in balance
        (0.0, 1.0, 0.6, 0.0, True),  # they lead away from it
        (1.0, 0.0, 0.6, 0.6, False),  # the slope has not changed
        (1.0, 0.0, 0.005, 0.0, False),  # there was no room for a maximum
    ],
)
def test_a_step_strays_where_its_middle_is_out_of_balance(
    shift: float, bend: float, rise: float, falls: float, astray: bool
) -> None:
    walk = Walk(0.2, push(X))
    rest = walk.stepper.q.copy()
    assert walk.step() is Event.ADVANCED
    now, stepper, work = walk.stepper.now, walk.stepper, walk.work
    s, found = now.s, stepper.q.copy()
    stepper.q[:] = stepper.trial[:] = found + shift * (rest - found)
    stepper.tangent[:], work.rhs[:] = 4 * bend * (found - rest), 0.0
    work.rhs[:6, 1] = -stepper.tangent
    now.step, now.slope = 1.0, rise * s
    risen = s * (rise + falls) / 2
    now.s = s - risen / 2 - s * (rise - falls) / 8  # midway the cubic has the load s
    point = core.Iteration(True, now.s + risen, 2, 2, 0, 1.0)
    assert core.strays(walk.model, work, stepper, point, rise * s, falls * s) == astray
    work.rhs[6, 1] = falls * s
    now.turned = 0.0
    assert core.doubtful(walk.model, work, stepper, point) == astray
    now.doubted = 1
    assert not core.doubtful(walk.model, work, stepper, point)  # once is enough: at a sharp bend every step does


@pytest.mark.parametrize(
    ("known", "step"),
    [
        ({}, 25.0),
        ({"peaked": True}, 10.0),  # a maximum lies just behind: perhaps a higher one ahead
        ({"slope": -1e-9}, 5.05),  # it falls: soon it is the end
        ({"s": 0.997}, 5.05),
        ({"s": 0.999}, 25.0),
        ({"elastic": 1e-6}, 5.05),  # FARTHEST
    ],
)
def test_steps_are_no_longer_than_they_need_to_be(known: dict[str, float], step: float) -> None:
    now = at(slope=0.5, length=95.0, at_peak=10.0, crest=1.0)
    now.step, now.turned = 10.0, 0.01
    for name, value in known.items():
        setattr(now, name, value)
    core.set_next_step(now)
    assert now.step == pytest.approx(step)


@pytest.mark.parametrize(
    ("s", "slope", "length", "event"),
    [
        (0.9982, 0.5, 10.1, Event.ADVANCED),
        (0.9978, 0.5, 10.1, Event.FALLEN),  # it rises, and is still below its crest
        (0.9978, 0.5, 9.9, Event.ADVANCED),
        (1.0, -0.5, 10.1, Event.FALLEN),
        (1.0, 0.5, 101.0, Event.FALLEN),
    ],
)
def test_behind_a_maximum_a_higher_one_is_waited_for_less_long(
    s: float, slope: float, length: float, event: Event
) -> None:
    assert core.appraise(at(s=s, slope=slope, length=length, at_peak=1.0, crest=1.0, elastic=10.0)) == event


@pytest.mark.parametrize(
    ("scene", "body", "point", "along", "peak"),
    [
        ("tall_table", "slab", (0.21875, -0.1, 0.625), (0.09576195, 0.94407468, -0.31551965), 5.1227),  # 5.212 before
        ("slope_two", "cube2", (0.05, -0.03354102, 0.16071594), (-0.9374576, -0.31544293, -0.14720396), 7.493),  # 7.796
        ("slope_two", "cube1", (0.05, -0.06335526, 0.14580882), (-0.93132776, 0.2828303, 0.22942457), 6.1227),  # 5.772
        ("slope_two", "cube2", (-0.05, -0.01118034, 0.15326238), (0.99686988, -0.05942561, -0.05214434), 8.7437),
        ("arch", "v4", (0.09406949, -0.075, 0.23462176), (0.07560261, 0.90922125, 0.40939097), 50.829),  # 51.055
        ("arch", "v1", (-0.26317959, -0.075, 0.12435604), (0.0, 1.0, 0.0), 50.335),  # 50.171
        ("slope_two", "cube2", (-0.05, -0.0112, 0.1533), (0.9389, -0.1526, -0.3085), 12.895),  # 13.01
        ("wall2x2", "b0_1", (0.0875, -0.05, 0.0375), (-0.079, 0.9853, -0.1516), 74.541),  # 75.12
    ],
)
def test_maxima_within_long_steps_are_those_of_short_ones(
    scene: str, body: str, point: tuple[float, ...], along: tuple[float, ...], peak: float
) -> None:
    """Steps that led over them before gave what is said behind them."""
    assembly = hf.assemble(shipped_scene(scene))
    grid = Grid.of(assembly, assembly.weight_wrench(), Springs(7))
    unit = np.array([along]) / np.linalg.norm(along)
    loads = grid.loads(push_columns(assembly, assembly.index[body], np.array([point]), unit))
    quick, close = grid.system.paths(grid.settled.q, loads), grid.system.paths(grid.settled.q, loads, pace=CLOSE)
    assert close.sure[0] == pytest.approx(peak, rel=1e-3)
    assert quick.sure[0] == pytest.approx(close.sure[0], rel=2e-3)
    assert quick.systems[0] < close.systems[0]


@pytest.mark.parametrize(
    ("slope_before", "s", "slope", "rising"),
    [
        (1.0, 1.3, 0.5, True),  # it still rises
        (1.0, 0.9, 0.5, False),  # it has risen and fallen in front of this point
        (1.0, 1.3, -0.5, False),
        (-1.0, 0.8, -0.5, True),  # it has not risen to the second end yet
        (-1.0, 1.3, -0.5, False),
    ],
)
def test_of_a_bracket_the_side_is_kept_that_holds_a_maximum(
    slope_before: float, s: float, slope: float, rising: bool
) -> None:
    """Its ends have the loads 1.0 and 1.2."""
    walk = Walk(0.2, push(X))
    now = walk.stepper.now
    now.orientation, now.highest = 1.0, 1.2
    now.rising_s, now.rising_slope, now.falling_s, now.falling_slope = 1.0, slope_before, 1.2, -1.0
    walk.work.rhs[:] = 0.0
    walk.work.rhs[0, 1], walk.work.rhs[6, 1] = 1.0, slope
    core.narrow(walk.work, walk.stepper, s, 1.0)
    assert ((now.rising_s, now.falling_s) == (s, 1.2)) == rising
    assert ((now.rising_s, now.falling_s) == (1.0, s)) == (not rising)
    assert now.highest == max(s, 1.2)
