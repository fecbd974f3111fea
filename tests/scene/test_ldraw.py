"""LDraw models: places, turns, submodels, what studs hold, and what is wrong with a file."""

from __future__ import annotations

import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scene_content import Load, loading

import holdfast as hf
from holdfast.cli.main import run

G, PITCH, WIDE_STUD = 9.81, 8e-3, 1.7
NUMBER = {
    (1, 1): "3005",
    (1, 2): "3004",
    (1, 4): "3010",
    (1, 6): "3009",
    (1, 8): "3008",
    (2, 2): "3003",
    (2, 4): "3001",
}
STRAIGHT, QUARTER = "1 0 0 0 1 0 0 0 1", "0 0 1 0 1 0 -1 0 0"
BASE = f"1 2 480 0 0 {STRAIGHT} 4186.dat\n"  # 48 x 48 studs, which begin at x = 0
load = loading("model.ldr")


def placed(x: int, layer: int, wide: int, deep: int, turn: str = STRAIGHT) -> str:
    """A brick whose studs begin at the stud ``x`` of the base, in a layer from 0."""
    along, across = (deep, wide) if turn == QUARTER else (wide, deep)
    return f"1 4 {20 * x + 10 * along} {-24 * (layer + 1)} {10 * across} {turn} {NUMBER[deep, wide]}.dat\n"


def model(bricks: Iterable[tuple[int, int, int, int]]) -> str:
    return "0 Untitled\n" + BASE + "".join(placed(*brick) for brick in bricks)


def test_a_brick_on_a_baseplate_is_where_ldraw_has_it(load: Load) -> None:
    scene = load(BASE + f"0 STEP\n1 4 40 -24 60 {STRAIGHT} 3001.dat\n1 4 60 -24 -60 {QUARTER} 3001P01.DAT\n")
    assert {body.name: body.fixed for body in scene.bodies} == {
        "baseplate 48x48": True,
        "brick 2x4": False,
        "brick 2x4 (2)": False,
    }
    np.testing.assert_allclose(scene.body("brick 2x4").box, ((0, 0.016, 0), (0.032, 0.032, 0.0096)), atol=1e-12)
    np.testing.assert_allclose(
        scene.body("brick 2x4 (2)").box, ((0.016, -0.04, 0), (0.032, -0.008, 0.0096)), atol=1e-12
    )
    np.testing.assert_allclose(scene.body("baseplate 48x48").box, ((0, -0.192, -0.0016), (0.384, 0.192, 0)), atol=1e-12)


def test_what_was_taken_is_said(load: Load) -> None:
    scene = load(model([(0, 0, 4, 2), (2, 1, 4, 2)]))
    assert scene.notes == (
        "studs hold 2 pairs of parts, each stud 1.7 N, 2.85 N below parts one stud wide",
        "friction of parts is taken as 0.3",
        "masses are taken as those of hollow bricks of ABS",
    )
    assert scene.mu("brick 2x4", "brick 2x4 (2)") == 0.3
    said = load(model([(0, 0, 4, 2)]), friction=hf.Friction(0.5), density=570, stud=1)
    assert said.notes == ("studs hold 1 pairs of parts, each stud 1 N, 1 N below parts one stud wide",)
    assert said.friction.tension == {("baseplate 48x48", "brick 2x4"): pytest.approx(1 / PITCH**2)}
    assert said.body("brick 2x4").mass == pytest.approx(570 * 0.032 * 0.016 * 0.0096)


def test_without_a_baseplate_the_model_stands_on_a_floor(load: Load) -> None:
    brick = f"1 4 0 0 0 {STRAIGHT} 3001.dat\n"
    scene = load(brick)
    assert scene.body("brick 2x4").box[0][2] == pytest.approx(0)
    assert "raised by 0.0096 m, so that the lowest point is on the floor" in scene.notes[-1]
    assert hf.stability(scene).stable
    assert not load(brick, fixed=["brick 2x4"]).movable
    lift = float(hf.robustness(scene, "brick 2x4", (0, 0, 0.0096), (0, 0, 1)))
    assert lift == pytest.approx(G * scene.body("brick 2x4").mass, rel=1e-6)  # no stud is in the floor


