"""Masses of bodies and colliders in USD, given or by density, with the priorities that UsdPhysics prescribes."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from holdfast.base.arrays import Float, checked, checked_number
from holdfast.base.errors import located
from holdfast.base.ranges import DENSITY, INERTIA, MASS, SCALE
from holdfast.base.rigid import pose_from
from holdfast.scene.compound import Inertial, together
from holdfast.scene.formats.rigid_parts import Piece
from holdfast.scene.formats.usd.stage import Stage
from holdfast.scene.formats.usd.usd_colliders import number_of, numbers_of, value_of

USUAL_DENSITY = 1000.0  # [kg/m³] default of UsdPhysics


class Collider(NamedTuple):
    """A collider: its prim, its shape in the body frame, and the physics material to which it is bound, or None."""

    prim: Any
    piece: Piece
    material: Any


def inertial_of(
    stage: Stage,
    body: Any,  # noqa: ANN401 - of a type of usd-core
    colliders: list[Collider],
    stretch: Float,
    density: float | None,
    notes: list[str],
) -> Inertial:
    """Return the inertial of a body in its frame.

    ``stretch`` (3, 3) maps the frame of its prim [stage units] to the body frame [m]. ``density`` [kg/m³] replaces the
    default of UsdPhysics, 1,000, where none is given.
    """
    where = str(body.GetPath())
    with located(where):
        found = together([_collider(stage, body, each, density, notes) for each in colliders])
        mass = _positive(body, "physics:mass", MASS, stage.kilograms)
        share = 1.0 if mass is None else mass / found.mass
        whole = Inertial(share * found.mass, found.com, share * found.inertia)
        centre = body.GetAttribute("physics:centerOfMass")
        given = numbers_of(body, "physics:centerOfMass", (3,), SCALE) if centre and centre.HasAuthoredValue() else None
        if given is not None:
            centre_given = np.asarray(stretch @ given)
            whole = Inertial(whole.mass, centre_given, whole.about(centre_given))
        own = _inertia(stage, body)
        return whole if own is None else whole._replace(inertia=own)


def _inertia(stage: Stage, body: Any) -> Float | None:  # noqa: ANN401
    """Return the given inertia (3, 3) [kg m²] of a body along its axes, or None."""
    given = numbers_of(body, "physics:diagonalInertia", (3,), INERTIA)
    if given is None or not given.any():
        return None
    diagonal = checked(given * stage.kilograms * stage.metres**2, (3,), "diagonalInertia", within=INERTIA)
    axes = value_of(body, "physics:principalAxes")
    turn = np.eye(3)
    if hasattr(axes, "GetReal") and (axes.GetReal() or any(axes.GetImaginary())):
        turn = pose_from(np.zeros(3), np.array([axes.GetReal(), *axes.GetImaginary()], dtype=np.float64))[:3, :3]
    return np.asarray(turn @ np.diag(diagonal) @ turn.T)


def _collider(stage: Stage, body: Any, collider: Collider, density: float | None, notes: list[str]) -> Inertial:  # noqa: ANN401
    own = collider.piece.shape.mass_properties
    mass = _positive(collider.prim, "physics:mass", MASS, stage.kilograms) if collider.prim != body else None
    per_unit = stage.kilograms / stage.metres**3
    dense = next(
        (
            found
            for prim in (collider.prim, body, collider.material)
            if prim is not None and (found := _positive(prim, "physics:density", DENSITY, per_unit)) is not None
        ),
        None,
    )
    if mass is None and dense is None:
        dense = USUAL_DENSITY if density is None else density
        if _positive(body, "physics:mass", MASS, stage.kilograms) is None:
            notes.append(f"{collider.prim.GetPath()}: density {dense:g} kg/m³, as nothing says it")
    scale = dense if mass is None or own.volume == 0 else mass / own.volume
    assert scale is not None
    return Inertial(scale * own.volume, np.asarray(own.com), scale * np.asarray(own.inertia)).seen(collider.piece.pose)


def _positive(prim: Any, name: str, within: Any, unit: float) -> float | None:  # noqa: ANN401
    """Return an attribute in SI units, or None if it is 0, which in UsdPhysics means that it is not given."""
    value = number_of(prim, name, 0.0)
    if value == 0.0:
        return None
    return checked_number(value * unit, f"{prim.GetPath()}: {name}", above=0, within=within)
