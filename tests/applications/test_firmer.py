"""Bodies moved to where they are firmer: closed forms, limits that are kept, and never weaker than before."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

import holdfast as hf
from holdfast.applications.pushing.firmer import Climb, Firmness, firmer_than
from holdfast.base.values import Table
from holdfast.scene.shipped.blocks import at, box, floor

G = 9.81
PUSH = [hf.Load("cube", (0.07, 0.01, 0.3), force=(-1, 0, 0)), hf.Load("cube", (-0.03, 0, 0.3), force=(1, 0, 0))]


def on_a_column(x: float, y: float = 0.0, *others: hf.Body) -> hf.Scene:
    """A cube of 1 kg and 0.1 m on a fixed column as wide, off its middle by (x, y) [m]."""
    column = hf.Body("column", hf.Box((0.1, 0.1, 0.2)), pose=at(0, 0, 0.1), fixed=True)
    return hf.Scene([column, box("cube", (0.1, 0.1, 0.1), 1, (x, y, 0.25)), *others], 1.2)


def shelf(*others: hf.Body) -> hf.Scene:
    board = hf.Body("board", hf.Box((0.6, 0.3, 0.02)), pose=at(0, 0, -0.01), fixed=True)
    return hf.Scene([board, *others], 0.5)


@pytest.mark.parametrize("engine", ["limit", "compliant"])
def test_a_cube_off_the_middle_of_a_column_comes_back(engine: str) -> None:
    """A push at its upper edge tips it: m g times what is left of half its side over its height, m g / 2 at most."""
    edge = [hf.Load("cube", (0.05 * s + 0.02, 0, 0.3), force=(-s, 0, 0)) for s in (-1, 1)]
    moves = hf.sets.Moves(turn_degrees=0)
    found = hf.firmer(on_a_column(0.02), "cube", pushes=edge, moves=moves, engine=engine)
    assert found.before == pytest.approx(G * 0.03 / 0.1, rel=0.02)
    assert found.after == pytest.approx(G * 0.05 / 0.1, rel=0.05)
    assert found.answers.force.min() == pytest.approx(G * 0.05 / 0.1, rel=0.02)
    assert abs(found.assembly.com[0, 0]) < 0.002
    shift, _ = found.shifts["cube"]
    assert 0.018 < shift < 0.03
    again = hf.robustness(
        found.assembly, "cube", found.poses["cube"][:3, 3] + (0.05, 0, 0.05), (-1, 0, 0), engine=engine
    )
    assert again.lower[0] >= found.after * (1 - 1e-9)


def test_all_over_the_cube_nothing_is_weaker_and_every_step_is_firmer() -> None:
    found = hf.firmer(on_a_column(0.015, -0.02), "cube", engine="limit")
    least = [step.least["cube"] for step in found]
    assert len(found) > 1
    assert all(b > a for a, b in pairwise(least))
    assert found.after == pytest.approx(found[-1].answers.lower.min())
    assert found.after > 1.25 * found.before
    assert "moved cube by" in str(found)


@pytest.mark.parametrize(("offset", "yaw"), [(0.02, 20), (-0.015, 35)])
def test_smaller_errors_are_no_gain(offset: float, yaw: float) -> None:
    """A tall block wholly on its base tips about its own edge: m g 0.04 / 0.27 = 1.4533 N wherever it stands.

    Only how far `lower` is below that depends on where the nodes of its face are.
    """
    base = hf.Body("base", hf.Box((0.14, 0.14, 0.1)), pose=at(0, 0, 0.05), fixed=True)
    pose = hf.pose(offset, 0, 0.24, yaw=yaw)
    top = hf.Body("top", hf.Box((0.08, 0.08, 0.28)), mass=1.0, pose=pose)
    push = hf.Load("top", pose[:3, :3] @ (0.04, 0, 0.13) + pose[:3, 3], force=pose[:3, :3] @ (-1, 0, 0))
    found = hf.firmer(hf.Scene([base, top], 0.8), "top", pushes=[push], seconds=20)
    assert found.answers.force[0] == pytest.approx(G * 0.04 / 0.27, rel=0.01)
    assert found.shifts["top"] == (0.0, 0.0)
    assert "nothing was moved" in str(found)


def firmness(*values: tuple[float, float]) -> Firmness:
    """What is promised of some bodies, and the force that is known."""
    names = [f"b{k}" for k in range(len(values))]
    least, most = (Table(dict(zip(names, column, strict=True))) for column in zip(*values, strict=True))
    return Firmness(least, most, (), None)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("now", "before", "gain", "certain"),
    [
        ([(1.46, 1.465)], [(1.40, 1.465)], False, False),  # an error that has become smaller
        ([(1.40, 1.60)], [(1.40, 1.465)], False, False),  # one that has become larger
        ([(1.45, 1.52)], [(1.40, 1.465)], True, False),
        ([(1.50, 1.52)], [(1.40, 1.465)], True, True),
        ([(1.40, 1.465), (3.0, 3.1)], [(1.40, 1.465), (2.0, 2.1)], True, True),  # where the weakest is as weak
        ([(1.30, 1.33), (3.0, 3.1)], [(1.40, 1.465), (2.0, 2.1)], False, False),
        ([(5.0, 5.1)], [(0.0, np.inf)], False, False),  # it was undecided, so that no gain is known
        ([(5.0, 5.1)], [(0.0, 0.0)], True, True),  # it was only balanced
        ([(np.inf, np.inf)], [(5.0, 5.1)], True, True),
        ([(np.inf, np.inf)], [(np.inf, np.inf)], False, False),
    ],
)
def test_what_counts_as_firmer(
    now: list[tuple[float, float]], before: list[tuple[float, float]], gain: bool, certain: bool
) -> None:
    assert firmer_than(firmness(*now), firmness(*before)) is gain
    assert firmer_than(firmness(*now), firmness(*before), certainly=True) is certain


@pytest.mark.parametrize(
    ("other", "ahead"),
    [((2.0, 2.1), True), ((2.5, 2.6), True), ((1.9, 2.1), False), ((2.0, 1.9), False)],
    ids=["kept", "firmer", "less promised", "less force"],
)
def test_the_weakest_becomes_firmer_at_the_cost_of_no_other(other: tuple[float, float], ahead: bool) -> None:
    climb = object.__new__(Climb)
    climb.path = [(None, firmness((1.40, 1.465), (2.0, 2.1)))]  # type: ignore[list-item]
    assert climb.ahead(firmness((1.50, 1.52), other), climb.path[0][1]) is ahead


@pytest.mark.filterwarnings("ignore::holdfast.errors.HoldfastWarning")
def test_of_an_undecided_scene_nothing_is_known_to_be_firmer() -> None:
    """The cube is 3 mm inside its neighbour, so that what they carry there is not known."""
    pair = [box(name, (0.1, 0.1, 0.1), 1, (x, 0, 0.05)) for name, x in (("cube", 0), ("other", 0.097))]
    found = hf.firmer(shelf(*pair), "cube", engine="limit", seconds=20)
    assert found.shifts["cube"] == (0.0, 0.0)
    assert "cube" in found[0].undecided
    text = str(found)
    assert "undecided" in text
    assert "overlap by 3 mm" in text
    assert "0 N" not in text


def test_where_all_places_are_as_firm_nothing_is_moved() -> None:
    found = hf.firmer(shelf(box("cube", (0.1, 0.1, 0.1), 1, (0.1, 0, 0.05))), "cube", engine="limit")
    assert len(found) == 1
    assert found.before == found.after
    assert "nothing was moved" in str(found)
    assert found.shifts["cube"] == (0.0, 0.0)


@pytest.mark.parametrize(
    ("moves", "far"),
    [(hf.sets.Moves(slide=0.01), 0.01), (hf.sets.Moves(slide=0.0, turn_degrees=30), 0.0)],
    ids=["slide", "turn"],
)
def test_limits_are_kept(moves: hf.sets.Moves, far: float) -> None:
    found = hf.firmer(on_a_column(0.03, 0.01), "cube", moves=moves, engine="limit")
    shift, turn = found.shifts["cube"]
    assert shift <= far + 1e-6
    assert turn <= moves.turn_degrees + 1e-6
    assert found.after >= found.before


@pytest.mark.parametrize(("apart", "nearest"), [(0.005, 0.005), (0.0, 0.0)])
def test_it_keeps_away_from_others_and_touches_nothing_new(apart: float, nearest: float) -> None:
    """A fixed post stands 10 mm from the cube, which should move 20 mm towards it."""
    post = hf.Body("post", hf.Box((0.02, 0.1, 0.4)), pose=at(-0.05, 0, 0.2), fixed=True)
    scene = on_a_column(0.02, 0, post)
    found = hf.firmer(scene, "cube", moves=hf.sets.Moves(apart=apart), engine="limit")
    left = found.poses["cube"][0, 3] - 0.05 - (-0.04)
    assert nearest - 1e-6 <= left < 0.01
    assert {frozenset(i.bodies) for i in found.assembly.interfaces} == {frozenset({"column", "cube"})}


def test_it_stays_on_all_that_it_stands_on() -> None:
    """On a column and 10 mm of a post that bears little: off the post it would be firmer, but it leaves no support."""
    post = hf.Body("post", hf.Box((0.02, 0.1, 0.2)), pose=at(0.07, 0, 0.1), fixed=True, top_load=8)
    push = hf.Load("cube", (0.065, 0, 0.3), force=(0, 0, -1))
    moves = hf.sets.Moves(turn_degrees=0, slide=0.06, nearer_edges=True)
    found = hf.firmer(on_a_column(0.02, 0, post), "cube", pushes=[push], moves=moves, engine="limit")
    assert found.after > 2 * found.before
    assert -0.01 < found.poses["cube"][0, 3] - 0.02 < 0
    assert len(found.assembly.interfaces) == 2


def test_it_comes_no_nearer_to_an_edge_unless_asked() -> None:
    """A cube on a tile on a board that bends over a bar would balance the board better nearer to the tile's edge."""
    bar = hf.Body("bar", hf.Box((0.1, 0.3, 0.1)), pose=at(0, 0, -0.05), fixed=True)
    board = box("board", (0.6, 0.3, 0.02), 1, (0.04, 0, 0.01))
    scene = hf.Scene([bar, board, box("cube", (0.1, 0.1, 0.1), 1, (-0.19, 0.05, 0.07))], 0.6)
    before = 0.3 - 0.04 - 0.19 - 0.05
    kept = hf.firmer(scene, "cube", engine="limit")
    free = hf.firmer(scene, "cube", moves=hf.sets.Moves(nearer_edges=True), engine="limit")

    def edge(found: hf.answers.Firmer) -> float:
        x, y = found.poses["cube"][:2, 3]
        return float(min(0.3 - 0.04 + x - 0.05, 0.15 - abs(y) - 0.05))

    assert edge(kept) >= before - 1e-5
    assert free.after >= kept.after * 0.99


