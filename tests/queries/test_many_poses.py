"""Many poses in one call: the same answers as one by one, of all kinds of poses, bodies and scenes."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest

import holdfast as hf
from bench.scenes.cluttered_table import BODIES, Sampler, cluttered_table
from holdfast.base.errors import HoldfastWarning

OTHERS: dict[str, Callable[[], hf.Body]] = {
    "ball": lambda: hf.Body("it", hf.Sphere(0.04), mass=0.2),
    "bracket": lambda: hf.Body(
        "it",
        hf.Compound(
            [
                hf.Part(hf.Box((0.1, 0.1, 0.01)), pose=hf.pose(0, 0, 0.005)),
                hf.Part(hf.Box((0.01, 0.1, 0.06)), pose=hf.pose(0.045, 0, 0.04)),
            ]
        ),
        mass=0.2,
    ),
}


@pytest.fixture(autouse=True)
def _quiet() -> Iterator[None]:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", HoldfastWarning)
        yield


def scene(name: str, body: hf.Body) -> hf.Scene:
    table = cluttered_table(body)
    if name == "table":
        return table
    if name == "half space":
        floor = hf.Body("table", hf.HalfSpace(), fixed=True)
        return hf.Scene([floor, *table.bodies[1:]], 0.5)
    if name == "slope":  # of 6 degrees, on which everything holds
        return hf.Scene(
            [hf.Body("table", hf.Box((1.2, 0.8, 0.04)), fixed=True, pose=hf.pose(0, 0, -0.02, roll=6)), body], 0.5
        )
    if name == "slippery":
        return hf.Scene([table.bodies[0], body], 0.02)
    falling = hf.Body("falling", hf.Box((0.05, 0.05, 0.05)), mass=0.1, position=(0.2, -0.1, 0.3))
    return hf.Scene([*table.bodies, falling], 0.5)


def drawn(body: hf.Body, each: int, seed: int = 0) -> np.ndarray:
    """Poses of every kind, and some of any orientation near the table."""
    sampler = Sampler(body, seed)
    return np.array([draw() for draw in sampler.kinds().values() for _ in range(each)])


def assert_same(assembly: hf.answers.Assembly, poses: np.ndarray, **options: Any) -> hf.answers.StabilityOfPoses:
    found = hf.stability_of_poses(assembly, "it", poses, **options)
    for row, pose in enumerate(poses):
        one = hf.stability(assembly.moved({"it": pose}), **options)
        assert found.status[row] is one.status, (row, one.reason, found.reason[row])
        assert found.moving[row] == (one.moving if one.status is hf.Status.UNSTABLE else ()), row
    return found


@pytest.mark.parametrize(("each", "seed"), [(3, 0), *(pytest.param(10, k, marks=pytest.mark.slow) for k in (10, 11))])
@pytest.mark.parametrize("name", [*BODIES, *OTHERS])
def test_the_answers_are_those_of_single_calls(name: str, each: int, seed: int) -> None:
    body = (BODIES | OTHERS)[name]()
    found = assert_same(hf.assemble(scene("table", body)), drawn(body, each, seed))
    assert {hf.Status.STABLE, hf.Status.UNSTABLE, hf.Status.UNDECIDED} == set(found.status)


@pytest.mark.parametrize("name", ["half space", "slope", "slippery", "one falls"])
def test_so_they_are_in_other_scenes(name: str) -> None:
    body = BODIES["cup"]()
    poses = drawn(body, 2, seed=1)
    if name == "slope":
        poses = hf.pose(roll=6) @ poses
    assert_same(hf.assemble(scene(name, body)), poses)


@pytest.mark.parametrize("engine", ["limit", "graph", hf.Compliant(nodes=5)])
def test_so_they_are_by_other_engines(engine: Any) -> None:
    body = BODIES["box"]()
    assert_same(hf.assemble(scene("table", body)), drawn(body, 3, seed=2), engine=engine)


def test_the_centre_of_mass_at_the_edge_decides() -> None:
    body = BODIES["cup"]()
    assembly = hf.assemble(scene("table", body))
    beyond = np.array([-0.02, -1e-3, -3e-4, -1e-5, 1e-5, 3e-4, 1e-3, 0.02])
    poses = np.array([hf.pose(0.6 + x, 0.1, 0.05, yaw=40 * k) for k, x in enumerate(beyond)])
    found = assert_same(assembly, poses)
    assert (found.stable == (beyond < 0)).all()


@pytest.mark.parametrize("engine", ["compliant", "limit"])
@pytest.mark.parametrize(("roll", "yaw"), [(6, 0), (-6, 0), (6, 90), (-6, 200)])
def test_on_a_slope_the_weight_acts_below_the_centre_of_mass(roll: float, yaw: float, engine: str) -> None:
    """A cylinder of 0.1 m tips over the lower edge where its foot is less than 0.05 m tan 6° = 5.3 mm from it."""
    board = hf.Body("board", hf.Box((1.2, 0.8, 0.04)), fixed=True, pose=hf.pose(0, 0, -0.02))
    turned = hf.pose(0.3, 0.1, 0, yaw=yaw) @ hf.pose(roll=roll)
    slope = hf.Scene([board.moved(turned @ board.pose), BODIES["cup"]()], 0.8)
    down = -np.sign(roll)  # along y of the board
    from_lower = np.array([0.003, 0.0045, 0.0062, 0.008])
    places = [*(down * (0.4 - from_lower)), *(-down * (0.4 - from_lower))]
    poses = np.array([turned @ hf.pose(0.1 * k - 0.4, y, 0.05) for k, y in enumerate(places)])
    found = hf.stability_of_poses(slope, "it", poses, engine=engine)
    assert found.stable.tolist() == [False, False, True, True] + [True] * 4


def test_a_body_on_another_one_counts_with_it() -> None:
    """A plank over the table's edge carries the cup, unless that stands too far out."""
    body = BODIES["cup"]()
    plank = hf.Body("plank", hf.Box((0.4, 0.1, 0.02)), mass=0.1, position=(0.5, 0, 0.01))
    table = scene("table", body).bodies[0]
    assembly = hf.assemble(hf.Scene([table, plank, body], 0.5))
    poses = np.array([hf.pose(x, 0, 0.07) for x in (0.4, 0.5, 0.58, 0.62, 0.66, 0.69, 0.72)])
    found = assert_same(assembly, poses)
    assert [str(status) for status in found.status[:4]] == ["stable"] * 4
    assert "plank" in found.moving[4]


