"""Who is crushed first: loads on top and pressures beside what bodies may bear."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import holdfast as hf

ENGINES = ("compliant", "limit", "graph")
HOLDFAST = (sys.executable, "-m", "holdfast")
G = 9.81


def column(count: int = 4, **limits: float) -> hf.Scene:
    """Boxes of 0.4 x 0.3 x 0.3 m and 10 kg on each other."""
    boxes = [
        hf.Body(f"box{k}", hf.Box((0.4, 0.3, 0.3)), 10.0, position=(0, 0, 0.15 + 0.3 * k), **limits)
        for k in range(count)
    ]
    return hf.Scene([hf.Body("floor", hf.HalfSpace(), fixed=True), *boxes], 0.5)


@pytest.mark.parametrize("engine", ENGINES)
def test_each_box_of_a_column_bears_the_weight_above_it(engine: str) -> None:
    verdict = hf.stability(column(top_load=250.0), engine=engine)
    assert [one.body for one in verdict.bearing] == ["box0", "box1", "box2", "box3"]
    loads = [one.load for one in verdict.bearing]
    assert loads == pytest.approx([30 * G, 20 * G, 10 * G, 0], rel=1e-6)
    assert [one.share for one in verdict.bearing] == pytest.approx([load / 250 for load in loads])
    assert verdict.bearing[0].by == ("box1",)
    assert verdict.crushed == ("box0",)
    assert verdict.status is hf.Status.STABLE
    assert not verdict.stable
    assert verdict.margin == 0.0
    assert "crushed: box0 bears 294.3 N of 250 N on top (118%), 44.3 N too much" in verdict.explain()


def test_pressure_is_the_mean_over_a_contact() -> None:
    verdict = hf.stability(column(pressure=3e3))
    first = verdict.bearing[0]
    assert (first.body, first.kind) == ("box0", "pressure")
    assert first.load == pytest.approx(40 * G / 0.12, rel=1e-6)
    assert first.by[0] == "floor"
    assert verdict.crushed == ("box0",)


def test_what_bears_no_more_than_it_may_is_stable() -> None:
    verdict = hf.stability(column(top_load=30 * G, pressure=40 * G / 0.12))
    assert verdict.stable
    assert verdict.crushed == ()
    assert verdict.bearing[0].share == pytest.approx(1, rel=1e-6)
    assert hf.stability(column()).bearing == ()


def test_neither_the_floor_nor_neighbours_count_as_load_on_top() -> None:
    """A box pressed down by a push bears it; boxes beside it and the floor below do not."""
    side = hf.Body("side", hf.Box((0.4, 0.3, 0.3)), 10.0, position=(0.4, 0, 0.15), top_load=10.0)
    scene = hf.Scene([*column(1, top_load=50.0).bodies, side], 0.5)
    assert hf.stability(scene).stable
    pressed = hf.stability(scene, loads=[hf.Load("box0", (0, 0, 0.3), (0, 0, -60.0))])
    assert pressed.crushed == ("box0",)
    assert pressed.bearing[0].load == pytest.approx(60.0)


def test_a_shelf_board_bears_what_all_that_stands_on_it_weighs() -> None:
    shelf = hf.Body("shelf", hf.Box((1, 0.4, 0.02)), position=(0, 0, -0.01), fixed=True, top_load=100.0)
    mugs = [hf.Body(f"mug{k}", hf.Box((0.1, 0.1, 0.1)), 4.0, position=(0.3 * k - 0.3, 0, 0.05)) for k in range(3)]
    verdict = hf.stability(hf.Scene([shelf, *mugs], 0.5))
    assert verdict.bearing[0].load == pytest.approx(12 * G, rel=1e-6)
    assert verdict.crushed == ("shelf",)


def test_a_line_has_no_area_to_bear_on() -> None:
    """A drum in a groove touches along lines: no pressure can be said of them, and a limit does not pass silently."""
    drum = hf.Body("drum", hf.Cylinder(0.1, 0.3), 2.0, position=(0, 0, 0.1), rpy_degrees=(90, 0, 0), pressure=1e9)
    walls = [hf.Body(f"wall{x}", hf.Box((0.1, 1, 1)), position=(x * 0.15, 0, 0.5), fixed=True) for x in (-1, 1)]
    floor = hf.Body("floor", hf.HalfSpace(), fixed=True)
    verdict = hf.stability(hf.Scene([floor, *walls, drum], 0.5), engine="limit")
    assert verdict.verdict.stable
    assert verdict.bearing[0].load == np.inf
    assert verdict.crushed == ("drum",)


def test_limits_are_checked_saved_and_told(tmp_path: Path) -> None:
    scene = column(top_load=250.0, pressure=5e3)
    for name in ("column.yaml", "column.json", "column.glb"):
        hf.save_scene(scene, tmp_path / name)
        again = hf.load_scene(tmp_path / name)
        assert [(body.top_load, body.pressure) for body in again.bodies] == [(None, None), *[(250.0, 5e3)] * 4]
    told = subprocess.run([*HOLDFAST, "assess", tmp_path / "column.yaml"], capture_output=True, text=True, check=False)
    assert told.returncode == 1
    assert "crushed: box0 bears 294.3 N" in told.stdout
    verdict = hf.stability(scene)
    verdict.save(tmp_path / "verdict.json")
    assert hf.load_answer(tmp_path / "verdict.json").crushed == ("box0",)
    assert verdict.to_dict()["bearing"][0]["share"] == pytest.approx(30 * G / 250)
    with pytest.raises(hf.HoldfastError, match="top_load"):
        column(top_load=-1.0)


def test_a_batch_and_its_gate_name_who_is_crushed(tmp_path: Path) -> None:
    hf.save_scene(column(top_load=250.0), tmp_path / "column.yaml")
    found = hf.batch(str(tmp_path / "column.yaml"), out=tmp_path / "out", ask=["stability"], workers=1)
    tables = hf.read_batch(tmp_path / "out")
    (row,) = tables.rows("scenes")
    assert row["status"] == "stable"
    assert row["crushed"] == ["box0"]
    bearing = {row["body"]: row["bearing"] for row in tables.rows("bodies")}
    assert bearing["floor"] is None
    assert bearing["box1"] == pytest.approx(20 * G / 250)
    assert found.verdicts["stable"] == 1
    gate = subprocess.run([*HOLDFAST, "check", tmp_path / "column.yaml", "--stands"], capture_output=True, check=False)
    assert gate.returncode == 1


@pytest.mark.parametrize("engine", ["compliant", "limit"])
def test_what_presses_a_steep_side_counts_with_its_vertical_part(engine: str) -> None:
    """A cap of 100 kg on both flanks of a wedge, which lean by 69 degrees, without friction."""
    flank = np.array([[-0.1, 0.0], [0.1, 0.0], [0.0, 0.26]])
    wedge = hf.Body("wedge", _prism(flank), mass=1.0, top_load=10.0)
    x = 0.1 * 0.16 / 0.26
    inner = np.array([[-x, 0.1], [0.0, 0.26], [x, 0.1], [0.2, 0.1], [0.2, 0.4], [-0.2, 0.4], [-0.2, 0.1]])
    left, right = (hf.Part(_prism(outline)) for outline in (inner[[0, 1, 5, 6]], inner[[1, 2, 3, 4]]))
    lid = hf.Part(_prism(np.array([[-0.2, 0.4], [0.0, 0.26], [0.2, 0.4]])))
    floor = hf.Body("floor", hf.HalfSpace(), fixed=True)
    cap = hf.Body("cap", hf.Compound([left, right, lid]), mass=100.0)
    found = hf.stability(hf.Scene([floor, wedge, cap], hf.Friction(0.5, {("cap", "wedge"): 0.0})), engine=engine)
    assert found.status is hf.Status.STABLE
    assert found.bearing[0].load == pytest.approx(100 * 9.81, rel=1e-4)
    assert found.crushed == ("wedge",)


@pytest.mark.parametrize("engine", ["compliant", "limit"])
@pytest.mark.parametrize("degrees", [3.0, 10.0, 20.0, 30.0])
def test_a_slope_bears_all_that_rests_on_it(engine: str, degrees: float) -> None:
    """The slant of a wedge bears m g; its pressure is m g cos over the area. Going up, it bears m (g + a)."""
    lean = np.radians(degrees)
    rise = 0.6 * np.tan(lean)
    outline = np.array([[0, 0], [0.6, 0], [0.6, 0.01 + rise], [0, 0.01]])
    at = np.array([0.3, 0, 0.01 + rise / 2]) + 0.05 * np.array([-np.sin(lean), 0, np.cos(lean)])
    cube = hf.Body("cube", hf.Box((0.1, 0.1, 0.1)), 2.0, position=tuple(at), rpy_degrees=(0, -degrees, 0))
    floor = hf.Body("floor", hf.HalfSpace(), fixed=True)
    wedge = hf.Body("wedge", _prism(outline), 5.0, top_load=25.0, pressure=1e5)
    scene = hf.Scene([floor, wedge, cube], 0.8)
    load = {one.kind: one.load for one in hf.stability(scene, engine=engine).bearing}
    assert load["top_load"] == pytest.approx(2 * G, rel=1e-6)
    fixed = replace(wedge, fixed=True)
    (on_it,) = (
        one for one in hf.stability(hf.Scene([fixed, cube], 0.8), engine=engine).bearing if one.kind != "top_load"
    )
    assert on_it.load == pytest.approx(2 * G * np.cos(lean) / 0.01, rel=1e-6)
    up = hf.transport_limits(scene, (0, 0, 1), engine=engine)
    assert up.acceleration == pytest.approx(25 / 2 - G, rel=1e-5)
    assert up.mode[0] == "crush"


@pytest.mark.parametrize("engine", ["compliant", "limit"])
@pytest.mark.parametrize("mu", [0.0, 0.5])
def test_two_slopes_share_what_is_wedged_between_them(engine: str, mu: float) -> None:
    """A keel of 3 kg in a groove: the two flanks bear m g together, and friction shifts none of it to nobody."""
    keel = hf.Body("keel", _prism(np.array([[0.0, 0.0], [0.1, 0.1], [-0.1, 0.1]])), 3.0, position=(0, 0, 0))
    flanks = [
        hf.Body(f"flank{k}", _prism(np.array(outline)), fixed=True, top_load=10.0)
        for k, outline in enumerate([[[0, 0], [-0.2, 0.2], [-0.2, 0]], [[0, 0], [0.2, 0], [0.2, 0.2]]])
    ]
    found = hf.stability(hf.Scene([*flanks, keel], mu), engine=engine)
    assert found.status is hf.Status.STABLE
    assert sum(one.load for one in found.bearing) == pytest.approx(3 * G, rel=1e-6)
    assert found.crushed
    if not mu:
        assert [one.load for one in found.bearing] == pytest.approx([1.5 * G] * 2, rel=1e-6)


@pytest.mark.parametrize("degrees", [5.0, 12.0, 35.0])
def test_a_tilted_deck_and_its_stop_bear_the_weight_between_them(degrees: float) -> None:
    """Both look up: the deck by the cosine, the stop at its lower end by the sine of the tilt."""
    tilt = np.array(hf.pose(0, 0, 0, pitch=degrees))
    deck, stop, box = (
        hf.Body(name, hf.Box(size), 2.0, pose=tilt @ np.array(hf.pose(*at)), fixed=name != "box", top_load=30.0)
        for name, size, at in (
            ("deck", (1, 1, 0.1), (0, 0, -0.05)),
            ("stop", (0.1, 0.2, 0.2), (0.15, 0, 0.1)),
            ("box", (0.2, 0.2, 0.2), (0, 0, 0.1)),
        )
    )
    for engine, bodies in (("compliant", [deck, stop, box]), ("limit", [box, deck, stop])):
        found = {one.body: one.load for one in hf.stability(hf.Scene(bodies, 0.3), engine=engine).bearing}
        assert found["deck"] + found["stop"] == pytest.approx(2 * G, rel=1e-6)
        assert found["box"] == 0
    slides = hf.stability(hf.Scene([deck, stop, box], 0.0), engine="limit").bearing
    right = {"deck": 2 * G * np.cos(np.radians(degrees)) ** 2, "stop": 2 * G * np.sin(np.radians(degrees)) ** 2}
    assert {one.body: one.load for one in slides if one.body != "box"} == pytest.approx(right, rel=1e-6)


@pytest.mark.parametrize("degrees", [0.0, 0.5])
@pytest.mark.parametrize("engine", ["compliant", "limit"])
def test_friction_on_a_side_is_no_load_on_top(engine: str, degrees: float) -> None:
    """A box that is pressed against a wall and down along it: what friction bears is on nobody's top."""
    wall = hf.Body("wall", hf.Box((0.1, 1, 1)), position=(-0.15, 0, 0.5), fixed=True, top_load=1.0)
    box = hf.Body("box", hf.Box((0.2, 0.2, 0.2)), 2.0, position=(0, 0, 0.5), top_load=1.0)
    turn = np.array(hf.pose(0, 0, 0, pitch=-degrees))  # then the wall looks up by that much
    scene = hf.Scene([replace(each, pose=turn @ each.pose) for each in (wall, box)], 0.8)
    press = [hf.Load("box", tuple(turn[:3, :3] @ (0.1, 0, 0.5)), tuple(turn[:3, :3] @ (-100.0, 0, 0)))]
    found = hf.stability(scene, loads=press, engine=engine)
    assert found.status is hf.Status.STABLE
    downward = 100 * np.sin(np.radians(degrees))  # of the load itself
    assert {one.body: one.load for one in found.bearing} == pytest.approx({"wall": 0, "box": downward}, abs=1e-9)


def _prism(outline: np.ndarray) -> hf.Mesh:
    """A prism along y over a convex outline (k, 2) in x and z."""
    n, flat = len(outline), outline
    points = np.vstack([np.column_stack([flat[:, 0], np.full(n, y), flat[:, 1]]) for y in (-0.1, 0.1)])
    ends = [[0, k, k + 1] for k in range(1, n - 1)] + [[n, n + k + 1, n + k] for k in range(1, n - 1)]
    sides = [t for k in range(n) for t in ([k, n + k, (k + 1) % n], [(k + 1) % n, n + k, n + (k + 1) % n])]
    mesh = hf.Mesh(points, ends + sides)
    return mesh if mesh.mass_properties.volume > 0 else hf.Mesh(points, np.array(ends + sides)[:, ::-1])
