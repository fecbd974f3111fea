"""The stiffness of contacts per area, one number for all of them or one for each pair of bodies or of materials."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeAlias

import numpy as np

from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import Float, checked_number
from holdfast.base.ranges import STIFFNESS
from holdfast.scene.friction import check_known, checked_pairs, number_between

Stiffness: TypeAlias = float | Mapping[tuple[str, str], float] | None

WHAT = "Compliant: stiffness"  # in error messages


def checked_stiffness(stiffness: Stiffness) -> Stiffness:
    """Return ``stiffness``, a mapping as a read-only table; raise SceneError if it makes no sense in any scene."""
    if isinstance(stiffness, Mapping):
        return checked_pairs(stiffness, WHAT, WHAT, above=0, within=STIFFNESS)
    return None if stiffness is None else checked_number(stiffness, WHAT, above=0, within=STIFFNESS)


def check_stiffness(assembly: Assembly, stiffness: Stiffness) -> None:
    """Raise SceneError if ``stiffness`` names something that is neither a body nor a material.

    What counts are the names of the whole: if ``assembly`` is a part of a larger one, the names in ``absent`` are
    known, too. Bodies need not touch.
    """
    if isinstance(stiffness, Mapping):
        known = {*assembly.absent, *assembly.scene.names}
        check_known(stiffness, known, WHAT)


def stiffness_of(assembly: Assembly, stiffness: Stiffness) -> Float:
    """Return the stiffness per area (interfaces,), relative to that of interfaces that are not named."""
    if not isinstance(stiffness, Mapping):
        return np.ones(len(assembly.interfaces))
    materials = assembly.scene.materials
    found = [number_between(stiffness, *interface.bodies, materials) for interface in assembly.interfaces]
    return np.array([1.0 if value is None else value for value in found])
