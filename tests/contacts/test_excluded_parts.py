"""Parts of bodies that may not touch: for what they may not touch they are not there."""

from __future__ import annotations

import itertools
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from placed import FLOOR, at

import holdfast as hf
from holdfast.scene.excluded import Excluded

G = 9.81


def table(excluded: list[Excluded], **rest: Any) -> hf.Scene:
    """A top on two legs, part 1 at x = -0.2 and part 2 at x = 0.2."""
    top = hf.Part(hf.Box((0.5, 0.2, 0.05)), at(z=0.225))
    legs = [hf.Part(hf.Box((0.05, 0.2, 0.2)), at(x, 0, 0.1)) for x in (-0.2, 0.2)]
    body = hf.Body("table", hf.Compound([top, *legs]), mass=4, **rest)
    return hf.Scene([FLOOR, body], 0.5, excluded=excluded)


def touching(scene: hf.Scene, gap: float = 1e-4) -> dict[tuple[str, str], hf.answers.Interface]:
    return {i.bodies: i for i in hf.assemble(scene, gap=gap).interfaces}


def test_a_table_stands_on_the_leg_that_may_touch_alone() -> None:
    """On its wide second leg, under its centre of mass, it holds what a column would: m g b over the lever."""
    scene = table([(("table", 1), "floor")], com=(0.2, 0, 0.2))
    (patch,) = touching(scene)["floor", "table"].patches
    assert patch.area == pytest.approx(0.05 * 0.2, rel=1e-9)
    assert np.allclose(patch.centroid, (0.2, 0, 0))
    answer = hf.robustness(scene, "table", (0.25, 0, 0.25), (-1, 0, 0), engine="limit")
    assert answer.force[0] == pytest.approx(4 * G * 0.025 / 0.25, rel=1e-6)
    assert hf.stability(table([(("table", 1), "floor")])).status is hf.Status.UNSTABLE
    assert hf.stability(table([])).status is hf.Status.STABLE
    assert hf.stability(table([(("table", 1), "floor"), ("floor", ("table", 2))])).status is hf.Status.UNSTABLE


def test_a_part_that_may_not_touch_hides_nothing_of_those_that_may() -> None:
    """A foot inside a larger block: whatever may not touch the block stands on the foot, and the other way round."""
    foot, block = hf.Part(hf.Box((0.1, 0.1, 0.1)), at(z=0.05)), hf.Part(hf.Box((0.3, 0.3, 0.2)), at(z=0.1))
    body = hf.Body("both", hf.Compound([foot, block]), mass=1)
    areas = {}
    for number in (None, 0, 1):
        pairs = [] if number is None else [(("both", number), "floor")]
        areas[number] = touching(hf.Scene([FLOOR, body], 0.5, excluded=pairs))["floor", "both"].area
    assert areas == pytest.approx({None: 0.09, 0: 0.09, 1: 0.01}, rel=1e-9)


def test_a_part_that_may_not_touch_may_overlap_without_a_warning(recwarn: pytest.WarningsRecorder) -> None:
    spike = hf.Part(hf.Box((0.02, 0.02, 0.3)), at(z=0.0))
    plate = hf.Part(hf.Box((0.3, 0.3, 0.1)), at(z=0.05))
    body = hf.Body("it", hf.Compound([plate, spike]), mass=1)
    free = hf.assemble(hf.Scene([FLOOR, body], 0.5, excluded=[("floor", ("it", 1))]))
    assert free.overlaps == ()
    assert [i.status for i in free.interfaces] == ["touching"]
    assert free.interfaces[0].area == pytest.approx(0.09, rel=1e-9)
    assert not recwarn
    with pytest.warns(hf.errors.HoldfastWarning, match="overlap"):
        assert hf.assemble(hf.Scene([FLOOR, body], 0.5)).overlaps


def test_friction_is_that_of_the_parts_that_may_touch() -> None:
    """Two parts at one place, of which one touches the floor and the other the wall."""
    parts = [hf.Part(hf.Box((0.1, 0.1, 0.1)), at(z=0.05), name) for name in ("rubber", "steel")]
    wall = hf.Body("wall", hf.Box((0.1, 1, 1)), pose=at(-0.1, 0, 0.5), fixed=True)
    body = hf.Body("it", hf.Compound(parts), mass=1)
    mu = hf.Friction(pairs={(a, b): k for (a, k) in (("rubber", 0.9), ("steel", 0.2)) for b in ("floor", "wall")})
    apart: list[Excluded] = [("floor", ("it", 1)), ("wall", ("it", 0))]
    found = hf.assemble(hf.Scene([FLOOR, wall, body], mu, excluded=apart))
    assert dict(zip([i.bodies for i in found.interfaces], found.mu, strict=True)) == {
        ("floor", "it"): 0.9,
        ("wall", "it"): 0.2,
    }


def test_a_body_with_fewer_parts_keeps_its_mass_and_centre() -> None:
    whole = table([(("table", 1), "floor")]).body("table")
    dense = replace(whole, mass=None, density=700.0)
    for body in (whole, dense):
        less = body.only([0, 2])
        assert less.mass == body.mass
        assert less.com_world == pytest.approx(body.com_world, abs=1e-15)
        assert less.materials == body.materials[:2]


