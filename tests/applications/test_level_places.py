"""Level places of a rectangle: in corners, beside what stands there, never over it."""

from __future__ import annotations

import numpy as np
import pytest

import holdfast as hf
from holdfast.applications.placement.conditions import Approach
from holdfast.applications.placement.level_places import (
    LevelPlace,
    SeenFromAbove,
    frame_of,
    level_places_for,
    levels_of,
    turns_of,
)
from holdfast.applications.resting_poses import StandingFaces
from holdfast.base.arrays import Float
from holdfast.base.rigid import pose_from
from holdfast.scene.shipped.blocks import at, box

UP = np.array([0, 0, 1.0])
TURNED = pose_from(np.zeros(3), np.array([np.cos(0.3), 0, 0, np.sin(0.3)]))


def tray(pose: Float = TURNED) -> hf.Body:
    return hf.Body("tray", hf.Box((0.4, 0.3, 0.02)), pose=pose, fixed=True)


def found(thing: hf.Body, *others: hf.Body, apart: float = 0.01, inset: float = 0.01) -> list[LevelPlace]:
    ground = tray()
    axes = frame_of([ground], UP)
    outlines = [SeenFromAbove(body, UP, axes) for body in (ground, *others)]
    upright = Approach(np.eye(3))
    turns = turns_of(StandingFaces(thing).faces(), upright, UP, axes)
    return level_places_for(thing, turns, levels_of([ground], UP, axes), outlines, apart, inset)


def corners(place: LevelPlace, thing: hf.Body) -> Float:
    """The corners of the object in the axes of the tray."""
    world = thing.moved(place.pose).surface_world.vertices
    return np.asarray((np.linalg.inv(TURNED) @ np.column_stack([world, np.ones(len(world))]).T)[:3].T)


def test_an_empty_tray_has_a_place_in_every_corner_and_in_the_middle() -> None:
    thing = box("thing", (0.1, 0.06, 0.05), 1, (0, 0, 0))
    places = found(thing)
    assert len(places) == 2 * 9
    for place in places:
        at_ = corners(place, thing)
        assert at_[:, 2].min() == pytest.approx(0.01, abs=1e-9), "it stands on the top"
        assert (np.abs(at_[:, 0]) <= 0.2 - 0.01 + 1e-9).all()
        assert (np.abs(at_[:, 1]) <= 0.15 - 0.01 + 1e-9).all()
        assert place.support == 1


def test_no_place_is_closer_to_a_neighbour_than_asked_and_one_is_just_so_close() -> None:
    other = box("other", (0.1, 0.1, 0.1), 1, (0, 0, 0)).moved(TURNED @ at(0, 0, 0.06))
    thing = box("thing", (0.06, 0.06, 0.05), 1, (0, 0, 0))
    gaps = []
    for place in found(thing, other, apart=0.02):
        middle = (np.linalg.inv(TURNED) @ place.pose)[:2, 3]
        gaps.append(np.max(np.abs(middle) - 0.05 - 0.03))
    assert min(gaps) == pytest.approx(0.02, abs=1e-6)
    full = box("full", (0.4, 0.3, 0.1), 1, (0, 0, 0)).moved(TURNED @ at(0, 0, 0.06))
    assert not found(thing, full)


@pytest.mark.parametrize(("length", "stands"), [(0.45, True), (0.65, True), (0.68, False), (1.2, False)])
def test_three_fifths_of_the_face_must_lie_on_the_tray(length: float, stands: bool) -> None:
    """The tray is 0.4 m long: of a plank of 0.65 m, 0.615 can lie on it, and of one of 0.68 m, 0.588."""
    assert bool(found(box("plank", (length, 0.06, 0.02), 1, (0, 0, 0)), inset=0.0)) is stands


@pytest.mark.parametrize(("slot", "free"), [(0.101, True), (0.09, False)])
def test_a_place_beside_one_neighbour_is_no_place_if_it_is_too_near_to_another(slot: float, free: bool) -> None:
    """Between two walls a cube of 6 cm has 2 cm to either side, or 2 cm to one side and 1 cm to the other."""
    left, right = (
        box(name, (0.1, 0.3, 0.1), 1, (0, 0, 0)).moved(TURNED @ at(side * (slot + 0.1) / 2, 0, 0.06))
        for name, side in (("left", -1), ("right", 1))
    )
    thing = box("thing", (0.06, 0.06, 0.05), 1, (0, 0, 0))
    assert bool(found(thing, left, right, apart=0.02)) is free


def test_what_is_higher_than_the_object_is_not_in_the_way() -> None:
    thing = box("thing", (0.06, 0.06, 0.05), 1, (0, 0, 0))
    for height, free in ((0.045, False), (0.055, True)):
        board = box("board", (0.4, 0.3, 0.02), 1, (0, 0, 0)).moved(TURNED @ at(0, 0, 0.01 + height + 0.01))
        assert bool(found(thing, board)) is free


def test_the_rim_of_a_tray_keeps_its_distance() -> None:
    """A tray of one piece: its rim is part of the body on which the object stands."""
    parts = [hf.Part(hf.Box((0.4, 0.3, 0.02)))]
    parts += [hf.Part(hf.Box((0.4, 0.01, 0.05)), pose=at(0, s * 0.145, 0.015)) for s in (-1, 1)]
    parts += [hf.Part(hf.Box((0.01, 0.3, 0.05)), pose=at(s * 0.195, 0, 0.015)) for s in (-1, 1)]
    rimmed = hf.Body("tray", hf.Compound(parts), fixed=True)
    thing = box("thing", (0.1, 0.06, 0.08), 1, (0, 0, 0))
    axes = frame_of([rimmed], UP)
    levels = [level for level in levels_of([rimmed], UP, axes) if level.height < 0.02]
    turns = turns_of(StandingFaces(thing).faces(), Approach(np.eye(3)), UP, axes)
    places = level_places_for(thing, turns, levels, [SeenFromAbove(rimmed, UP, axes)], 0.005, 0.005)
    assert places
    for place in places:
        world = thing.moved(place.pose).surface_world.vertices
        assert (np.abs(world[:, 0]) <= 0.19 - 0.005 + 1e-6).all()
        assert (np.abs(world[:, 1]) <= 0.14 - 0.005 + 1e-6).all()


def test_the_faces_on_which_a_cup_is_put() -> None:
    cup = hf.Body("cup", hf.Cylinder(0.03, 0.1), mass=1)
    axes = np.eye(3)[:2]
    turns = turns_of(StandingFaces(cup).faces(), Approach(), UP, axes)
    assert [turn[2, 2].round(9) for turn in turns] == [1, 1, -1, -1], "upright first, never on a round side"
    assert len(turns_of(StandingFaces(cup).faces(), Approach(np.eye(3)), UP, axes)) == 2
