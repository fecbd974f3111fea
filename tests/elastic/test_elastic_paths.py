"""Load paths of a block: closed forms, and what single steps meet."""

from __future__ import annotations

import numpy as np
import pytest
from elastic_blocks import HALF, HEIGHT, Array, Walk, at, block, push
from path_events import Event

import holdfast as hf
from holdfast.base.progress import listening
from holdfast.elastic.system import QUICK, PathOutcome, RestOutcome, System
from holdfast.engines.compliant.elastic_model import Springs
from holdfast.engines.compliant.grid import Grid
from holdfast.native import core
from holdfast.queries.request import push_columns
from holdfast.scene.shipped.blocks import box, floor, wall

X, DOWN, UP = (1.0, 0.0, 0.0), (0.0, 0.0, -1.0), (0.0, 0.0, 1.0)
PUSHES = {
    "slides": (0.2, push(X), 0.2),
    "tilts": (2.0, push(X), HALF / HEIGHT),
    "pressed": (0.5, push(DOWN), np.inf),
    "slanted": (0.5, push((0.6, 0.3, -0.4), 0.2), None),
}


@pytest.mark.parametrize("make", [System.dense, System.by_fronts])
@pytest.mark.parametrize(("mu", "load", "peak"), [p for p in PUSHES.values() if p[2] is not None])
def test_peaks_have_their_closed_form(make: object, mu: float, load: Array, peak: float) -> None:
    system = make(block(mu))
    rest = system.come_to_rest()
    assert rest.outcome is RestOutcome.RESTS
    found = system.paths(rest.q, load[None])
    assert found.outcome[0] == (PathOutcome.PEAK if np.isfinite(peak) else PathOutcome.ENDLESS)
    assert found.factor[0] == pytest.approx(peak, rel=2e-4)


def test_a_body_lifted_straight_up_loses_all_contacts_at_once_at_the_peak() -> None:
    """Behind it there is no path: the outcome is for others to find."""
    system = System.dense(block(0.5))
    found = system.paths(system.come_to_rest().q, push(UP)[None])
    assert found.outcome[0] == PathOutcome.LOST
    assert 0 < found.peak[0] <= 1 + 1e-6


def test_what_has_no_weight_to_rest_on_drifts() -> None:
    falling = block(0.5)._replace(wrench=np.array([0.0, 0, 1, 0, 0, 0]))
    end = System.dense(falling).come_to_rest()
    assert end.outcome is RestOutcome.DRIFTS
    assert end.drift[2] > 0


def test_where_nodes_change_in_the_last_step_the_direction_is_that_behind_them() -> None:
    """Two of four nodes touch again, and slide; much unbalance is allowed, or another step would follow."""
    m, load = block(2.0), push(X)
    # Balance: all of the weight, no drag, s is free
    work, path = core.Work(m, None), (1.0, 0.0, 0.0, np.zeros(6))
    work.w[:], work.c[:] = load, load
    q = System.dense(m).come_to_rest().q.copy()
    assert core.newton(m, work, path, q, 0.0, float(load @ q), 1e-9, 5, 0.0, None).converged
    q += 2.6 * work.rhs[:-1, 1]
    s = 2.6 * work.rhs[-1, 1]
    before = core.unbalance(m, work, path, q, s)
    found = core.newton(m, work, path, q, s, float(load @ q), 0.15, 5, 0.0, None)
    assert found.converged
    assert found.states != before
    assert (found.steps, found.systems) == (1, 2)
    direction = work.rhs[:, 1].copy()
    core.unbalance(m, work, path, q, found.s)
    work.rhs[:] = 0.0
    work.rhs[-1, 1] = 1.0
    assert core.solve(m, work, 0.0, 0.0, None) == found.sign
    np.testing.assert_allclose(direction, work.rhs[:, 1])


def test_without_contacts_no_path_begins() -> None:
    hovering = np.array([0.0, 0, 1, 0, 0, 0])
    assert Walk(0.2, push(X), hovering).event is Event.NO_BEGINNING


def test_a_step_beyond_the_last_contact_is_shortened_until_it_ends_just_before_it() -> None:
    """Lifted straight up, all four nodes open at once: no point lies beyond."""
    walk = Walk(0.5, push(UP))
    walk.stepper.now.step = 10.0
    events = [walk.step()]
    while events[-1] is Event.SHORTENED:
        events.append(walk.step())
    assert events[0] is Event.SHORTENED
    assert events[-1] is Event.ADVANCED
    assert walk.stepper.now.corner
    assert 0.99 < walk.stepper.now.s < 1.0
    assert walk.cross() is Event.RELEASED


