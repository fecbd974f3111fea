"""Packing plans of py3dbp, skjolber's visualizer and BED-BPP: places, names, masses, and what is wrong with a file.

Random plans stand or fall by construction: a box that lies on faces of equal height stands, and one whose centre is
beyond all of its support falls.
"""

from __future__ import annotations

import json
from typing import Any, NamedTuple

import numpy as np
import pytest
from scene_content import Load, loading

import holdfast as hf
from holdfast.cli.main import run

load = loading("plan.json", json.dumps, friction=0.5)


class Packed(NamedTuple):
    """A box that lies with its least corner at ``corner`` [cm]."""

    corner: tuple[int, int, int]
    size: tuple[int, int, int]
    mass: float


def py3dbp(boxes: list[Packed], rng: np.random.Generator) -> dict[str, Any]:
    """The attributes of a Packer, in which each item has its size before rotation; decimals are texts."""
    items = []
    for box in boxes:
        turn = int(rng.integers(6))
        x, y, z = box.size
        # width, height and depth of what lies as x, y, z after this rotation type: WHD, HWD, HDW, DHW, DWH, WDH
        width, height, depth = [(x, y, z), (y, x, z), (z, x, y), (z, y, x), (y, z, x), (x, z, y)][turn]
        items.append(
            {"name": "crate", "width": f"{width}.000", "height": f"{height}.000", "depth": f"{depth}.000",
             "weight": f"{box.mass:.3f}", "rotation_type": turn, "position": list(box.corner), "number_of_decimals": 3}
        )  # fmt: skip
    left = {**items[0], "position": [0, 0, 0], "name": "too large"}
    packed = {"name": "truck", "width": 300, "height": 300, "depth": 300, "max_weight": "9999.000", "items": items,
              "unfitted_items": [left], "number_of_decimals": 3}  # fmt: skip
    return {"bins": [packed], "items": [], "unfit_items": [], "total_items": len(items)}


def skjolber(boxes: list[Packed], rng: np.random.Generator) -> dict[str, Any]:
    """The file of the visualizer since version 4: results with containers, whose stacks have placements."""
    placements = []
    for (x, y, z), (dx, dy, dz), mass in boxes:
        inside = {"id": "A", "name": None, "type": "box", "weight": mass, "dx": dx, "dy": dy, "dz": dz}
        placements.append({"step": 2, "plugins": [], "x": x, "y": y, "z": z, "points": [], "stackable": inside})
    container = {"id": "1", "name": "truck", "dx": 300, "dy": 300, "dz": 300, "stack": {"placements": placements}}
    return {"results": [{"name": "sample", "containers": [container], "success": True}]}


def bed_bpp(boxes: list[Packed], rng: np.random.Generator) -> dict[str, Any]:
    """Orders with a list of actions each, in mm; orientation 1 swaps length and width."""
    actions = []
    for box in boxes:
        turn = int(rng.integers(2))
        length, width = (10 * box.size[turn], 10 * box.size[1 - turn])
        item = {"article": "donut", "id": "7", "product_group": "confectionery", "length/mm": length,
                "width/mm": width, "height/mm": 10 * box.size[2], "weight/kg": box.mass, "sequence": 1}  # fmt: skip
        actions.append({"item": item, "flb_coordinates": [10 * value for value in box.corner], "orientation": turn})
    return {"00100408": actions}


PROGRAMS = {"py3dbp": (py3dbp, 0.01), "skjolber": (skjolber, 0.01), "BED-BPP": (bed_bpp, None)}


def random_plan(rng: np.random.Generator, falls: bool) -> list[Packed]:
    """Boxes on a grid of 10 cm, each on faces of one height; if ``falls``, a last one with its centre over an edge."""
    heights = np.zeros((12, 12), dtype=int)  # [cm] of what lies on each square, as nothing hovers
    boxes: list[Packed] = []
    wanted = int(rng.integers(4, 25))
    while len(boxes) < wanted:
        wide, deep, high = (int(value) for value in rng.integers(1, 5, 3))
        x, y = int(rng.integers(0, 13 - wide)), int(rng.integers(0, 13 - deep))
        below = heights[x : x + wide, y : y + deep]
        if (below == below[0, 0]).all():
            boxes.append(
                Packed((10 * x, 10 * y, int(below[0, 0])), (10 * wide, 10 * deep, 10 * high), wide * deep * 1.5)
            )
            heights[x : x + wide, y : y + deep] += 10 * high
    if falls:
        top = max(boxes, key=lambda box: box.corner[2] + box.size[2])
        (x, y, z), (wide, deep, high) = top.corner, top.size
        boxes.append(Packed((x, y, z + high), (wide, deep, 10), 2.0))  # nothing else is as high
        # only its first 4 cm are carried: its centre is 2 cm beyond the edge
        boxes.append(Packed((x + wide - 4, y, z + high + 10), (12, deep, 10), 2.0))
    return boxes