def test_what_stands_on_a_body_moves_along() -> None:
    cup = box("cup", (0.04, 0.04, 0.06), 0.2, (0.03, 0.01, 0.33))
    found = hf.firmer(on_a_column(0.025, 0, cup), "cube", engine="limit", moves=hf.sets.Moves(turn_degrees=0))
    assert set(found.poses) == {"cube", "cup"}
    first = np.linalg.inv(found[0].poses["cube"]) @ found[0].poses["cup"]
    last = np.linalg.inv(found.poses["cube"]) @ found.poses["cup"]
    np.testing.assert_allclose(first, last, atol=1e-12)
    assert found[-1].least["cube"] > found[0].least["cube"]


def test_what_leans_on_a_body_is_not_left_to_fall() -> None:
    """A book stands on a step and leans on the cube, which would slide away from it."""
    lean = np.radians(15)
    up, out = np.array([-np.sin(lean), 0, np.cos(lean)]), np.array([np.cos(lean), 0, np.sin(lean)])
    pose = np.eye(4)
    pose[:3, :3] = np.column_stack([out, [0, 1, 0], up])
    pose[:3, 3] = (0.08, 0, 0.2) - (0.045 * up - 0.005 * out) * (1, 0, 0) + (0.045 * up + 0.005 * out) * (0, 0, 1)
    book = hf.Body("book", hf.Box((0.01, 0.08, 0.09)), mass=0.1, pose=pose)
    step = hf.Body("step", hf.Box((0.2, 0.2, 0.2)), pose=at(0.19, 0, 0.1), fixed=True)
    scene = on_a_column(0.03, 0, step, book)
    assert hf.stability(scene, engine="limit").stable
    for pushes in (None, [hf.Load("cube", (0.08, 0, 0.3), force=(-1, 0, 0))]):
        found = hf.firmer(scene, "cube", pushes=pushes, engine="limit")
        assert hf.stability(found.assembly, engine="limit").stable
    assert "book" in hf.firmer(scene, "cube", engine="limit", seconds=1e-9)[0].least


