"""Edits of an assembly in the live view: the pose of a body in numbers, and its mass."""

from __future__ import annotations

from dataclasses import replace
from typing import Final, NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import Float, checked, checked_number
from holdfast.base.ranges import MASS, PLACE

UPRIGHT: Final = 1e-7  # [-] below this the level part of a body's x axis has no direction


class Place(NamedTuple):
    """The pose of a body as numbers.

    ``position`` (3,) [m] is the origin of its frame, and ``turn`` (3,) [degrees] are its rotations about the world's x,
    y and z axes, one after the other.
    """

    position: Float
    turn: Float


def place_of(assembly: Assembly, name: str) -> Place:
    """Return the place of a body of the assembly."""
    pose = assembly.scene.body(name).pose
    return Place(pose[:3, 3].copy(), _turn_of(pose[:3, :3]))


def pose_of(place: Place) -> Float:
    """Return the pose (4, 4) of a body at this place."""
    pose = np.eye(4)
    pose[:3, :3] = Rotation.from_euler("xyz", checked(place.turn, (3,), "turn"), degrees=True).as_matrix()
    pose[:3, 3] = checked(place.position, (3,), "position", within=PLACE)
    return pose


def weighing(assembly: Assembly, name: str, mass: float) -> Assembly:
    """Return the assembly with another mass [kg] of a movable body; its contacts stay the same."""
    mass = checked_number(mass, f"mass of {name}", above=0, within=MASS)
    scene = assembly.scene
    bodies = tuple(replace(body, mass=mass, density=None) if body.name == name else body for body in scene.bodies)
    return replace(assembly, scene=replace(scene, bodies=bodies))


def _turn_of(rotation: Float) -> Float:
    """Return the angles (3,) [degrees] of a rotation (3, 3) about x, then y, then z.

    At 90 degrees about y (gimbal lock), the angle about z is set to 0.
    """
    level = np.hypot(rotation[0, 0], rotation[1, 0])
    about_y = np.arctan2(-rotation[2, 0], level)
    if level > UPRIGHT:
        about_x, about_z = np.arctan2(rotation[2, 1], rotation[2, 2]), np.arctan2(rotation[1, 0], rotation[0, 0])
    else:
        about_x, about_z = np.arctan2(-rotation[1, 2], rotation[1, 1]), 0.0
    return np.degrees([about_x, about_y, about_z])