@pytest.mark.parametrize("seed", range(100))
def test_random_plans_stand_and_fall_as_their_boxes_lie(seed: int, load: Load) -> None:
    rng, falls = np.random.default_rng([71, seed]), bool(seed % 2)
    boxes = random_plan(rng, falls)
    write, scale = list(PROGRAMS.values())[seed % 3]
    scene = load(write(boxes, rng), scale=scale)
    for box, body in zip(boxes, scene.movable, strict=True):
        low = np.array(box.corner) / 100
        np.testing.assert_allclose(body.box, (low, low + np.array(box.size) / 100), atol=1e-9)
        assert body.mass == pytest.approx(box.mass)
    verdict = hf.stability(scene)
    assert verdict.status is (hf.Status.UNSTABLE if falls else hf.Status.STABLE), verdict.reason
    if falls:
        assert scene.movable[-1].name in verdict.reason


@pytest.mark.parametrize("program", PROGRAMS)
def test_what_was_taken_is_said(program: str, load: Load) -> None:
    rng, boxes = np.random.default_rng(0), [Packed((0, 0, 0), (3, 2, 1), 4.0), Packed((3, 0, 0), (3, 2, 1), 4.0)]
    write, scale = PROGRAMS[program]
    scene = load(write(boxes, rng), scale=scale)
    name = {"py3dbp": "crate", "skjolber": "A", "BED-BPP": "donut"}[program]
    assert [body.name for body in scene.movable] == [name, f"{name} (2)"]
    assert "z is taken as up, and z = 0 as the bottom of all containers; their walls are left out" in scene.notes
    if scale is not None:
        metres = load(write(boxes, rng))
        assert "the plan says no units: lengths are taken as metres" in metres.notes
        np.testing.assert_allclose(metres.body(name).box, ((0, 0, 0), (3, 2, 1)), atol=1e-9)
    if program == "py3dbp":
        assert "items that fit nowhere are left out, 1 of them" in scene.notes


def one(**more: Any) -> dict[str, Any]:
    """A bin of py3dbp with one item."""
    item = {"name": "a", "width": 1, "height": 2, "depth": 3, "weight": 4, "rotation_type": 0, "position": [0, 0, 0]}
    return {"name": "bin", "width": 9, "items": [item | more], "unfitted_items": []}


def test_bins_alone_and_in_lists_and_containers_of_earlier_versions_are_read(load: Load) -> None:
    assert [body.name for body in load(one()).movable] == ["a"]
    two = load([one(), one(name="b")])
    assert [body.name for body in two.movable] == ["bin/a", "bin/b"]
    np.testing.assert_allclose(two.body("bin/b").box, ((10, 0, 0), (11, 2, 3)), atol=1e-12)  # 9 m, and 1 m between
    assert "2 containers stand beside each other, 1 m apart" in two.notes
    early = {"containers": [{"dx": 3, "stack": {"placements": [
        {"x": 0, "y": 0, "z": 0, "stackable": {"dx": 1, "dy": 1, "dz": 1, "type": "box"}}]}}]}  # fmt: skip
    scene = load(early, density=500)
    assert {body.name: body.mass for body in scene.movable} == {"box 1": pytest.approx(500)}


def test_forks_with_parts_and_cylinders(load: Load) -> None:
    item = one(partno="7", name="can", typeof="cylinder", level=1, loadbear=100, updown=True, color="red")
    scene = load({"bins": [item]})
    assert [body.name for body in scene.movable] == ["7"]
    assert "not read, though it may matter: loadbear of boxes, the roundness of cylinders" in scene.notes


def test_y_may_be_up(load: Load) -> None:
    scene = load(one(position=[0, 1, 0]), up_axis="y", scale=0.1)
    np.testing.assert_allclose(scene.body("a").box, ((0, 0, 0.1), (0.1, 0.3, 0.3)), atol=1e-12)


def test_boxes_beyond_their_container_are_told(load: Load) -> None:
    assert not [note for note in load(one(position=[8, 0, 0])).notes if "beyond" in note]
    told = "boxes reach beyond their container along x, in bin: are they placed right?"
    assert told in load(one(position=[8.1, 0, 0])).notes


