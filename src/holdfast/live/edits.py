"""Edits of an assembly by numbers that somebody types: a body's pose and mass, and the friction of a pair."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import Float, checked, checked_number
from holdfast.base.ranges import MASS, PLACE


class Place(NamedTuple):
    """Where a body is, as numbers to type.

    ``position`` (3,) [m] is the origin of its frame, and ``turn`` (3,) [degrees] are its rotations about the world's x,
    y and z, one after the other.
    """

    position: Float
    turn: Float


def place_of(assembly: Assembly, name: str) -> Place:
    """Return where a body of the assembly is."""
    pose = assembly.scene.body(name).pose
    return Place(pose[:3, 3].copy(), Rotation.from_matrix(pose[:3, :3]).as_euler("xyz", degrees=True))


def placed(assembly: Assembly, name: str, place: Place) -> Assembly:
    """Return the assembly with a body at another place; contacts are sought anew where it was and is."""
    pose = np.eye(4)
    pose[:3, :3] = Rotation.from_euler("xyz", checked(place.turn, (3,), "turn"), degrees=True).as_matrix()
    pose[:3, 3] = checked(place.position, (3,), "position", within=PLACE)
    return assembly.moved({name: pose})


def weighing(assembly: Assembly, name: str, mass: float) -> Assembly:
    """Return the assembly with another mass [kg] of a movable body, distributed as before; its contacts stay."""
    mass = checked_number(mass, f"mass of {name}", above=0, within=MASS)
    scene = assembly.scene
    bodies = tuple(replace(body, mass=mass, density=None) if body.name == name else body for body in scene.bodies)
    return replace(assembly, scene=replace(scene, bodies=bodies))


def rubbing(assembly: Assembly, pair: tuple[str, str], mu: float) -> Assembly:
    """Return the assembly with another friction coefficient between two bodies; its contacts stay."""
    return assembly.with_friction({pair: mu})
