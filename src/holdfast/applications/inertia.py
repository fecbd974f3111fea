"""Inertial forces and torques on the bodies of a moving carrier (Nadeau & Kelly, Sec. VII-B).

The fixed bodies are the carrier. In the frame of the carrier, a body with mass m and inertia I (about its centre of
mass, which is at r from the pivot) is subject to its weight and, by d'Alembert's principle, to

    force  -m (a + α x r + ω x (ω x r))        torque  -I α - ω x I ω

Here a is the acceleration of the carrier at the pivot, α its angular acceleration and ω its angular velocity. All
vectors are along the axes of the scene, which move with the carrier. At s times the speed, a and α are multiplied by s²
and ω by s, so every force and torque is multiplied by s².
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import Float, checked, checked_number
from holdfast.base.errors import HoldfastError, message
from holdfast.base.ranges import ACCELERATION, PLACE, TURNING
from holdfast.queries.request import Load, checked_assembly
from holdfast.scene.scene import Scene

# ω ωᵀ where one of the products that ``motion_coordinates`` ends with is 1 and the others are 0
SQUARES = np.zeros((6, 3, 3))
for _k, (_i, _j) in enumerate([(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)]):
    SQUARES[_k, _i, _j] = SQUARES[_k, _j, _i] = 1.0
SQUARES.setflags(write=False)


def inertial_loads(
    assembly: Assembly | Scene,
    *,
    acceleration: ArrayLike | None = None,
    angular_acceleration: ArrayLike | None = None,
    angular_velocity: ArrayLike | None = None,
    pivot: ArrayLike = (0.0, 0.0, 0.0),
) -> tuple[Load, ...]:
    """Return the inertial forces and torques of all movable bodies on a moving carrier, as loads for any query.

    The carrier accelerates by ``acceleration`` (3,) [m/s²] at ``pivot`` (3,) [m], and rotates about it with
    ``angular_acceleration`` (3,) [rad/s²] and ``angular_velocity`` (3,) [rad/s]. All vectors are in the axes of the
    scene. The module docstring has the equations.
    """
    where = "inertial loads"
    given = {
        "acceleration": (acceleration, ACCELERATION),
        "angular acceleration": (angular_acceleration, TURNING),
        "angular velocity": (angular_velocity, TURNING),
        "pivot": (pivot, PLACE),
    }
    a, alpha, omega, at = (
        np.zeros(3) if value is None else checked(value, (3,), f"{where}: {name}", within=within)
        for name, (value, within) in given.items()
    )
    given_assembly = checked_assembly(assembly)
    wrenches = inertial_wrenches(given_assembly, a[None], alpha[None], omega[None], at)[:, 0].reshape(-1, 6)
    return tuple(
        Load(body.name, body.com_world, wrench[:3], wrench[3:])
        for body, wrench in zip(given_assembly.movable, wrenches, strict=True)
    )


def inertial_wrenches(assembly: Assembly, a: Float, alpha: Float, omega: Float, pivot: Float) -> Float:
    """Return the inertial wrenches (6J, n) [N, N m] of the J movable bodies in n motions of the carrier.

    The motions are the rows of ``a`` [m/s²], ``alpha`` [rad/s²] and ``omega`` [rad/s], each (n, 3), about ``pivot``
    (3,) [m]. Wrenches are about the centres of mass and along the axes of the scene.
    """
    return motion_columns(assembly, pivot) @ motion_coordinates(a, alpha, omega).T


def motion_columns(assembly: Assembly, pivot: Float) -> Float:
    """Return (6J, 12): the inertial wrenches of a motion are these times its ``motion_coordinates``.

    With W = ω ωᵀ, ω x (ω x r) = W r - tr(W) r, and ω x I ω is the axial vector of W I.
    """
    count = len(assembly.movable)
    turns = np.array([body.pose[:3, :3] for body in assembly.movable]).reshape(-1, 3, 3)
    own = np.array([body.inertia_com for body in assembly.movable]).reshape(-1, 3, 3)
    inertia = turns @ own @ turns.transpose(0, 2, 1)
    r = assembly.com - pivot
    columns = np.zeros((count, 6, 12))
    columns[:, :3, :3] = np.eye(3)
    columns[:, :3, 3:6] = np.cross(np.eye(3), r[:, None]).transpose(0, 2, 1)
    columns[:, 3:, 3:6] = inertia
    pulled = np.einsum("nij,kj->kin", SQUARES, r)
    columns[:, :3, 6:] = pulled - np.trace(SQUARES, axis1=1, axis2=2) * r[:, :, None]
    turned = np.einsum("nij,kjl->knil", SQUARES, inertia)
    columns[:, 3:, 6:] = np.stack([turned[..., i - 2, i - 1] - turned[..., i - 1, i - 2] for i in range(3)], 1)
    columns[:, :3] *= assembly.mass[:, None, None]
    return -columns.reshape(-1, 12)


def motion_coordinates(a: Float, alpha: Float, omega: Float) -> Float:
    """Return (n, 12): a, α and the six distinct products of components of ω, each (n, 3), in which loads are linear."""
    return np.hstack([a, alpha, omega * omega, omega[:, [0, 0, 1]] * omega[:, [1, 2, 2]]])


def speed_within(usage: Float, margin: float, where: str) -> float:
    """Return the largest factor s on the speed of a motion at which no inertial load exceeds the capacity.

    ``usage`` (n,) is the share of the capacity that each load uses at s = 1; it grows with s². ``margin`` in [0, 1) is
    the share that must remain unused. The factor is inf if nothing is used. Raises HoldfastError, with ``where`` in its
    message, if ``margin`` is out of range.
    """
    spare = checked_margin(margin, where)
    worst = float(np.max(usage, initial=0.0))
    return float(np.sqrt((1 - spare) / worst)) if worst > 0 else np.inf


def checked_margin(margin: float, where: str) -> float:
    """Return the share of a limit that remains unused. Raises HoldfastError, naming ``where``, outside [0, 1)."""
    spare = checked_number(margin, f"{where}: margin", minimum=0)
    if spare >= 1:
        raise HoldfastError(message(f"{where}: margin", f"is {spare:g}", "needs 0 <= margin < 1"))
    return spare