def test_reasons_name_what_is_in_the_way() -> None:
    body = BODIES["cup"]()
    assembly = hf.assemble(scene("table", body))
    poses = np.array([hf.pose(0.22, -0.05, z) for z in (0.05, 0.3, 0.02, 0.055)])
    found = hf.stability_of_poses(assembly, "it", poses)
    assert [str(status) for status in found.status] == ["stable", "unstable", "undecided", "undecided"]
    assert found.reason[0] == hf.stability(assembly.moved({"it": poses[0]})).reason
    assert "unsupported: it: no chain of contacts leads to a fixed body" in found.reason[1]
    assert "table and it overlap by more than their tolerance of 0.18 mm" in found.reason[2]
    assert "table is within reach below and it would rest there" in found.reason[3]


def test_several_bodies_move_together() -> None:
    body = BODIES["cup"]()
    assembly = hf.assemble(scene("table", body))
    rng = np.random.default_rng(0)
    places = rng.uniform((-0.5, -0.3), (0.5, 0.3), (12, 2, 2))
    places[:4, 1] = places[:4, 0] + rng.uniform(-0.05, 0.05, (4, 2))  # near each other
    poses = np.array([[hf.pose(*a, 0.05), hf.pose(*b, 0.025)] for a, b in places])
    poses[8:, 1] = [hf.pose(*a, 0.125) for a, _ in places[8:]]  # the block on the cup
    found = hf.stability_of_poses(assembly, ["it", "block"], poses)
    by_name = hf.stability_of_poses(assembly, ["it", "block"], {"block": poses[:, 1], "it": poses[:, 0]})
    for row, (cup, block) in enumerate(poses):
        one = hf.stability(assembly.moved({"it": cup, "block": block}))
        assert found.status[row] is one.status is by_name.status[row]
    assert found.bodies == ("it", "block")
    assert found.poses.shape == (12, 2, 4, 4)


def test_a_fixed_body_may_be_moved() -> None:
    body = BODIES["cup"]()
    assembly = hf.assemble(scene("table", body).moved({"it": hf.pose(0.22, -0.05, 0.05)}))
    poses = np.array([hf.pose(0, 0, z) for z in (-0.02, -0.0199, -0.05, -0.2)])
    found = hf.stability_of_poses(assembly, "table", poses)
    for row, pose in enumerate(poses):
        assert found.status[row] is hf.stability(assembly.moved({"table": pose})).status


def test_an_excluded_pair_never_touches() -> None:
    body = BODIES["cup"]()
    table = scene("table", body)
    assembly = hf.assemble(hf.Scene(table.bodies, 0.5, excluded=[("book", "it")]))
    poses = np.array([hf.pose(-0.35, -0.2, z) for z in (0.05, 0.08, 0.02)])
    assert_same(assembly, poses)


def test_single_answers_and_margins_are_there_until_the_answer_is_saved(tmp_path: Any) -> None:
    assembly = hf.assemble(scene("slippery", BODIES["cup"]()))
    poses = np.array([hf.pose(0.22, -0.05, 0.05), hf.pose(0.22, -0.05, 0.5)])
    found = hf.stability_of_poses(assembly, "it", poses)
    assert [one.status for one in found] == list(found.status)
    assert found[-1].moving == ("it",)
    assert found.margin[0] == found[0].margin > 0
    assert found.margin[1] == 0
    with pytest.raises(IndexError):
        found[2]
    found.save(tmp_path / "poses.npz")
    read = hf.load_answer(tmp_path / "poses.npz")
    assert read == found
    assert read.to_dict() == found.to_dict()
    with pytest.raises(hf.HoldfastError, match="was lost when the answer was saved"):
        read[0]


