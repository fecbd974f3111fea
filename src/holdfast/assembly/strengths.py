"""What joins the faces of an assembly beyond friction, and how it pulls bodies together."""

from __future__ import annotations

import numpy as np

from holdfast.assembly.assembly import FIXED, Assembly
from holdfast.base.arrays import Float
from holdfast.base.errors import SceneError, message
from holdfast.base.text import quoted
from holdfast.scene.friction import NOTHING, Strength, refuse_strengths, strength_between

MOST = 1e3  # times the weight of all bodies: beside a larger pull, what moves them is lost in the accuracy of programs


def strengths_of(assembly: Assembly) -> tuple[Strength, ...]:
    """Return what joins the faces of every interface, per area.

    A cohesion beyond μ tension, as where friction was lowered, counts as μ tension, which is cautious.
    """
    table, materials = assembly.scene.friction, assembly.scene.materials
    if not table.joins:
        return (NOTHING,) * len(assembly.interfaces)
    pairs = zip(assembly.interfaces, assembly.mu, strict=True)
    return tuple(strength_between(table, *interface.bodies, materials, mu) for interface, mu in pairs)


def check_strengths(assembly: Assembly) -> None:
    """Raise SceneError for a cohesion beyond μ tension, and for a tension that pulls MOST times the weight of all."""
    if not assembly.scene.friction.joins:
        return
    most = MOST * assembly.weight
    for interface, strength in zip(assembly.interfaces, strengths_of(assembly), strict=True):
        where = f"friction of {quoted(interface.bodies)}"
        if strength.shear > 0:
            problem = f"the cohesion is {strength.shear:g} Pa above friction times tension"
            raise SceneError(message(where, problem, "give a tension of at least cohesion / μ, or a lower cohesion"))
        if strength.tension * interface.area > most > 0:
            problem = f"a tension of {strength.tension:g} Pa pulls more than {MOST:g} times the weight of all bodies"
            remedy = f"give at most {most / interface.area:.3g} Pa, or make them parts of one Compound"
            raise SceneError(message(where, problem, remedy))


def is_joined(assembly: Assembly) -> bool:
    """Tell whether something joins faces of the assembly: tension or cohesion."""
    return assembly.scene.friction.joins and any(strength != NOTHING for strength in strengths_of(assembly))


def refuse_joined(assembly: Assembly, where: str, remedy: str) -> None:
    """Raise SceneError, with ``where`` and ``remedy`` in its message, if something joins faces of the assembly."""
    if is_joined(assembly):
        refuse_strengths(assembly.scene.friction, where, remedy)


def with_pull(assembly: Assembly, wrench: Float) -> Float:
    """Return ``wrench`` (6J,) [N, N m] with what tension pulls bodies together: -tension on the area of all faces.

    A cone of forces that is moved along its axis is a plain cone beside this constant pull. Spread over a whole face,
    it is exact whatever nodes the face has.
    """
    if not is_joined(assembly):
        return wrench
    found = np.zeros((len(assembly.movable) + 1, 6))  # the last row collects fixed bodies, whose number FIXED is -1
    for interface, (a, b), strength in zip(assembly.interfaces, assembly.ends, strengths_of(assembly), strict=True):
        for patch in interface.patches if strength.tension > 0 else ():
            points, areas = patch.areas
            pull = -strength.tension * areas
            for body, sign in ((b, 1.0), (a, -1.0)):
                found[body, :3] += sign * pull.sum(axis=0)
                if body != FIXED:
                    found[body, 3:] += sign * np.cross(points - assembly.com[body], pull).sum(axis=0)
    return np.asarray(wrench + found[:-1].ravel())