def test_a_step_that_fails_where_no_node_changes_is_shortened_until_it_is_stuck() -> None:
    walk = Walk(0.2, push(X))
    walk.stepper.now.step = np.nan  # no point is found at any length
    assert [walk.step() for _ in range(4)] == [*[Event.SHORTENED] * 3, Event.STUCK]


def test_a_path_is_set_out_towards_the_state_that_a_small_load_leads_to() -> None:
    """Sideways the base gives by s and tilts by s over the moment of its springs, 1/4: the centre moves by 5 s."""
    walk = Walk(2.0, push(X))
    walk.stepper.tangent[:] = 0, 1, 0, 0, 0, 0
    assert walk.set_out()
    length = np.hypot(5, 4)
    np.testing.assert_allclose(walk.stepper.tangent, np.array([5, 0, 0, 0, 4, 0]) / length, atol=1e-6)
    assert walk.stepper.now.slope == pytest.approx(1 / length, rel=1e-6)
    assert walk.stepper.now.step == pytest.approx(0.1 * length, rel=1e-6)
    assert walk.step() is Event.ADVANCED
    assert walk.stepper.now.s == pytest.approx(0.1, rel=1e-6)


def test_a_path_is_set_out_once_and_from_its_beginning() -> None:
    walk = Walk(2.0, push(X))
    assert walk.set_out()
    assert not walk.set_out()
    walk = Walk(2.0, push(X))
    assert walk.step() is Event.ADVANCED
    assert not walk.set_out()


@pytest.mark.parametrize(
    ("mu", "changed"),
    [(0.05, {}), (2.0, {"slope": -1.0}), (2.0, {"elastic": 0.02})],
    ids=["slides at half of that load", "falls from the beginning", "far"],
)
def test_a_path_is_not_set_out_where_its_state_may_be_another(mu: float, changed: dict[str, float]) -> None:
    walk = Walk(mu, push(X))
    for name, value in changed.items():
        setattr(walk.stepper.now, name, value)
    assert not walk.set_out()


def test_behind_a_change_of_one_node_the_path_goes_on() -> None:
    walk = Walk(0.2, push((1.0, 0.2, 0.0), 0.3))
    assert walk.cross() is Event.NODE_CHANGED
    assert walk.stepper.now.s > 0


@pytest.mark.parametrize("orientation", [1.0, -1.0])
def test_onwards_is_where_the_determinant_keeps_the_sign_that_it_had_at_rest(orientation: float) -> None:
    work, tangent = core.Work(block(0.5), None), np.zeros(6)
    work.rhs[:, 1] = 0.5, 0.0, -0.25, 0.0, 0.0, 0.0, 3.0
    length = np.hypot(0.5, 0.25)
    for sign in (orientation, -orientation):
        onwards = sign * orientation / length
        assert core.turn(work, sign, orientation, tangent) == pytest.approx(3.0 * onwards)
        np.testing.assert_allclose(tangent, onwards * work.rhs[:6, 1])
        np.testing.assert_allclose(work.c @ tangent, 1.0)


@pytest.mark.parametrize(("reached", "expected"), [(0, False), (1, True)])
def test_a_point_far_from_where_the_directions_at_both_ends_lead_is_torn(reached: int, expected: bool) -> None:
    """Both directions are along the first axis; the point lies along the first or the second."""
    axes = np.eye(6)
    work = core.Work(block(0.5), None)
    work.rhs[0, 1] = 1.0
    assert core.torn(work, 1.0, 1.0, np.zeros(6), axes[0], axes[reached], 1.0, 0.7) is expected


def test_how_far_is_too_far() -> None:
    """The point lies half a step beside the mean direction: too far only where it was hard to find."""
    axes = np.eye(6)
    work = core.Work(block(0.5), None)
    work.rhs[0, 1] = 1.0
    point = axes[0] + 0.5 * axes[1]
    assert not core.torn(work, 1.0, 1.0, np.zeros(6), axes[0], point, 1.0, 0.7)
    assert core.torn(work, 1.0, 1.0, np.zeros(6), axes[0], point, 1.0, 0.4)