def test_the_answer_does_not_depend_on_the_other_poses() -> None:
    body = BODIES["box"]()
    assembly = hf.assemble(scene("table", body))
    poses = drawn(body, 2, seed=4)
    whole = hf.stability_of_poses(assembly, "it", poses)
    again = hf.stability_of_poses(assembly, "it", poses[::-1])
    assert (whole.status == again.status[::-1]).all()
    assert [hf.stability_of_poses(assembly, "it", pose[None]).status[0] for pose in poses] == list(whole.status)


@pytest.mark.parametrize("bounds", [False, True])
def test_pushes_are_those_of_single_calls(bounds: bool) -> None:
    body = BODIES["cup"]()
    assembly = hf.assemble(scene("table", body))
    poses = drawn(body, 2, seed=3)
    points = poses[:, :3, :3] @ (0.035, 0, 0.03) + poses[:, :3, 3]
    directions = -poses[:, :3, 0]
    found = hf.robustness_of_poses(assembly, "it", poses, points, directions, bounds=bounds)
    assert found.body == "it"
    for row, pose in enumerate(poses):
        one = hf.robustness(assembly.moved({"it": pose}), "it", points[row], directions[row], bounds=bounds)
        assert found.status[row] is one.status[0], row
        for name in ("force", "lower", "upper"):
            assert getattr(found, name)[row] == getattr(one, name)[0], (row, name)
        if one.status[0] is hf.Status.FINITE:
            assert (found.moving[row], found.mode[row]) == (one.moving[0], one.mode[0])


def test_a_push_on_a_body_that_is_not_moved() -> None:
    body = BODIES["cup"]()
    assembly = hf.assemble(scene("table", body))
    poses = np.array([hf.pose(0.22, -0.05, 0.05), hf.pose(-0.35, -0.2, 0.08), hf.pose(0.22, -0.05, 0.5)])
    point, direction = (-0.45, -0.2, 0.02), (1, 0, 0)
    found = hf.robustness_of_poses(assembly, "it", poses, point, direction, body="book")
    single = [hf.robustness(assembly.moved({"it": pose}), "book", point, direction) for pose in poses]
    np.testing.assert_array_equal(found.force, [one.force[0] for one in single])
    assert found.force[1] > found.force[0]  # the cup weighs on it
    fixed = hf.robustness_of_poses(assembly, "it", poses, (0.6, 0, -0.01), (-1, 0, 0), body="table")
    assert set(fixed.status) == {hf.Status.INFINITE}


@pytest.mark.parametrize(
    ("bodies", "poses", "match"),
    [
        ("cap", np.eye(4)[None], "cap"),
        ("it", np.eye(4), r"poses: has shape \(4, 4\)"),
        ("it", 2 * np.eye(4)[None], r"poses\[0\]"),
        ("it", np.array([np.eye(4), np.diag([1, 1, -1, 1.0])]), r"poses\[1\]: is a reflection"),
        (["it", "it"], np.zeros((2, 2, 4, 4)), "each once"),
        (["it", "book"], {"it": np.eye(4)[None]}, "needs those of"),
        (["it", "book"], {"it": np.eye(4)[None], "book": np.stack([np.eye(4)] * 2)}, "differ in number"),
    ],
)
def test_wrong_arguments_are_refused(bodies: Any, poses: Any, match: str) -> None:
    assembly = hf.assemble(scene("table", BODIES["cup"]()))
    with pytest.raises(hf.HoldfastError, match=match):
        hf.stability_of_poses(assembly, bodies, poses)


def test_wrong_pushes_are_refused() -> None:
    assembly = hf.assemble(scene("table", BODIES["cup"]()))
    poses = np.array([hf.pose(0.22, -0.05, 0.05)] * 3)
    with pytest.raises(hf.errors.SceneError, match="at pose 0 its point is 50 mm from the surface"):
        hf.robustness_of_poses(assembly, "it", poses, (0.22, -0.05, 0.15), (1, 0, 0))
    with pytest.raises(hf.errors.SceneError, match="2 pushes at 3 poses"):
        hf.robustness_of_poses(assembly, "it", poses, np.zeros((2, 3)), (1, 0, 0))
    with pytest.raises(hf.errors.SceneError, match="say which is pushed"):
        hf.robustness_of_poses(assembly, ["it", "book"], np.stack([poses, poses], 1), (0, 0, 0), (1, 0, 0))
    given = hf.assemble(assembly.scene, interfaces=assembly.interfaces)
    with pytest.raises(hf.HoldfastError, match="interfaces were given"):
        hf.stability_of_poses(given, "it", poses)