def test_all_bodies_under_what_moves_along_are_watched() -> None:
    legs = [box(name, (0.1, 0.1, 0.1), 1, (x, 0, 0.05)) for name, x in (("left", -0.12), ("right", 0.12))]
    found = hf.firmer(
        shelf(*legs, box("bridge", (0.34, 0.1, 0.02), 0.5, (0, 0, 0.11))), "left", engine="limit", seconds=1e-9
    )
    assert set(found[0].least) == {"left", "right", "bridge"}


def test_what_a_body_may_bear_counts() -> None:
    scene = on_a_column(0.0)
    column = replace(scene.body("column"), top_load=12.0)
    scene = replace(scene, bodies=(column, scene.body("cube")))
    push = hf.Load("cube", (0.0, 0, 0.3), force=(0, 0, -1))
    found = hf.firmer(scene, "cube", pushes=[push], engine="limit")
    np.testing.assert_allclose(found.answers.force, 12 - G, rtol=1e-4)


def test_a_motion_becomes_less_critical() -> None:
    """Braking at 0.2 g: a cube on a column tips at (half of what is left) / (half its height) g."""
    times = [[0, -0.2 * G, 0, 0], [1, -0.2 * G, 0, 0]]
    found = hf.firmer(on_a_column(0.03), "cube", motion=times, engine="limit")
    assert found.before == pytest.approx(0.02 / 0.05 / 0.2, rel=1e-6)
    assert found.after > 1.5 * found.before
    assert "times" in str(found)