@pytest.mark.parametrize("along", [(1.0, 0.2, -0.1), (0.5, 0.5, 0.1), (1.0, 1.0, 0.0)])
def test_which_idle_faces_part_is_found_at_the_first_point(along: tuple[float, float, float]) -> None:
    """All sides of 60 boxes touch without force: with 8 steps of Newton's method each try was shortened."""
    places = [(i, j, k) for i in range(5) for j in range(4) for k in range(3)]
    boxes = [
        box(f"{i}{j}{k}", (0.2, 0.15, 0.1), 2 + 0.1 * ((i + 2 * j + 3 * k) % 5), (0.2 * i, 0.15 * j, 0.05 + 0.1 * k))
        for i, j, k in places
    ]
    assembly = hf.assemble(hf.Scene([floor(4.0, 4.0), *boxes], 0.5))
    grid = Grid.of(assembly, assembly.weight_wrench(), Springs(7))
    top = assembly.index["222"]
    unit = np.array([along]) / np.linalg.norm(along)
    load = grid.loads(push_columns(assembly, top, assembly.com[[top]] + [0, 0, 0.05], unit))[0]
    model, work, fronts = grid.system.model, core.Work(grid.system.model, grid.system.fronts), grid.system.fronts
    stepper = core.Stepper(np.zeros(len(load)), QUICK)
    assert core.begin(model, work, stepper, grid.settled.q, load, fronts) == Event.BEGUN
    assert core.advance(model, work, stepper, fronts) == Event.ADVANCED


@pytest.mark.parametrize(
    ("since", "elastic", "length", "step"),
    [
        (10.0, 1.0, 90.0, 10.1),  # it has to be flat up to 100
        (10.0, 5.0, 90.0, 60.6),  # up to 30 times the displacement at rest
        (10.0, 1.0, 30.0, 70.7),
        (10.0, 1.0, 12.0, 36.0),  # the usual step leads less far
        (np.inf, 1.0, 90.0, 270.0),
    ],
)
def test_no_step_is_longer_than_it_takes_to_see_that_a_path_remains_flat(
    since: float, elastic: float, length: float, step: float
) -> None:
    """A box on a pallet slid at 511 N; a longer step led to where another contact stopped it, and on to 530 N."""
    now = at(slope=0.0, length=length, elastic=elastic, at_peak=10.0)
    now.flat_since, now.step, now.turned, now.fastest = since, 1e3, 0.0, 3.0
    core.set_next_step(now)
    assert now.step == pytest.approx(step)
    if np.isfinite(since) and step < 3 * length:
        now.length += now.step
        assert core.appraise(now) == Event.FLAT


def test_where_the_load_falls_steps_are_so_short_that_the_end_is_seen() -> None:
    now = at(slope=-0.5, highest=2.0, length=100.0)
    now.step, now.turned = 10.0, 0.1
    core.set_next_step(now)
    assert now.step == pytest.approx(2 * 0.01 / 0.5)


@pytest.mark.parametrize(
    ("now", "event"),
    [
        (at(), Event.ADVANCED),
        (at(s=0.98), Event.FALLEN),
        (at(late=80), Event.ADVANCED),
        (at(late=81), Event.FALLEN),
        (at(slope=-1e-9, length=10.0), Event.FALLEN),
        (at(length=1e9, at_peak=1e9), Event.FAR),
        (at(length=0.9e8, at_peak=1e8), Event.ADVANCED),
        (at(rest=0.1, by_springs=0.1 + 0.9e-5), Event.ADVANCED),
        (at(rest=0.1, by_springs=0.1 + 1.1e-5), Event.FAR),  # the spring carries what contacts do not
        (at(strength=100.0, by_springs=0.9e-3), Event.ADVANCED),  # of a load a hundred times the weight
        (at(slope=1e-9, length=100.0, at_peak=100.0, flat_since=9.0), Event.FLAT),
        (at(slope=1e-9, length=100.0, at_peak=100.0, flat_since=11.0), Event.ADVANCED),
        (at(s=200.0, highest=200.0, slope=1.0, length=200.0, at_peak=200.0, similar_since=19.0), Event.PROPORTIONAL),
        (at(s=200.0, highest=200.0, slope=1.0, length=200.0, at_peak=200.0, similar_since=21.0), Event.ADVANCED),
    ],
)
def test_where_a_path_ends(now: core.Progress, event: Event) -> None:
    assert core.appraise(now) == event


class Stopped(KeyboardInterrupt):
    """The user has had enough."""


def test_a_path_that_takes_long_is_stopped_half_way() -> None:
    """Whoever listens hears of it while the path of 500 bricks, in machine code, is not yet at its end."""
    assembly = hf.assemble(wall(50, 10, 0.25, "wall"))
    grid = Grid.of(assembly, assembly.weight_wrench(), Springs(7))
    load = np.zeros((len(assembly.movable) * 6, 1))
    load[-5] = 1.0
    heard: list[int] = []

    def listen(stage: str, now: int, total: int) -> None:
        if stage == "load paths":
            heard.append(now)
            if len(heard) > 2:
                raise Stopped

    with listening(listen), pytest.raises(Stopped):
        grid.paths(load)
    assert heard == [0, 0, 0]
