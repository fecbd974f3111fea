"""Families of random assemblies: seeded, without overlaps, standing in most draws, and pushed where one can."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import holdfast as hf
from bench.scenes.random_assemblies import (
    FAMILIES,
    block,
    standing,
    with_ball,
    with_falling,
    with_floating,
    with_frictionless_pair,
)
from bench.scenes.random_pushes import columns, random_pushes
from holdfast.geometry.distance import distance_to_surface

DRAWS = 6
BESIDE = (with_ball, with_floating, with_falling)


def generator(seed: int) -> np.random.Generator:
    return np.random.default_rng(seed)


def test_there_are_fourteen_families_of_movable_bodies() -> None:
    assert len(FAMILIES) == 14
    assert all(family(generator(0)).name == name for name, family in FAMILIES.items())
    assert max(len(family(generator(seed)).movable) for family in FAMILIES.values() for seed in range(5)) <= 9


@pytest.mark.parametrize("name", FAMILIES)
def test_a_seed_decides_everything(name: str) -> None:
    family = FAMILIES[name]
    assert family(generator(3)) == family(generator(3))
    assert family(generator(3)) != family(generator(4))


@pytest.mark.parametrize("name", FAMILIES)
def test_most_draws_stand_and_none_overlaps(name: str) -> None:
    rng, stable = generator(5), 0
    for _ in range(DRAWS):
        scene = FAMILIES[name](rng)
        with warnings.catch_warnings():
            warnings.simplefilter("error", hf.errors.HoldfastWarning)
            assembly = hf.assemble(scene)
        assert assembly.overlaps == ()
        assert assembly.hanging == ()
        stable += hf.stability(assembly, engine="limit").status is hf.Status.STABLE
    assert stable >= DRAWS - 2


@pytest.mark.parametrize("name", FAMILIES)
def test_pushes_are_on_exposed_surfaces_and_within_the_cone(name: str) -> None:
    rng = generator(6)
    assembly = standing(FAMILIES[name], rng)
    pushes = random_pushes(assembly, rng, 12, slant=60)
    assert len(pushes) == 12
    for body, point, direction in pushes:
        surface = assembly.scene.body(body).surface_world
        assert not assembly.scene.body(body).fixed
        assert distance_to_surface(point[None], surface)[0] < 1e-9
        assert np.linalg.norm(direction) == pytest.approx(1)
        triangles = surface.vertices[surface.faces]
        here = np.abs(((point - triangles[:, 0]) * surface.normals).sum(1)) < 1e-9  # faces in whose plane the point is
        assert (surface.normals[here] @ direction).min() <= -np.cos(np.radians(60)) + 1e-9
    assert columns(assembly, pushes).shape == (6 * len(assembly.movable), 12)


def test_pushes_are_straight_or_spread_over_the_cone() -> None:
    rng = generator(7)
    assembly = standing(block, rng)
    sides = assembly.movable[0].surface_world.normals
    straight = np.array([push.direction for push in random_pushes(assembly, rng, 40)])
    np.testing.assert_allclose((straight @ sides.T).min(1), -1)
    slanted = np.array([push.direction for push in random_pushes(assembly, rng, 40, slant=60)])
    tilt = np.degrees(np.arccos(np.clip(-(slanted @ sides.T).min(1), -1, 1)))
    assert tilt.max() > 30  # between 45° and 60° another side may be nearer to the direction
    assert tilt.min() < 30


def test_nobody_pushes_on_a_face_that_rests_on_another() -> None:
    rng = generator(8)
    assembly = standing(block, rng)
    pushes = random_pushes(assembly, rng, 100)
    assert min(push.point[2] for push in pushes) > 1e-3
    assert not any(push.direction[2] > 0.5 for push in pushes)


def test_a_family_that_never_stands_is_named() -> None:
    def falls(rng: np.random.Generator) -> hf.Scene:
        return with_floating(block(rng), rng)

    with pytest.raises(hf.HoldfastError, match=r"'falls'.*none of 50 draws stands"):
        standing(falls, generator(9))


@pytest.mark.parametrize("name", FAMILIES)
def test_what_is_added_beside_touches_the_floor_at_most(name: str) -> None:
    rng = generator(10)
    scene = before = FAMILIES[name](rng)
    for add in BESIDE:
        scene = add(scene, rng)
    assert [body.name for body in scene.bodies[len(before.bodies) :]] == ["ball", "floating", "falling"]
    assembly = hf.assemble(scene)
    assert assembly.overlaps == ()
    added = {"ball", "floating", "falling"}
    touching = {interface.bodies for interface in assembly.interfaces if added & set(interface.bodies)}
    assert {frozenset(pair) for pair in touching} == {frozenset(("ball", "floor")), frozenset(("falling", "floor"))}
    assert assembly.hanging == (("floating",),)


def test_a_ball_stands_and_a_box_over_the_edge_falls() -> None:
    rng = generator(11)
    scene = standing(block, rng).scene
    assert hf.stability(hf.assemble(with_ball(scene, rng)), engine="limit").status is hf.Status.STABLE
    fallen = hf.stability(hf.assemble(with_falling(scene, rng)), engine="limit")
    assert fallen.status is hf.Status.UNSTABLE
    assert fallen.mechanism is not None
    assert fallen.mechanism.moving == ("falling",)


def test_one_touching_pair_loses_its_friction() -> None:
    rng = generator(12)
    scene = FAMILIES["wall"](rng)
    slippery = hf.assemble(with_frictionless_pair(scene, rng))
    assert sum(mu == 0 for mu in slippery.mu) == 1
    assert sum(mu == 0 for mu in hf.assemble(scene).mu) == 0
