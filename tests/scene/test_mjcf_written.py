"""Scenes written as MJCF: MuJoCo loads them with the same masses, poses, shapes, friction and exclusions."""

from __future__ import annotations

import itertools
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import holdfast as hf
from holdfast.base.rigid import pose_from
from holdfast.scene.shipped.blocks import at, box, floor

mujoco = pytest.importorskip("mujoco", reason="needs MuJoCo: pip install 'holdfast-robotics[mujoco]'")

TETRAHEDRON = hf.Mesh([[0, 0, 0], [0.3, 0, 0], [0, 0.2, 0], [0, 0, 0.1]], [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
SHAPES: dict[str, Any] = {
    "box": hf.Box((0.1, 0.2, 0.3)),
    "ball": hf.Sphere(0.1),
    "can": hf.Cylinder(0.1, 0.3),
    "pill": hf.Capsule(0.1, 0.2),
    "egg": hf.Ellipsoid((0.1, 0.2, 0.3)),
    "wedge": TETRAHEDRON,
    "table": hf.Compound(
        [hf.Part(hf.Box((1, 1, 0.1)), at(0, 0, 0.5)), hf.Part(hf.Cylinder(0.1, 0.9), material="rubber")]
    ),
}


def everything(seed: int = 0) -> hf.Scene:
    """Every shape, movable and fixed, with friction of bodies, materials and parts, and excluded pairs."""
    rng = np.random.default_rng(seed)
    bodies = [hf.Body("ground", hf.HalfSpace(), pose=pose_from(rng.normal(size=3), rng.normal(size=4)), fixed=True)]
    for k, (name, shape) in enumerate(SHAPES.items()):
        pose = pose_from(rng.normal(size=3), rng.normal(size=4))
        turn = Rotation.random(random_state=rng).as_matrix()
        inertia = turn @ np.diag([0.3, 0.4, 0.5]) @ turn.T
        given: dict[str, Any] = {"mass": 1.0 + k, "com": rng.normal(size=3) / 10, "inertia": inertia}
        bodies.append(
            hf.Body(name, shape, pose=pose, material="oak" if k % 2 else None, **(given if k % 3 else {"density": 700}))
        )
        bodies.append(
            hf.Body(f"fixed {name}", shape, pose=pose_from(rng.normal(size=3), rng.normal(size=4)), fixed=True)
        )
    names = [body.name for body in bodies]
    pairs = {pair: float(rng.uniform()) for pair in itertools.combinations(names, 2) if rng.uniform() < 0.2}
    pairs |= {("oak", "oak"): 0.25, ("oak", "rubber"): 1.25, ("box", "ball"): 0.0}
    excluded = [("box", "egg"), ("ground", "ball"), ("can", "fixed can")]
    return hf.Scene(bodies, hf.Friction(0.5, pairs), (1, -2, -9), "all", excluded)


def saved(scene: hf.Scene, folder: Path) -> Path:
    hf.save_scene(scene, folder / "scene.xml")
    return folder / "scene.xml"


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> tuple[hf.Scene, Path]:
    scene = everything()
    return scene, saved(scene, tmp_path_factory.mktemp("written"))


def test_a_scene_comes_back_as_it_was(written: tuple[hf.Scene, Path]) -> None:
    scene, path = written
    again = hf.load_scene(path)
    assert (again.name, again.gravity.tolist()) == (scene.name, scene.gravity.tolist())
    assert [(b.name, b.fixed) for b in again.bodies] == [(b.name, b.fixed) for b in scene.bodies]
    for old, new in zip(scene.bodies, again.bodies, strict=True):
        assert new.pose == pytest.approx(old.pose, abs=1e-12)
        if not old.fixed:
            assert new.mass == pytest.approx(old.mass, rel=1e-12)
            assert new.com_body == pytest.approx(old.com_body, abs=1e-12)
            assert new.inertia_com == pytest.approx(old.inertia_com, abs=1e-12 * abs(old.inertia_com).max())
    assert again.excluded == scene.excluded


def test_the_shapes_are_the_same(written: tuple[hf.Scene, Path]) -> None:
    """Meshes to the single precision that MuJoCo keeps."""
    scene, path = written
    again = hf.load_scene(path)
    for old, new in zip(scene.bodies, again.bodies, strict=True):
        if isinstance(old.shape, hf.HalfSpace):
            assert isinstance(new.shape, hf.HalfSpace)
            continue
        exact = "wedge" not in old.name
        assert np.array(new.box) == pytest.approx(np.array(old.box), abs=1e-12 if exact else 1e-6)
        volume = old.shape.mass_properties.volume
        assert new.shape.mass_properties.volume == pytest.approx(volume, rel=1e-9 if exact else 1e-6)


def frictions(scene: hf.Scene) -> dict[tuple[str, str], list[float]]:
    """The friction of every pair that may touch, of the first and the last part of each body."""
    found = {}
    for a, b in itertools.combinations(scene.bodies, 2):
        if not (a.fixed and b.fixed) and tuple(sorted((a.name, b.name))) not in scene.excluded:
            ends = [(a.materials[i], b.materials[j]) for i in (0, -1) for j in (0, -1)]
            found[a.name, b.name] = [scene.friction.between(a.name, b.name, {a.name: x, b.name: y}) for x, y in ends]
    return found


def test_the_friction_of_every_pair_is_the_same(written: tuple[hf.Scene, Path]) -> None:
    scene, path = written
    again = frictions(hf.load_scene(path))
    for pair, values in frictions(scene).items():
        assert again[pair] == pytest.approx(values, abs=1e-12), pair


def test_mujoco_sees_the_same_masses(written: tuple[hf.Scene, Path]) -> None:
    scene, path = written
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    for body in scene.movable:
        k = model.body(body.name).id
        assert model.body_mass[k] == pytest.approx(body.mass, rel=1e-12)
        assert data.xipos[k] == pytest.approx(body.com_world, abs=1e-12)
        turn = data.ximat[k].reshape(3, 3)
        own = body.pose[:3, :3]
        assert turn @ np.diag(model.body_inertia[k]) @ turn.T == pytest.approx(
            own @ body.inertia_com @ own.T, abs=1e-12
        )


def test_mujoco_touches_what_holdfast_says_with_the_same_friction(tmp_path: Path) -> None:
    """Balls in one place touch all others that they may."""
    rng = np.random.default_rng(3)
    bodies = [hf.Body("b0", hf.Sphere(0.1), fixed=True)]
    bodies += [hf.Body(f"b{k}", hf.Sphere(0.1), mass=1, pose=at(0.001 * k, 0, 0)) for k in range(1, 9)]
    every = list(itertools.combinations([body.name for body in bodies], 2))
    pairs = {pair: float(rng.choice([0, 0.2, 0.5, 0.9])) for pair in every}
    excluded = [every[k] for k in rng.choice(len(every), 8, replace=False)]
    model = mujoco.MjModel.from_xml_path(
        str(saved(hf.Scene(bodies, hf.Friction(pairs=pairs), excluded=excluded), tmp_path))
    )
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    found = {}
    for geoms, dim, friction in zip(data.contact.geom, data.contact.dim, data.contact.friction[:, 0], strict=True):
        a, b = sorted(model.body(model.geom_bodyid[g]).name for g in geoms)
        found[a, b] = 0.0 if dim == 1 else friction
    assert found == pytest.approx({pair: mu for pair, mu in pairs.items() if pair not in excluded}, abs=1e-12)


def test_a_scene_of_one_coefficient_needs_no_pairs(tmp_path: Path) -> None:
    for friction in (0.6, hf.Friction(0.6, {("cube0", "cube1"): 0.2})):
        scene = hf.Scene(
            [floor(), *(box(f"cube{k}", (0.1,) * 3, 1, (0, 0, 0.05 + 0.1 * k)) for k in range(9))], friction
        )
        content = saved(scene, tmp_path).read_text()
        assert "<pair" not in content
        assert 'condim="1"' not in content
    for name in ("stack", "arch", "v_groove", "tabletop"):
        shipped = hf.shipped_scene(name)
        again = hf.load_scene(saved(shipped, tmp_path))
        assert [b.name for b in again.bodies] == [b.name for b in shipped.bodies]
        touching = [interface.bodies for interface in hf.assemble(shipped).interfaces]
        assert [again.mu(*pair) for pair in touching] == pytest.approx([shipped.mu(*pair) for pair in touching])


@pytest.mark.parametrize(
    ("bodies", "friction", "match"),
    [
        ([floor(), box("world", (1, 1, 1), 1, (0, 0, 0))], 0.5, r"body 'world': has the name of MuJoCo's world"),
        ([floor(), box("a\x00b", (1, 1, 1), 1, (0, 0, 0))], 0.5, r"name 'a\\x00b': holds what XML cannot"),
        ([floor(), box("a", (1, 1, 1), 1, (0, 0, 0))], hf.Friction(), r"friction of \('.*', '.*'\): is not given"),
        (
            [floor(), hf.Body("a", hf.Box((1, 1, 1)), mass=1, inertia=np.diag([1.0, 1, 9]))],
            0.5,
            r"body 'a': has the principal moments 1, 1, 9 kg m²; MuJoCo needs",
        ),
    ],
)
def test_what_mujoco_cannot_hold_is_refused_before_writing(
    bodies: Any, friction: Any, match: str, tmp_path: Path
) -> None:
    with pytest.raises(hf.errors.SceneError, match=match):
        hf.save_scene(hf.Scene(bodies, friction), tmp_path / "scene.xml")
    assert not any(tmp_path.iterdir())


def test_names_are_kept_whatever_they_are(tmp_path: Path) -> None:
    names = ["a/0", "a", "<b> & 'c' \"d\"", "ö é 漢", " edge "]
    bodies = [box(name, (0.1,) * 3, 1, (k, 0, 0.05)) for k, name in enumerate(names)]
    assert [b.name for b in hf.load_scene(saved(hf.Scene([floor(), *bodies], 0.5), tmp_path)).movable] == names