def test_it_saves_and_two_runs_agree_to_the_last_digit(tmp_path: Path) -> None:
    found = hf.firmer(on_a_column(0.02), "cube", engine="limit", pushes=PUSH)
    found.save(tmp_path / "f.json")
    assert hf.load_answer(tmp_path / "f.json") == found
    assert hf.firmer(on_a_column(0.02), "cube", engine="limit", pushes=PUSH) == found


def test_what_cannot_be_moved_is_refused() -> None:
    scene = on_a_column(0.02)
    with pytest.raises(hf.errors.SceneError, match="firmer: 'column': is fixed"):
        hf.firmer(scene, "column")
    with pytest.raises(hf.errors.SceneError, match="cub"):
        hf.firmer(scene, "cub")
    with pytest.raises(hf.errors.SceneError, match="stands on nothing"):
        hf.firmer(hf.Scene([floor(), box("cube", (0.1, 0.1, 0.1), 1, (0, 0, 1))], 0.5), "cube")
    with pytest.raises(hf.HoldfastError, match="pushes and a motion"):
        hf.firmer(scene, "cube", pushes=[hf.Load("cube", (0.07, 0, 0.25), force=(-1, 0, 0))], motion="DIN-EN-12195")
    with pytest.raises(hf.errors.SceneError, match="needs holdfast\\.sets\\.Moves"):
        hf.firmer(scene, "cube", moves=0.1)  # type: ignore[arg-type]
    with pytest.raises(hf.errors.SceneError, match="is empty"):
        hf.firmer(scene, "cube", pushes=[])
    with pytest.raises(hf.errors.SceneError, match="no force on a movable body"):
        hf.firmer(scene, "cube", pushes=[hf.Load("column", (0, 0, 0), force=(1, 0, 0))])
