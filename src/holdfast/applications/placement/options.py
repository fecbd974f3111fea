"""The conditions that a placement must meet and the weights that bias it, with checks of their values."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import Float, checked, checked_items, checked_number
from holdfast.base.errors import SceneError, message
from holdfast.base.ranges import EXPONENT, LENGTH
from holdfast.base.rigid import checked_pose, tangents
from holdfast.base.text import quoted
from holdfast.engines.imperfect import Imperfect
from holdfast.scene.friction import Friction

UPRIGHT, ANY = "upright", "any"  # words for orientations


@dataclass(frozen=True)
class Weights:
    """The exponents that bias the choice of a placement; 0 means no influence.

    ``robustness`` applies to R / (R + weight of the object) at a point of the scene, ``level`` to the vertical
    component of the normal there, and ``steadiness`` to the tilt at which the object still stands on a face. Raises
    HoldfastError if an exponent is negative.
    """

    robustness: float = 2.0
    level: float = 1.0
    steadiness: float = 1.0

    def __post_init__(self) -> None:
        for name in ("robustness", "level", "steadiness"):
            checked_number(getattr(self, name), f"Weights: {name}", minimum=0, within=EXPONENT)


@dataclass(frozen=True, eq=False)
class Options:
    """The checked options of a placement; Where, Approach and Search describe them.

    ``cone`` is in radians, and ``box`` (2, 3) [m] may be infinite.
    """

    box: Float
    supports: tuple[str, ...]
    least_supports: int
    avoid: tuple[str, ...]
    orientations: Float | None
    free_yaw: bool
    lean_degrees: float
    approach: Float | None
    weights: Weights
    friction: Friction
    mass_margin: float
    spacing: float
    imperfect: Imperfect | None = None
    prefer_upright: bool = True
    keep_out: tuple[Float, ...] = ()
    next_to: str | None = None
    cone: float = 0.0
    gripper: Float | None = None

    @property
    def from_afar(self) -> bool:
        """Whether the object must start above the scene, because its way in is checked."""
        return self.approach is not None or self.gripper is not None


def checked_region(region: object, up: Float, where: str = "Where: box") -> Float:
    """Return the low and the high corner (2, 3) [m] of the region.

    A region (2, 2) is horizontal and reaches from minus to plus infinity along the vertical.
    """
    if region is None:
        return np.array([[-np.inf] * 3, [np.inf] * 3])
    try:
        box = np.array(region, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        raise SceneError(message(where, f"is {quoted(region)}", "needs the low and the high corner of a box")) from None
    if box.shape == (2, 2):
        if np.abs(up[:2]).max() > 1e-9:
            raise SceneError(message(where, "has two coordinates, but up is not z", "give three"))
        box = np.column_stack([box, [-np.inf, np.inf]])
    if box.shape != (2, 3) or np.isnan(box).any():
        raise SceneError(message(where, f"has shape {box.shape}", "needs (2, 2) or (2, 3): low and high corner [m]"))
    if not (box[0] < box[1]).all():
        raise SceneError(message(where, f"low {box[0].tolist()}, high {box[1].tolist()}", "needs low < high"))
    return box


def names_of(assembly: Assembly, names: Sequence[str], option: str) -> tuple[str, ...]:
    """Return the names as a tuple; raises SceneError for a name that no body of the scene has."""
    found = checked_items(names, f"Where: {option}", "names of bodies")
    if option == "supports" and not found:
        raise SceneError(message(f"Where: {option}", f"is {quoted(names)}", "needs a list of names of bodies"))
    return tuple(assembly.scene.body(name).name for name in found)


def checked_orientations(value: Any, up: Float) -> Float | None:  # noqa: ANN401
    """Return the allowed rotations (k, 3, 3), or None if every rotation is allowed.

    "upright" allows those in which the object's own third axis points along ``up`` (3,).
    """
    if value is None or (isinstance(value, str) and value == ANY):
        return None
    where = "Approach: orientations"
    if isinstance(value, str):
        if value != UPRIGHT:
            raise SceneError(
                message(where, f"is {quoted(value)}", f"needs {UPRIGHT!r}, {ANY!r} or rotations (k, 3, 3)")
            )
        return np.array([np.column_stack([*tangents(up), up])])
    single = np.asarray(value, dtype=object).ndim == 2
    turns = checked([value] if single else value, (None, 3, 3), where)
    if not len(turns):
        raise SceneError(message(where, "is empty", "give rotations (k, 3, 3), or None for any"))
    poses = np.tile(np.eye(4), (len(turns), 1, 1))
    poses[:, :3, :3] = turns
    return np.array([checked_pose(pose, f"{where}[{k}]")[:3, :3] for k, pose in enumerate(poses)])


def checked_keep_out(value: Any, up: Float) -> tuple[Float, ...]:  # noqa: ANN401
    """Return the regions to keep out of, each with its low and high corner (2, 3) [m]."""
    where = "Where: keep_out"
    regions = checked_items(value, where, "regions, each with a low and a high corner")
    if any(region is None for region in regions):
        raise SceneError(message(where, "holds None, which is everywhere", "give regions, or leave it out"))
    return tuple(checked_region(region, up, f"{where}[{k}]") for k, region in enumerate(regions))


def checked_gripper(value: Any) -> Float | None:  # noqa: ANN401
    """Return the low and the high corner (2, 3) [m] of the gripper's box, or None."""
    if value is None:
        return None
    where = "Approach: gripper"
    box = checked(value, (2, 3), where, within=LENGTH)
    if not (box[0] < box[1]).all():
        raise SceneError(message(where, f"low {box[0].tolist()}, high {box[1].tolist()}", "needs low < high"))
    return box
