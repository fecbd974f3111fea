"""Accelerations of a carrier under uncertainty: closed forms, and the scenes of all samples built by hand."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import holdfast as hf
from bench.scenes.shelf import shelf
from holdfast.scene.shipped.blocks import at, box, cube, floor, stack

G = 9.81
X = (1.0, 0, 0)
WAYS = [(1.0, 0, 0), (0, 1.0, 0), (-0.6, -0.8, 0)]


def test_slip_is_mu_g_whatever_the_masses() -> None:
    """A cube slips on its carrier at mu g, so sampled masses change nothing and friction alone counts."""
    doubts = hf.sets.Uncertain(mu_range=(0.2, 0.8), mass_range=0.5, samples=40, seed=3)
    found = hf.transport_under(cube(), X, doubts, engine="limit")
    level = found.acceleration[:, 0] / G
    assert 0.2 <= level.min() < 0.25
    assert 0.75 < level.max() <= 0.8
    light = hf.transport_under(cube(), X, dataclasses.replace(doubts, mass_range=None), engine="limit")
    np.testing.assert_allclose(found.acceleration, light.acceleration, rtol=1e-6)
    assert found.nominal[0] == pytest.approx(0.6 * G, rel=1e-6)
    assert (found.stands, found.undecided, found.samples, found.seed) == (1, 0, 40, 3)


def test_pushes_follow_the_sampled_mass() -> None:
    """A cube pushed low holds mu m g: its forces are uniform between those of the lightest and the heaviest."""
    doubts = hf.sets.Uncertain(mass_range={"cube": (0.5, 2.0)}, samples=60, seed=1)
    found = hf.robustness_under(cube(), "cube", (-0.05, 0, 0.001), X, doubts, engine="limit")
    mass = found.force[:, 0] / (0.6 * G)
    assert 0.5 <= mass.min() < 0.6
    assert 1.9 < mass.max() <= 2.0
    assert mass.mean() == pytest.approx(1.25, abs=3.3 * 1.5 / np.sqrt(12 * 60))


def test_masses_are_independent_of_each_other_and_of_all_else() -> None:
    doubts = hf.sets.Uncertain(mu_range=0.3, samples=4, seed=2)
    pushed = ("cube1", (-0.05, 0, 0.01), X)
    alone = hf.robustness_under(stack(), *pushed, doubts, engine="limit").force
    heavy = dataclasses.replace(doubts, mass_range=dict.fromkeys(("cube1", "cube2", "cube3"), (0.5, 1.5)))
    ratio = hf.robustness_under(stack(), *pushed, heavy, engine="limit").force / alone
    levels = np.random.default_rng(2).spawn(1)[0].random((4, 3))
    np.testing.assert_allclose(ratio[:, 0], (0.5 + levels).mean(1), rtol=1e-6)


def test_a_tilted_carrier_takes_off_what_it_needs_at_rest() -> None:
    """Tilted by t about y, x leads down: the slope helps there, g (mu cos t + sin t), and takes as much off uphill."""
    found = hf.transport_under(
        cube(),
        [X, (-1, 0, 0)],
        hf.sets.Uncertain(mu_range=(0.4, 0.4), samples=2),
        tilt_degrees=(0, 10, 0),
        engine="limit",
    )
    t = np.radians(10)
    np.testing.assert_allclose(found.acceleration[0], G * (0.4 * np.cos(t) + np.array([1, -1]) * np.sin(t)))
    np.testing.assert_allclose(found.nominal, G * (0.6 * np.cos(t) + np.array([1, -1]) * np.sin(t)), rtol=1e-6)


def test_only_these_bodies_count() -> None:
    """A ball rolls at once; the box beside it slips at mu g."""
    ball = hf.Body("ball", hf.Sphere(0.05), mass=1, pose=at(0.5, 0, 0.05))
    scene = hf.Scene([floor(), box("cube", (0.1, 0.1, 0.1), 1, (0, 0, 0.05)), ball], 0.5)
    doubts = hf.sets.Uncertain(mu_range=(0.3, 0.5), samples=3)
    assert hf.transport_under(scene, X, doubts, engine="limit").quantile(1)[0] < 0.05
    found = hf.transport_under(scene, X, doubts, engine="limit", bodies=["cube"])
    assert (found.acceleration >= 0.3 * G * (1 - 1e-6)).all()
    assert any("ball" in note for note in found.notes)


def test_a_sample_that_falls_counts_as_zero() -> None:
    """A cube that hangs over by 45 % of its length falls in some samples; there no acceleration holds."""
    block = hf.Body("block", hf.Box((0.1, 0.1, 0.1)), pose=at(0, 0, 0.05), fixed=True)
    scene = hf.Scene([block, box("cube", (0.1, 0.1, 0.1), 1, (0.045, 0, 0.15))], 0.6)
    found = hf.transport_under(scene, X, hf.sets.Uncertain(pose_sigma=0.005, samples=60, seed=1))
    assert 0.6 < found.stands < 0.95
    still = found.status[:, 0] == hf.Status.FINITE
    assert (found.acceleration[~still] == 0).all()
    assert found.quantile(0.01)[0] == 0
    assert found.stands == pytest.approx(still.mean())
    assert repr(found).startswith("TransportUnder(60 samples of assembly on its carrier")


def eight_things() -> hf.Scene:
    """Eight unlike things on a board that is the carrier: round, thin, of two parts, one on another, a tall vase."""
    bodies = [dataclasses.replace(body, fixed=True) if body.name == "board" else body for body in shelf().bodies]
    vase = hf.Body("vase", hf.Cylinder(0.03, 0.25), mass=0.8, pose=at(-0.15, -0.05, 0.155), material="clay")
    return hf.Scene([*bodies, vase], shelf().friction, name="shelf")


STILL = ["tin", "book", "bowl", "vase"]  # a ball and a pen roll at once on a board that is not level
SCENES: dict[str, Any] = {
    "stack": stack,
    "table": lambda: hf.shipped_scene("table"),
    "shelf": eight_things,
}


@pytest.mark.parametrize(("name", "engine"), [("stack", "limit"), ("table", "compliant"), ("shelf", "limit")])
def test_samples_are_the_scenes_that_one_would_build(name: str, engine: str) -> None:
    """Built by hand from the stated distributions, found and asked anew: poses, one level of friction, own masses."""
    scene: hf.Scene = SCENES[name]()
    sigma, low, high, count, seed = (0.0003, 0.05), 0.45, 0.6, 3, 5
    gap = 1e-3
    bodies = STILL if name == "shelf" else None
    doubts = hf.sets.Uncertain(pose_sigma=sigma, mu_range=(low, high), mass_range=0.3, samples=count, seed=seed)
    found = hf.transport_under(hf.assemble(scene, gap=gap), WAYS, doubts, engine=engine, bodies=bodies)
    rng, masses = np.random.default_rng(seed), np.random.default_rng(seed).spawn(1)[0]
    movable = [body for body in scene.bodies if not body.fixed]
    gap = 4 * np.sqrt((gap / 4) ** 2 + 2 * sigma[0] ** 2)
    for limits, status in zip(found.acceleration, found.status, strict=True):
        level, deviates, heavier = rng.random(), rng.standard_normal((len(movable), 6)), masses.random(len(movable))
        changed = [body for body in scene.bodies if body.fixed]
        for body, d, share in zip(movable, deviates, heavier, strict=True):
            there, back, turn = np.eye(4), np.eye(4), np.eye(4)
            there[:3, 3], back[:3, 3] = body.com_world + sigma[0] * d[:3], -body.com_world
            turn[:3, :3] = Rotation.from_rotvec(np.radians(sigma[1]) * d[3:]).as_matrix()
            assert body.mass is not None
            mass = body.mass * (0.7 + 0.6 * share)
            changed.append(dataclasses.replace(body, pose=there @ turn @ back @ body.pose, mass=mass, density=None))
        assembly = hf.assemble(
            hf.Scene(changed, low + level * (high - low)), pose_sigma=(gap / 4, np.sqrt(2) * sigma[1])
        )
        again = hf.transport_limits(assembly, WAYS, engine=engine, bodies=bodies)
        assert again.status.tolist() == status.tolist()
        np.testing.assert_allclose(limits, again.acceleration, rtol=1e-3, atol=1e-9)
    assert np.ptp(found.acceleration, axis=0).min() > 0


@pytest.mark.parametrize(
    ("changes", "match"),
    [
        ({"uncertain": hf.sets.Uncertain(mass_range=1.5)}, r"mass_range: relative width 1\.5; needs less than 1"),
        ({"uncertain": hf.sets.Uncertain(mass_range={"floor": (1, 2)})}, r"'floor' is fixed; name movable bodies"),
        ({"bodies": ["floor"]}, r"'floor' is fixed"),
    ],
)
def test_what_makes_no_sense_is_refused(changes: dict[str, Any], match: str) -> None:
    with pytest.raises(hf.HoldfastError, match=match):
        hf.transport_under(cube(), **{"directions": X, "engine": "limit"} | changes)
