"""Each constant of the motion is seen: three times or a third of it changes what a small scene does.

What it does is the verdict, the number of steps, of contacts in all programs, and the poses to a nanometre. Limits of
effort, and constants that compiled code has taken in (TURNED, LEAN, BESIDE), cannot be moved here.
"""

from __future__ import annotations

from functools import cache
from importlib import import_module
from typing import Any

import numpy as np
import pytest

import holdfast as hf
from holdfast.settling.motion import Group
from holdfast.settling.moved_surfaces import rotation_of


@cache
def scene(name: str) -> hf.Scene:
    """A shipped scene, its movable bodies some 1.5 mm and half a degree from their places."""
    true, rng, poses = hf.shipped_scene(name), np.random.default_rng(0), {}
    for body in true.movable:
        pose = body.pose.copy()
        pose[:3, :3] = rotation_of(np.radians(0.5) * rng.normal(size=3)) @ pose[:3, :3]
        pose[:3, 3] += 1.5e-3 * rng.normal(size=3)
        poses[body.name] = pose
    return true.moved(poses)


def done(name: str) -> tuple[Any, ...]:
    """What settling does in a scene."""
    solved = Group._solved
    contacts = []

    def counted(group: Group, *given: Any, **more: Any) -> Any:
        before = group.effort
        motion = solved(group, *given, **more)
        contacts.append(group.effort - before)
        return motion

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Group, "_solved", counted)
        result = hf.settle(scene(name))
    poses = np.array([body.pose[:3] for body in result.scene.movable])
    return result.status, result.steps, sum(contacts), np.round(poses, 9).tolist()


usual = cache(done)

SEEN = [
    ("motion", "STRIDE", 3, "slope"),
    ("motion", "STRIDE", 1 / 3, "slope"),
    ("motion", "FIRST", 3, "cube"),
    ("motion", "FIRST", 1 / 3, "cube"),
    ("motion", "WIDE", 3, "cantilever"),
    ("motion", "WIDE", 1 / 3, "v_groove"),
    ("motion", "NARROW", 3, "cube"),
    ("motion", "NARROW", 1 / 3, "v_groove"),
    ("motion", "EAGER", 3, "v_groove"),
    ("motion", "EAGER", 1 / 3, "v_groove"),
    ("motion", "TOUCH", 3, "stack"),
    ("motion", "POLISH", 3, "cube"),
    ("motion", "POLISH", 1 / 3, "cube"),
    ("motion", "FLUNG", 1 / 3, "stack"),
    ("motion", "BALL", 3, "cube"),
    ("motion", "BALL", 1 / 3, "slope"),
    ("motion", "RECOVERY", 1 / 3, "slope"),
    ("settling_program", "VIOLATED", 3, "stack"),
    ("settling_program", "LEFT", 3, "cube"),
    ("settling_program", "LEFT", 1 / 3, "cube"),
    ("settling_program", "SOON", 3, "cube"),
    ("settling_program", "SOON", 1 / 3, "slope"),
    ("settling_program", "MORE", 3, "cube"),
    ("settling_program", "MORE", 1 / 3, "cube"),
    ("near_points", "MOST", 3, "cube"),
    ("near_points", "MOST", 1 / 3, "cube"),
    ("near_points", "SHARP", 1 / 3, "slope_two"),
    ("shared_volume", "SAME_DEPTH", 1 / 3, "stack"),
]  # one factor alone where the other is not seen


@pytest.mark.parametrize(("module", "name", "factor", "where"), SEEN)
def test_a_constant_that_is_moved_by_a_factor_of_three_is_seen(
    module: str, name: str, factor: float, where: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = usual(where)
    home = import_module(f"holdfast.settling.{module}")
    value = getattr(home, name)
    monkeypatch.setattr(home, name, type(value)(value * factor + (0.5 if isinstance(value, int) else 0)))
    assert done(where) != before
