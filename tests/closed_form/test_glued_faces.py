"""Faces that hold by tension and cohesion: closed forms of pulling off, peeling, bending and sliding."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import holdfast as hf
from holdfast.sets import sensitivity

G, MU, SIDE = 9.81, 0.5, 0.1
AREA, MASS = SIDE**2, 1.0
WEIGHT = MASS * G
ENGINES = ("limit", "compliant")


def hanging(tension: float, **more: float) -> hf.Scene:
    """A cube under a ceiling."""
    ceiling = hf.Body("ceiling", hf.Box((1, 1, 0.1)), position=(0, 0, 0.05), fixed=True, material="paint")
    cube = hf.Body("cube", hf.Box((SIDE,) * 3), MASS, position=(0, 0, -SIDE / 2), material="tape")
    pair = ("tape", "paint")
    cohesion = {pair: more["cohesion"]} if more else {}
    return hf.Scene([ceiling, cube], hf.Friction(MU, tension={pair: tension}, cohesion=cohesion))


def bracket(tension: float) -> hf.Scene:
    """A brick whose end is glued to a wall: 32 mm long, 16 mm wide, 9.6 mm high, 20 g."""
    wall = hf.Body("wall", hf.Box((0.1, 0.1, 0.1)), position=(-0.05, 0, 0), fixed=True, material="brick")
    brick = hf.Body("brick", hf.Box((0.032, 0.016, 0.0096)), 0.02, position=(0.016, 0, 0), material="brick")
    return hf.Scene([wall, brick], hf.Friction(MU, tension={("brick", "brick"): tension}))


def on_slope(degrees: float, tension: float, cohesion: float | None = None) -> hf.Scene:
    """A plate of 100 x 100 x 10 mm and 1 kg on a slope, which slides before it turns over."""
    turn = np.radians(degrees)
    normal = np.array([np.sin(turn), 0, np.cos(turn)])
    slope = hf.Body("slope", hf.Box((1, 1, 0.1)), position=-0.05 * normal, rpy_degrees=(0, degrees, 0), fixed=True)
    plate = hf.Body("plate", hf.Box((0.1, 0.1, 0.01)), MASS, position=0.005 * normal, rpy_degrees=(0, degrees, 0))
    pair = ("plate", "slope")
    table = hf.Friction(
        MU, tension={pair: tension} if tension else {}, cohesion={} if cohesion is None else {pair: cohesion}
    )
    return hf.Scene([slope, plate], table)


@pytest.mark.parametrize("engine", ENGINES)
def test_a_cube_hangs_by_tension_times_area(engine: str) -> None:
    assert hf.stability(hanging(1.001 * WEIGHT / AREA), engine=engine).stable
    assert hf.stability(hanging(0.999 * WEIGHT / AREA), engine=engine).status is hf.Status.UNSTABLE
    pull = hf.robustness(hanging(3 * WEIGHT / AREA), "cube", (0, 0, -0.1), (0, 0, -1), engine=engine, bounds=True)
    assert float(pull) == pytest.approx(2 * WEIGHT, rel=1e-6)
    assert pull.lower[0] <= 2 * WEIGHT * (1 + 1e-9)
    assert pull.upper[0] == pytest.approx(2 * WEIGHT, rel=1e-6)


@pytest.mark.parametrize("engine", ENGINES)
def test_what_hangs_slides_at_friction_times_what_tension_leaves(engine: str) -> None:
    """|f_t| <= μ (f_n + tension area), where f_n = -weight."""
    push = hf.robustness(hanging(3 * WEIGHT / AREA), "cube", (-0.05, 0, 0), (1, 0, 0), engine=engine)
    assert float(push) == pytest.approx(MU * 2 * WEIGHT, rel=1e-6)


@pytest.mark.parametrize("engine", ENGINES)
def test_a_pull_at_an_edge_peels(engine: str) -> None:
    """About the far edge: the weight and tension area act at half the side, the pull at the whole side."""
    pull = hf.robustness(hanging(3 * WEIGHT / AREA), "cube", (0.05, 0, -0.1), (0, 0, -1), engine=engine)
    assert float(pull) == pytest.approx((3 - 1) * WEIGHT / 2, rel=1e-6)


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("tension", [3e4, 1e6])
def test_a_glued_cantilever_bends_off_at_tension_area_times_half_its_height(engine: str, tension: float) -> None:
    length, height, area, weight = 0.032, 0.0096, 0.016 * 0.0096, 0.02 * G
    by_hand = (tension * area * height / 2 - weight * length / 2) / length
    push = hf.robustness(bracket(tension), "brick", (length, 0, height / 2), (0, 0, -1), engine=engine, bounds=True)
    assert float(push) == pytest.approx(by_hand, rel=1e-6)
    assert push.lower[0] <= by_hand * (1 + 1e-9)


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("first", [False, True])
@pytest.mark.parametrize("high", [0.9, 0.1])
def test_what_pulls_a_bracket_to_a_column_does_not_tip_the_column(engine: str, first: bool, high: float) -> None:
    """A column of 6 kg, 1 m high and 0.2 m wide, tips about its edges as one body with the cube glued to its side."""
    floor = hf.Body("floor", hf.Box((2, 2, 0.1)), position=(0, 0, -0.05), fixed=True)
    column = hf.Body("column", hf.Box((0.2, 0.2, 1)), 6.0, position=(0, 0, 0.5))
    cube = hf.Body("cube", hf.Box((SIDE,) * 3), MASS, position=(0.15, 0, high))
    pair = [cube, column] if first else [column, cube]
    scene = hf.Scene([floor, *pair], hf.Friction(MU, tension={("cube", "column"): 2e5}))
    to_cube, away = (
        float(hf.robustness(scene, "column", (x, 0, 0.4), (-np.sign(x), 0, 0), engine=engine)) for x in (-0.1, 0.1)
    )
    assert to_cube == pytest.approx((6 * G * 0.1 - WEIGHT * 0.05) / 0.4, rel=1e-4)
    assert away == pytest.approx((6 * G * 0.1 + WEIGHT * 0.25) / 0.4, rel=1e-4)


@pytest.mark.parametrize("engine", ENGINES)
def test_a_plate_on_a_slope_slides_beyond_friction_and_cohesion(engine: str) -> None:
    along, pressing = WEIGHT * np.sin(np.radians(60)), WEIGHT * np.cos(np.radians(60))
    needed = (along - MU * pressing) / AREA  # cohesion [Pa]
    for cohesion in (None, needed):  # a tension alone has the cohesion μ tension
        for share, stands in ((1.001, True), (0.999, False)):
            tension = share * needed / MU if cohesion is None else 2 * needed / MU
            scene = on_slope(60, tension, None if cohesion is None else share * needed)
            assert hf.stability(scene, engine=engine).stable is stands


@pytest.mark.parametrize("engine", ENGINES)
def test_a_low_cohesion_closes_the_cone_before_the_tension(engine: str) -> None:
    """μ f_n + cohesion area is 0 at the pull cohesion area / μ."""
    cohesion = 2 * MU * WEIGHT / AREA
    pull = hf.robustness(hanging(9 * WEIGHT / AREA, cohesion=cohesion), "cube", (0, 0, -0.1), (0, 0, -1), engine=engine)
    assert float(pull) == pytest.approx(WEIGHT, rel=1e-6)


@pytest.mark.parametrize("engine", ENGINES)
def test_a_brick_that_hangs_by_half_of_its_studs_peels_by_its_own_weight(engine: str) -> None:
    """Its centre is below the edge of the studs: about their far end, weight l = tension (area) l / 2."""
    top = hf.Body("top", hf.Box((0.032, 0.016, 0.0096)), position=(0, 0, 0.0096), fixed=True)
    brick = hf.Body("brick", hf.Box((0.032, 0.016, 0.0096)), 0.0023, position=(0.016, 0, 0))
    critical = 2 * 0.0023 * G / (0.016 * 0.016)
    for share, stands in ((1.001, True), (0.999, False)):
        scene = hf.Scene([top, brick], hf.Friction(MU, tension={("top", "brick"): share * critical}))
        assert hf.stability(scene, engine=engine).stable is stands


@pytest.mark.parametrize("engine", ENGINES)
def test_a_bridge_of_studded_bricks_carries_what_its_row_of_studs_holds(engine: str) -> None:
    """Two bricks meet in the middle of the span, each on the studs of a pier, without friction where they meet.

    Each is a cantilever, with its centre over the edge of its pier. Loaded at its tip, it comes off about that edge,
    where its studs hold tension area at half of their length.
    """
    brick, tension = np.array([0.064, 0.016, 0.0096]), 2e4
    bodies = []
    for side, x in (("left", -1), ("right", 1)):
        bodies.append(hf.Body(f"pier {side}", hf.Box((0.032, 0.016, 0.0096)), position=(x * 0.048, 0, 0), fixed=True))
        bodies.append(hf.Body(side, hf.Box(brick), 0.0046, position=(x * 0.032, 0, 0.0096)))
    pairs = {("pier left", "left"): tension, ("pier right", "right"): tension}
    scene = hf.Scene(bodies, hf.Friction(0.0, tension=pairs))
    area, arm = 0.032 * 0.016, 0.032
    by_hand = tension * area * 0.016 / arm
    push = hf.robustness(scene, "left", (-1e-9, 0, 0.0144), (0, 0, -1), engine=engine)
    assert float(push) == pytest.approx(by_hand, rel=1e-5)


@pytest.mark.parametrize("engine", ENGINES)
def test_tape_over_the_flaps_of_a_carton_holds_its_lid_until_it_peels(engine: str) -> None:
    """A lid of 0.5 kg on a carton of 2 kg is lifted with it: the tape around all of it holds tension area."""
    floor = hf.Body("floor", hf.HalfSpace(), fixed=True)
    carton = hf.Body("carton", hf.Box((0.3, 0.2, 0.2)), 2.0, position=(0, 0, 0.1))
    lid = hf.Body("lid", hf.Box((0.3, 0.2, 0.02)), 0.5, position=(0, 0, 0.21))
    weak, strong = (hf.Friction(MU, tension={("carton", "lid"): pressure}) for pressure in (100.0, 1000.0))
    lifted = [
        hf.robustness(hf.Scene([floor, carton, lid], table), "lid", (0, 0, 0.22), (0, 0, 1), engine=engine)
        for table in (weak, strong)
    ]
    assert float(lifted[0]) == pytest.approx(0.5 * G + 100 * 0.06, rel=1e-6)
    assert lifted[0].moving[0] == ("lid",)
    assert float(lifted[1]) == pytest.approx(2.5 * G, rel=1e-6)
    assert set(lifted[1].moving[0]) == {"carton", "lid"}


@pytest.mark.parametrize("engine", ENGINES)
def test_without_tension_answers_are_todays_and_nothing_is_pulled(engine: str) -> None:
    plain = hf.Scene(on_slope(0, 0).bodies, MU)
    for table in (hf.Friction(MU, tension={("plate", "slope"): 0.0}), hf.Friction(MU, cohesion={})):
        scene = hf.Scene(plain.bodies, table)
        for way in ((1, 0, 0), (0, 1, 0.2)):
            asked = [hf.robustness(one, "plate", (0.05, 0, 0.005), way, engine=engine) for one in (plain, scene)]
            assert asked[0].force.tobytes() == asked[1].force.tobytes()
    assert hf.stability(hanging(0.0), engine=engine).status is hf.Status.UNSTABLE
    faint = hf.Scene(plain.bodies, hf.Friction(MU, tension={("plate", "slope"): 1e-6}))
    one, other = (hf.robustness(each, "plate", (-0.05, 0, 0.005), (1, 0, 0), engine=engine) for each in (plain, faint))
    assert float(one) == pytest.approx(float(other), rel=1e-6)


def test_an_uneven_face_is_pulled_at_its_centroid() -> None:
    """A glued triangle: about the edge against its right angle it holds tension area times a third of its height."""
    prism = hf.Mesh(
        np.array([(0, 0, 0), (0.1, 0, 0), (0, 0.1, 0), (0, 0, 0.05), (0.1, 0, 0.05), (0, 0.1, 0.05)]),
        np.array([(0, 2, 1), (3, 4, 5), (0, 1, 4), (0, 4, 3), (1, 2, 5), (1, 5, 4), (2, 0, 3), (2, 3, 5)]),
    )
    floor = hf.Body("floor", hf.Box((1, 1, 0.1)), position=(0, 0, -0.05), fixed=True)
    body = hf.Body("prism", prism, 0.001, com=(1 / 30, 1 / 30, 0.025))
    scene = hf.Scene([floor, body], hf.Friction(MU, tension={("floor", "prism"): 1e3}))
    area, weight = 0.005, 0.001 * G
    by_hand = (1e3 * area + weight) / 30 / 0.1  # lifted at the far corner, about the opposite edge x = 0
    for engine in ENGINES:
        lift = hf.robustness(scene, "prism", (0.1, 0, 0.05), (0, 0, 1), engine=engine)
        assert float(lift) == pytest.approx(by_hand, rel=1e-6)
    forces = hf.stability(scene, engine="limit").forces
    assert forces is not None
    assert forces.force.sum(axis=0) == pytest.approx([0, 0, weight], abs=1e-9)
    moment = np.cross(forces.points, forces.force).sum(axis=0)
    assert moment == pytest.approx(np.cross([1 / 30, 1 / 30, 0], [0, 0, weight]), abs=1e-9)


def test_derivatives_by_friction_keep_the_tension() -> None:
    def push(mu: float) -> float:
        table = hf.Friction(mu, tension={("paint", "tape"): 3 * WEIGHT / AREA})
        return float(
            hf.robustness(hf.Scene(hanging(1.0).bodies, table), "cube", (-0.05, 0, 0), (1, 0, 0), engine="limit")
        )

    found = sensitivity(hanging(3 * WEIGHT / AREA), "cube", (-0.05, 0, 0), (1, 0, 0))
    assert found.d_mu["ceiling", "cube"] == pytest.approx((push(MU + 1e-4) - push(MU - 1e-4)) / 2e-4, rel=1e-4)


@pytest.mark.parametrize(("place", "more"), [(0.0, 0.0), (0.016, 0.5), (0.032, 1.0)])
def test_glue_and_a_hand_hold_together(place: float, more: float) -> None:
    """A hand that lifts a glued cantilever with 1 N at ``place`` takes 1 N · place off its bending moment."""
    scene = replace(bracket(3e4), holds=[hf.Hold("brick", hf.pose(place, 0, 0), forces=(0, 0, (0, 1.0)))])
    bent = 3e4 * 0.016 * 0.0096 * 0.0048 - 0.02 * 9.81 * 0.016
    found = hf.robustness(scene, "brick", (0.032, 0, 0.0048), (0, 0, -1), engine="limit", bounds=True)
    assert float(found) == pytest.approx(bent / 0.032 + more, rel=1e-6)
    assert found.lower[0] <= float(found) <= found.upper[0]


@pytest.mark.parametrize("engine", ["limit", "compliant"])
def test_an_answer_that_leans_on_glue_across_a_gap_says_so(engine: str) -> None:
    """A block stands 5 mm beside a wall that it may be glued to: ``lower`` is without the glue, and a note names it."""
    floor = hf.Body("floor", hf.Box((3, 3, 0.1)), fixed=True, position=(0, 0, -0.05))
    wall = hf.Body("wall", hf.Box((0.1, 1, 1)), fixed=True, position=(-0.1, 0, 0.5))
    block = hf.Body("block", hf.Box((0.1, 0.1, 0.1)), mass=1.0, position=(0.005, 0, 0.05))
    scene = hf.Scene([floor, wall, block], hf.Friction(0.3, tension={("block", "wall"): 1e4}))
    found = hf.robustness(hf.assemble(scene, gap=0.01), "block", (0.055, 0, 0.02), (1, 0, 0), engine=engine)
    assert float(found) > 60
    assert 0.99 * 0.3 * 9.81 <= found.lower[0] <= 0.3 * 9.81 * (1 + 1e-6)
    assert any("may not exist" in note and "block-wall" in note for note in found.notes)