@pytest.mark.parametrize("seed", range(6))
def test_every_pair_of_parts_is_searched_or_not_as_it_may_touch(seed: int) -> None:
    """Combs whose teeth meet one to one: each pair of teeth touches unless it is excluded."""
    rng = np.random.default_rng(seed)
    teeth = [hf.Part(hf.Box((0.02, 0.02, 0.02)), at(0.1 * k)) for k in range(5)]
    low = hf.Body("low", hf.Compound(teeth), fixed=True)
    high = hf.Body("high", hf.Compound(teeth), mass=1, pose=at(z=0.02))
    pairs = [(("low", int(i)), ("high", int(j))) for i, j in rng.integers(5, size=(7, 2))]
    apart = {i for (_, i), (_, j) in pairs if i == j}
    found = hf.assemble(hf.Scene([low, high], 0.5, excluded=pairs), gap=1e-4).interfaces
    places = sorted(round(patch.centroid[0] / 0.1) for i in found for patch in i.patches)
    assert places == sorted(set(range(5)) - apart)


def test_native_files_values_and_models_hold_the_parts(tmp_path: Path) -> None:
    scene = table([(("table", 2), "floor")])
    for name in ("scene.yaml", "scene.json"):
        hf.save_scene(scene, tmp_path / name)
        again = hf.load_scene(tmp_path / name)
        assert again == scene
        assert again.excluded == (("floor", ("table", 2)),)
    assert replace(scene, name="other").excluded == scene.excluded
    assert scene.without("table").excluded == ()
    answer = hf.stability(scene)
    answer.save(tmp_path / "answer.json")
    assert hf.load_answer(tmp_path / "answer.json") == answer


def test_the_only_part_of_a_body_stands_for_the_body() -> None:
    cube = hf.Body("cube", hf.Box((0.1, 0.1, 0.1)), mass=1, pose=at(z=0.05))
    scene = hf.Scene([FLOOR, cube], 0.5, excluded=[(("cube", 0), ["floor", 0])])
    assert scene.excluded == (("cube", "floor"),)


@pytest.mark.parametrize(
    ("pair", "match"),
    [
        ((("table", 3), "floor"), r"'table' has no part 3; needs a number from 0 to 2"),
        ((("table", -1), "floor"), "has no part -1"),
        ((("table", True), "floor"), "is no pair"),
        ((("table", 1.0), "floor"), "is no pair"),
        ((("table", 0), ("table", 1)), "is of one body"),
        ((("tabel", 1), "floor"), r"unknown name 'tabel'; did you mean 'table'\?"),
    ],
)
def test_what_is_no_part_is_refused(pair: Any, match: str) -> None:
    with pytest.raises(hf.errors.SceneError, match=match):
        table([pair])


@pytest.mark.parametrize("seed", range(8))
def test_mujoco_touches_the_same_geoms(seed: int, tmp_path: Path) -> None:
    """Bodies of three balls in one row each, all rows at one place; a ball touches the one at its place if it may."""
    mujoco: Any = pytest.importorskip("mujoco", reason="needs MuJoCo: pip install 'holdfast-robotics[mujoco]'")
    rng = np.random.default_rng(seed)
    bodies, names = "", list(itertools.product("abc", range(3)))
    for body in "abc":
        geoms = "".join(
            f'<geom name="{body}{k}" type="sphere" size=".1" pos="{k} 0 0" '
            f'contype="{rng.integers(4)}" conaffinity="{rng.integers(1, 4)}"/>'
            for k in range(3)
        )
        bodies += f'<body name="{body}"><freejoint/>{geoms}</body>'
    pair = '<contact><pair geom1="a1" geom2="b1" friction="0.3"/><exclude body1="a" body2="b"/></contact>'
    text = f'<mujoco><worldbody><geom type="plane" size="1 1 1" pos="0 0 -9"/>{bodies}</worldbody>{pair}</mujoco>'
    model = mujoco.MjModel.from_xml_string(text)

    def touched(model: Any) -> set[tuple[str, int]]:
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        bodies = [tuple(sorted(model.body(model.geom_bodyid[g]).name for g in pair)) for pair in data.contact.geom]
        return {("".join(pair), round(x)) for pair, x in zip(bodies, data.contact.pos[:, 0], strict=True)}

    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    scene = hf.from_mujoco(model, data)
    ours = set()
    for a, b in itertools.combinations(scene.movable, 2):
        for one, two in scene.touching(a, b):
            shared = [
                {round(float(p.pose[0, 3])) for p in each.shape.parts} if isinstance(each.shape, hf.Compound) else {0}
                for each in (one, two)
            ]
            ours |= {(a.name + b.name, place) for place in shared[0] & shared[1]}
    assert ours == touched(model)
    hf.save_scene(scene, tmp_path / "again.xml")
    again = mujoco.MjModel.from_xml_path(str(tmp_path / "again.xml"))
    assert touched(again) == touched(model)
    assert len(names) == 9