def test_submodels_are_placed_in_each_other_and_mirrors_and_colours_do_not_matter(load: Load) -> None:
    mirror = "-1 0 0 0 1 0 0 0 1"
    text = (
        f"0 FILE Main.ldr\n{BASE}1 4 100 0 20 {QUARTER} Two Bricks.LDR\n0 NOFILE\n1 nothing\n"
        f"0 FILE two bricks.ldr\n1 16 0 -24 0 {mirror} 3001.dat\n0 STEP\n1 0 20 -48 0 {STRAIGHT} one\\more.ldr\n"
        f"0 FILE one/more.ldr\n1 14 0 0 0 {STRAIGHT} 3003.dat\n"
    )
    scene = load(text)
    # x of the submodel is -z of the model, and z is y of the scene
    np.testing.assert_allclose(scene.body("brick 2x4").box, ((0.032, -0.008, 0), (0.048, 0.024, 0.0096)), atol=1e-12)
    np.testing.assert_allclose(
        scene.body("brick 2x2").box, ((0.032, -0.008, 0.0096), (0.048, 0.008, 0.0192)), atol=1e-12
    )
    assert len(scene.friction.tension) == 2


@pytest.mark.parametrize("engine", ["limit", "compliant"])
@pytest.mark.parametrize("over", [1, 2, 3])
def test_a_cantilever_holds_until_its_studs_give(over: int, engine: str, load: Load) -> None:
    """A 2 x 4 brick over the end of one below: about that end, its studs hold F (1/2 + 3/2 + ...) pitch, two a row."""
    scene = load(model([(0, 0, 4, 2), (over, 1, 4, 2)]), stud=WIDE_STUD)
    name, rows = "brick 2x4 (2)", 4 - over
    weight, arm = scene.body(name).mass * G, over * PITCH
    by_hand = (2 * WIDE_STUD * rows**2 / 2 * PITCH + weight * (2 - over) * PITCH) / arm
    tip = (4 + over) * PITCH
    push = hf.robustness(scene, name, (tip, 0.008, 0.0192), (0, 0, -1), engine=engine)
    assert float(push) == pytest.approx(by_hand, rel=1e-6)
    heavier = {name: (2 * WIDE_STUD * rows**2 / 2) / (over - 2) / G} if over > 2 else {}
    for share, stands in ((0.999, True), (1.001, False)) if heavier else ():
        scene = load(model([(0, 0, 4, 2), (over, 1, 4, 2)]), stud=WIDE_STUD, mass={name: share * heavier[name]})
        assert hf.stability(scene, engine=engine).stable is stands


@pytest.mark.parametrize("engine", ["limit", "compliant"])
@pytest.mark.parametrize(("wide", "deep", "pull"), [(4, 2, 8 * 1.7), (4, 1, 4 * 2.85), (2, 2, 4 * 1.7), (1, 1, 2.85)])
def test_a_brick_is_pulled_off_with_the_force_of_its_studs(
    wide: int, deep: int, pull: float, engine: str, load: Load
) -> None:
    scene = load(model([(0, 0, 4, 2), (10, 0, 8, 1), (30, 0, wide, deep)]))
    name = scene.bodies[-1].name
    low, high = scene.body(name).box
    by_hand = pull + scene.body(name).mass * G
    found = hf.robustness(scene, name, (*(low + high)[:2] / 2, high[2]), (0, 0, 1), engine=engine)
    assert float(found) == pytest.approx(by_hand, rel=1e-6)


TURNED = "0.707107 0 0.707107 0 1 0 -0.707107 0 0.707107"
OVER = "1 0 0 0 -1 0 0 0 -1"