def test_masses_and_fixed_boxes_are_given_by_name(load: Load) -> None:
    scene = load({"bins": [{"name": "b", "width": 9, "items": one()["items"] * 3}]}, mass={"a (2)": 7}, fixed=["a (3)"])
    assert {body.name: body.mass for body in scene.movable} == {"a": 4.0, "a (2)": 7.0}
    assert scene.body("a (3)").fixed
    with pytest.raises(hf.errors.SceneError, match="leave floor= out, or give fixed="):
        load(one(), floor=False)


def test_the_command_reads_it(tmp_path: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    boxes = random_plan(np.random.default_rng(3), falls=True)
    (tmp_path / "plan.json").write_text(json.dumps(py3dbp(boxes, np.random.default_rng(3))))
    line = ["holdfast", "assess", str(tmp_path / "plan.json"), "--friction", "0.5", "--scale", "0.01"]
    for more, code in (((), 1), (("--without", f"crate ({len(boxes)})"), 0)):
        monkeypatch.setattr("sys.argv", [*line, *more])
        with pytest.raises(SystemExit) as stopped:
            run()
        assert (stopped.value.code or 0) == code


ACTION = {"item": {"article": "a", "length/mm": 1, "width/mm": 1, "height/mm": 1, "weight/kg": 1},
          "flb_coordinates": [0, 0, 0], "orientation": 0}  # fmt: skip


@pytest.mark.parametrize(
    ("content", "options", "match"),
    [
        (one(), {"friction": None}, "plan.json: says nothing of friction; give friction="),
        (one(weight=None), {}, r"plan.json: 'bin': box 1: has no mass; give density= or mass="),
        (one(weight=0), {}, r"plan.json: 'bin': box 1: has no mass; give density= or mass="),
        (one(weight=-1), {}, r"plan.json: 'bin': box 1.*mass"),
        (one(rotation_type=6), {}, r"'bin': box 1: rotation_type: is 6; needs a whole number of at most 5"),
        (one(rotation_type=-1), {}, r"'bin': box 1: rotation_type: is -1; needs a whole number of at least 0"),
        (one(position=[0, 0]), {}, r"'bin': box 1: is no box of py3dbp: not enough values to unpack"),
        (one(position=[0, 0, float("nan")]), {}, r"place: is nan; needs a finite number"),
        (one(position=[0, 0, "x"]), {}, r"'bin': box 1: place: got 'x'; needs a finite number"),
        (one(position=[0, 0, 1e300]), {}, r"'bin': box 1: place: is 1e\+300"),
        (one(width=0), {}, r"'bin': box 1.*size"),
        (one(width=[1]), {}, r"'bin': box 1: size: got \[1\]"),
        (one(width="9" * 9999), {}, r"'bin': box 1: size: is inf"),
        ({"bins": []}, {}, r"plan.json: has no placed boxes, or too many; needs 1 to 100,000"),
        ({"bins": [3]}, {}, r"plan.json: is no packing plan of py3dbp"),
        ({"bins": [{"items": 3, "width": 1}]}, {}, r"plan.json: is no packing plan of py3dbp"),
        ({"bins": [{"items": [], "width": 1, "unfitted_items": 7}]}, {}, r"plan.json: is no packing plan of py3dbp"),
        ({"bins": [{"items": [None], "width": 1}]}, {}, r"plan.json: 'bin 1': box 1: is no box of py3dbp"),
        ({"containers": [{"dx": 1}]}, {}, r"plan.json: is no packing plan of skjolber: KeyError: 'stack'"),
        ({"containers": [{"dx": 1, "stack": {"placements": [{"x": 0}]}}]}, {}, r"'container 1': box 1: is no box"),
        ({"order": [ACTION | {"orientation": 2}]}, {}, r"plan.json: 'order': box 1: orientation: is 2"),
        ({"order": [ACTION], "other": 3}, {}, r"plan.json: is no packing plan of BED-BPP"),
        (one(), {"up_axis": "x"}, r"up_axis: is 'x'; needs one of y, z"),
        (one(), {"scale": 0}, r"scale: is 0"),
        (one(), {"fixed": ["b"]}, r"no box is named 'b'"),
    ],
)
def test_what_is_wrong_is_one_clear_error(content: Any, options: dict[str, Any], match: str, load: Load) -> None:
    with pytest.raises(hf.HoldfastError, match=match) as caught:
        load(content, **options)
    assert "\n" not in str(caught.value)


def test_other_json_is_no_plan(load: Load) -> None:
    for content in ({"results": [1]}, {"a": [1]}, {"a": []}, [], [1], {}, {"bins": 3}, {"items": []}):
        with pytest.raises(hf.errors.SceneError, match="is in no known format"):
            load(content)
