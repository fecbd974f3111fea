"""Scenes written as USD come back: poses and sizes in double precision, masses and friction in single precision."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
import pytest

import holdfast as hf
from holdfast.scene.shipped import shipped_scenes

pxr = pytest.importorskip("pxr", reason="needs usd-core, of the extra usd")

SINGLE = 2e-7  # relative precision of single numbers
TETRAHEDRON = hf.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
SHAPES = [
    hf.Box((0.1, 0.2, 0.3)),
    hf.Sphere(0.1),
    hf.Cylinder(0.1, 0.3),
    hf.Capsule(0.05, 0.2),
    hf.Ellipsoid((0.1, 0.2, 0.3)),
    TETRAHEDRON,
    hf.Compound([hf.Part(hf.Box((0.1, 0.1, 0.1)), hf.pose(yaw=30)), hf.Part(hf.Sphere(0.1), hf.pose(0.2))]),
]


def back(scene: hf.Scene, folder: Path, suffix: str = ".usda") -> hf.Scene:
    hf.save_scene(scene, folder / f"scene{suffix}")
    return hf.load_scene(folder / f"scene{suffix}")


def assert_same(found: hf.Scene, scene: hf.Scene) -> None:
    np.testing.assert_allclose(found.gravity, scene.gravity, rtol=SINGLE, atol=1e-7)
    assert [(body.name, body.fixed) for body in found.bodies] == [(body.name, body.fixed) for body in scene.bodies]
    for new, old in zip(found.bodies, scene.bodies, strict=True):
        np.testing.assert_allclose(new.pose, old.pose, atol=1e-12)
        assert type(new.shape) is type(old.shape)
        if not isinstance(old.shape, hf.HalfSpace):
            mesh = isinstance(old.shape, hf.Mesh)
            np.testing.assert_allclose(new.box, old.box, atol=1e-6 if mesh else 1e-12)
        if not old.fixed:
            assert new.mass == pytest.approx(old.mass, rel=SINGLE)
            np.testing.assert_allclose(new.com_body, old.com_body, atol=SINGLE * old.size)
            np.testing.assert_allclose(new.inertia_com, old.inertia_com, atol=1e-6 * np.abs(old.inertia_com).max())
    for a, b in itertools.combinations(scene.bodies, 2):
        if not (a.fixed and b.fixed) and (a.name, b.name) not in scene.excluded:
            assert found.mu(a.name, b.name) == pytest.approx(scene.mu(a.name, b.name), rel=SINGLE, abs=1e-8)


@pytest.mark.parametrize("suffix", [".usda", ".usdc", ".usd"])
@pytest.mark.parametrize("name", ["table", "slope", "stack"])
def test_scenes_that_come_with_holdfast(name: str, suffix: str, tmp_path: Path) -> None:
    assert name in shipped_scenes()
    scene = hf.shipped_scene(name)
    found = back(scene, tmp_path, suffix)
    assert_same(found, scene)
    assert hf.stability(found).status == hf.stability(scene).status


@pytest.mark.parametrize("seed", range(5))
def test_every_shape_anywhere(seed: int, tmp_path: Path) -> None:
    rng = np.random.default_rng(seed)
    bodies = [hf.Body("the floor / 1", hf.HalfSpace(), fixed=True, pose=hf.pose(roll=20, z=-1))]
    for k, shape in enumerate(SHAPES):
        roll, pitch, yaw = rng.uniform(-180, 180, 3)
        place = hf.pose(*rng.uniform(-3, 3, 3), roll=roll, pitch=pitch, yaw=yaw)
        at = {"pose": place, "com": rng.uniform(-0.01, 0.01, 3)} if k % 2 else {"pose": place}
        bodies.append(hf.Body(f"body {k}", shape, mass=rng.uniform(0.1, 9), **at))
    bodies.append(hf.Body("body_1", SHAPES[-1], pose=hf.pose(9), fixed=True))
    scene = hf.Scene(bodies, 0.4, (0, 3, -9), excluded=[("body 0", "body 1"), (("body 6", 1), "body 2")])
    found = back(scene, tmp_path)
    assert_same(found, scene)
    assert found.excluded == scene.excluded


@pytest.mark.parametrize(
    ("pairs", "mode"),
    [
        ({("a", "b"): 0.3, ("a", "floor"): 0.3, ("b", "floor"): 0.5}, "min"),
        ({("a", "b"): 0.5, ("a", "floor"): 0.5, ("b", "floor"): 0.3}, "max"),
        ({("a", "b"): 0.5, ("a", "floor"): 0.4, ("b", "floor"): 0.5}, "max"),
        ({("a", "b"): 0.45, ("a", "floor"): 0.5, ("b", "floor"): 0.35}, "average"),
        ({("a", "b"): 0.0, ("a", "floor"): 0.0, ("b", "floor"): 0.35}, "min"),
    ],
)
def test_a_rule_of_physx_gives_the_friction_of_every_pair(
    pairs: dict[tuple[str, str], float], mode: str, tmp_path: Path
) -> None:
    bodies = [hf.Body(name, hf.Box((1, 1, 1)), mass=1, pose=hf.pose(2 * k)) for k, name in enumerate("ab")]
    scene = hf.Scene([hf.Body("floor", hf.HalfSpace(), fixed=True), *bodies], hf.Friction(pairs=pairs))
    assert_same(back(scene, tmp_path), scene)
    assert f'frictionCombineMode = "{mode}"' in (tmp_path / "scene.usda").read_text()


def test_products_of_four_and_friction_that_no_rule_gives(tmp_path: Path) -> None:
    names, own = "abcd", dict(zip("abcd", (0.9, 0.7, 0.5, 0.8), strict=True))
    bodies = [
        hf.Body(name, hf.Box((1, 1, 1)), mass=1, fixed=name == "a", pose=hf.pose(2 * k)) for k, name in enumerate(names)
    ]
    products = {pair: own[pair[0]] * own[pair[1]] for pair in itertools.combinations(names, 2)}
    scene = hf.Scene(bodies, hf.Friction(pairs=products))
    assert_same(back(scene, tmp_path), scene)
    assert 'frictionCombineMode = "multiply"' in (tmp_path / "scene.usda").read_text()
    other = hf.Scene(bodies, hf.Friction(pairs={**products, ("b", "c"): 0.9, ("a", "d"): 0.1}))
    with pytest.raises(hf.errors.SceneError, match=r"USD has no friction of pairs: write \.yaml, \.xml or \.glb"):
        hf.save_scene(other, tmp_path / "no.usda")
    assert not (tmp_path / "no.usda").exists()


def test_a_package_is_refused(tmp_path: Path) -> None:
    with pytest.raises(hf.errors.SceneError, match=r"is a package; write \.usda or \.usdc"):
        hf.save_scene(hf.shipped_scene("table"), tmp_path / "table.usdz")


def test_usd_itself_finds_the_physics(tmp_path: Path) -> None:
    hf.save_scene(hf.shipped_scene("table"), tmp_path / "table.usda")
    stage = pxr.Usd.Stage.Open(str(tmp_path / "table.usda"))
    bodies = [prim for prim in stage.Traverse() if prim.HasAPI(pxr.UsdPhysics.RigidBodyAPI)]
    assert len(bodies) == len(hf.shipped_scene("table").bodies)
    assert all(prim.HasAPI(pxr.UsdPhysics.CollisionAPI) for body in bodies for prim in body.GetChildren())
    assert pxr.UsdGeom.GetStageUpAxis(stage) == "Z"