@pytest.mark.parametrize(
    ("bricks", "pairs"),
    [
        (f"1 4 0 0 0 {STRAIGHT} 3001.dat\n1 4 80 0 0 {STRAIGHT} 3001.dat\n", 0),  # side by side
        (f"1 4 0 0 0 {STRAIGHT} 3001.dat\n1 4 0 24 0 {STRAIGHT} 3001.dat\n", 1),  # the first above the second
        (f"1 4 0 0 0 {STRAIGHT} 3001.dat\n1 4 10 24 0 {STRAIGHT} 3001.dat\n", 0),  # half a stud aside
        (f"1 4 0 0 0 {STRAIGHT} 3001.dat\n1 4 0 26 0 {STRAIGHT} 3001.dat\n", 0),  # 0.8 mm above
        (f"1 4 0 0 0 {STRAIGHT} 3068b.dat\n1 4 0 8 0 {STRAIGHT} 3022.dat\n", 1),  # a tile on a plate
        (f"1 4 0 0 0 {STRAIGHT} 3022.dat\n1 4 0 8 0 {STRAIGHT} 3068b.dat\n", 0),  # a plate on a tile
        (f"1 4 0 0 0 {STRAIGHT} 3001.dat\n1 4 0 0 0 {OVER} 3001.dat\n", 0),  # studs on studs
        (f"1 4 0 24 0 {STRAIGHT} 3001.dat\n1 4 0 24 0 {OVER} 3001.dat\n", 0),  # the upper one is upside down
        (f"1 4 0 24 0 {STRAIGHT} 3001.dat\n1 4 0 48 0 {OVER} 3001.dat\n", 0),  # within each other, undersides up
        (f"1 4 0 0 0 {OVER} 3001.dat\n1 4 0 24 0 {OVER} 3001.dat\n", 1),  # both are
        (f"1 4 0 0 0 {TURNED} 3005.dat\n1 4 0 24 0 {STRAIGHT} 3005.dat\n", 0),  # by an eighth of a turn
        (f"1 4 0 0 0 {QUARTER} 3001.dat\n1 4 0 24 0 {STRAIGHT} 3001.dat\n", 1),
        ("1 4 0 0 0 0 1 0 -1 0 0 0 0 1 3001.dat\n1 4 24 0 0 0 1 0 -1 0 0 0 0 1 3001.dat\n", 1),  # sideways
    ],
)
def test_studs_hold_only_what_is_on_them(bricks: str, pairs: int, load: Load) -> None:
    assert len(load(bricks).friction.tension) == pairs


def test_bricks_that_are_turned_on_a_stud_are_told(load: Load) -> None:
    scene = load(f"1 4 0 0 0 {TURNED} 3005.dat\n1 4 0 24 0 {STRAIGHT} 3005.dat\n")
    assert "studs hold nothing in 1 pairs: they are upside down or turned by no quarter" in scene.notes


def test_a_light_plate_does_not_pull_a_thousand_times_the_weight_of_all(load: Load) -> None:
    scene = load(BASE + f"1 4 40 -8 20 {STRAIGHT} 3020.dat\n")
    assert "studs hold less in 1 pairs: 500 times the weight of all parts" in scene.notes
    lift = float(hf.robustness(scene, "plate 2x4", (0.016, 0.008, 0.0032), (0, 0, 1)))
    assert lift == pytest.approx(501 * G * scene.body("plate 2x4").mass, rel=1e-6)


# Weights [g] of bricks that StableLego lists (Liu et al. 2024), by studs
WEIGHTS = {(1, 1): 0.43, (1, 2): 0.81, (1, 4): 1.57, (1, 6): 2.28, (1, 8): 3.03, (2, 2): 1.15, (2, 4): 2.16}


@pytest.mark.parametrize(("deep", "wide"), WEIGHTS)
def test_masses_are_near_those_that_were_weighed(deep: int, wide: int, load: Load) -> None:
    (body,) = load(model([(0, 0, wide, deep)])).movable
    assert body.mass == pytest.approx(1e-3 * WEIGHTS[deep, wide], rel=0.04)


# Builds that were made and labelled (StableLego, Liu et al. 2024, doi:10.1109/LRA.2024.3414281): the first stud, the
# layer, and the studs of each brick along and across
STAIRS = [(2 * k, k, 4, 2) for k in range(20)]
STICK = [(0, 0, 8, 1), (6, 1, 4, 1), (8, 2, 4, 1), (10, 3, 8, 1), (16, 2, 8, 1), (22, 3, 6, 1), (26, 2, 6, 1),
         (30, 3, 6, 1), (34, 2, 6, 1), (38, 3, 6, 1), (42, 2, 6, 1), (44, 3, 4, 1), (44, 4, 4, 1)]  # fmt: skip
BUILDS: dict[str, tuple[str, bool]] = {
    "19 stairs": (model(STAIRS[:19]), True),
    "20 stairs": (model(STAIRS), False),
    "20 stairs, a brick below the second": (model(STAIRS) + placed(4, 0, 2, 1, QUARTER), True),
    "a stick with two loads": (model(STICK), True),
    "a stick with three loads": (model([*STICK, (44, 5, 4, 1)]), False),
    "a stick with three loads, a brick below": (model([*STICK, (44, 5, 4, 1), (8, 0, 2, 1)]), True),
    "200 g on three stairs": (model([*STAIRS[:3], (5, 3, 2, 2)]), True),
    "200 g on four stairs": (model([*STAIRS[:4], (7, 4, 2, 2)]), False),
}


@pytest.mark.parametrize("engine", ["limit", "compliant"])
@pytest.mark.parametrize("name", BUILDS)
def test_the_eight_labelled_builds_stand_and_fall_as_they_did(name: str, engine: str, load: Load) -> None:
    text, stands = BUILDS[name]
    scene = load(text, mass={"brick 2x2": 0.2} if "200 g" in name else None)
    verdict = hf.stability(scene, engine=engine)
    assert verdict.status is (hf.Status.STABLE if stands else hf.Status.UNSTABLE), verdict.reason


def test_the_command_reads_it_and_says_what_a_stud_holds(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "stairs.mpd").write_text(model(STAIRS))

    def verdict(*options: str) -> object:
        monkeypatch.setattr(sys, "argv", ["holdfast", "assess", str(tmp_path / "stairs.mpd"), *options])
        with pytest.raises(SystemExit) as stopped:
            run()
        return stopped.value.code

    assert verdict() == 1
    assert verdict("--stud", "2") in (0, None)


LINE = f"1 4 0 0 0 {STRAIGHT} 3001.dat"
CYCLE = f"0 FILE a.ldr\n1 4 0 0 0 {STRAIGHT} b.ldr\n0 FILE b.ldr\n1 4 0 0 0 {STRAIGHT} A.LDR\n"
# 10 to the power of 20 bricks in a few hundred bytes
BOMB = "".join(f"0 FILE {k}.ldr\n" + 10 * f"1 4 0 0 0 {STRAIGHT} {k + 1}.ldr\n" for k in range(20)) + "0 FILE 20.ldr\n"
CHAIN = "".join(f"0 FILE {k}.ldr\n1 4 0 0 0 {STRAIGHT} {k + 1}.ldr\n" for k in range(99)) + f"0 FILE 99.ldr\n{LINE}\n"


@pytest.mark.parametrize(
    ("content", "match"),
    [
        ("", "model.ldr: has no parts; needs plain bricks"),
        ("0 FILE a.ldr\n0 FILE b.ldr\n" + LINE, "has no parts"),
        (LINE.replace("3001", "3039"), "model.ldr: has parts of unknown shape: 3039.dat; needs plain bricks"),
        (LINE.replace("3001.dat", "../../etc/passwd"), "parts of unknown shape: ../../etc/passwd"),
        (LINE.replace("3001.dat", "other.ldr"), "parts of unknown shape: other.ldr"),
        (f"{LINE}\n1 4 0 0", r"model.ldr:2: is too short; needs 1, a colour, 12 numbers and a file"),
        (LINE.replace("4 0", "4 nan"), r"model.ldr:1: number: is nan; needs a finite number"),
        (LINE.replace("4 0", "4 1e999"), r"model.ldr:1: number: is inf; needs a finite number"),
        (LINE.replace("4 0", "4 1e300"), r"model.ldr:1: number: is 1e\+300"),
        (LINE.replace("4 0", "4 0,5"), r"model.ldr:1: number: is '0,5'; needs a number, with a point for decimals"),
        (LINE.replace("4 0", f"4 {'9' * 9999}"), r"model.ldr:1: number: is inf"),
        (LINE.replace(STRAIGHT, "2 0 0 0 1 0 0 0 1"), r"model.ldr:1: scales or shears what it places"),
        (LINE.replace(STRAIGHT, "0 0 0 0 0 0 0 0 0"), r"model.ldr:1: scales or shears what it places"),
        (LINE.replace(STRAIGHT, "1 0.1 0 0 1 0 0 0 1"), r"model.ldr:1: scales or shears what it places"),
        (CYCLE, r"model.ldr:4: 'a.ldr' is within itself; take it out"),
        (f"0 FILE a\n{LINE}\n0 FILE A\n", r"model.ldr:3: 'a' stands twice; keep one"),
        (BOMB, "is one too many; the limits are 100,000 parts"),
        (CHAIN, "is one too many; the limits are 100,000 parts, 1,000,000 studs, 40 submodels within each other"),
        (LINE.replace("3001", "4186") + "\n" + 999 * f"{LINE}\n".replace("3001", "4186"), "1,000,000 studs"),
    ],
)
def test_what_is_wrong_is_one_clear_error(content: str, match: str, load: Load) -> None:
    with pytest.raises(hf.HoldfastError, match=match) as caught:
        load(content)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "options", [{"stud": -1}, {"stud": float("nan")}, {"fixed": ["brick"]}, {"mass": {"brick": 1}}]
)
def test_wrong_options_are_refused(options: dict[str, Any], load: Load) -> None:
    with pytest.raises(hf.errors.SceneError):
        load(LINE, **options)
