"""Compute how one robustness changes with friction, masses, centres of mass and the point of the push."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import ArrayLike

from holdfast.assembly.assembly import FIXED, Assembly
from holdfast.assembly.strengths import refuse_joined
from holdfast.base.arrays import Float, checked, checked_direction
from holdfast.base.errors import HoldfastError, message
from holdfast.base.public import Summary, column, number
from holdfast.base.ranges import PLACE
from holdfast.base.text import quoted
from holdfast.base.values import Table
from holdfast.engines.contract import GRADIENTS
from holdfast.engines.groups import prepared
from holdfast.queries.request import (
    CERTAIN_ENGINE,
    Load,
    body_number,
    checked_assembly,
    engine_of,
    push_columns,
    total_wrench,
)
from holdfast.queries.result import NAMED, SHOWN, First, Single, gives_way
from holdfast.queries.uncertain import Pair
from holdfast.scene.scene import Scene


class Sensitivity(Single):
    """The derivatives of the largest push ``force`` [N], which lies between ``lower`` and ``upper``.

    ``d_mu`` [N] maps the two bodies of each interface to the derivative by its friction coefficient. ``d_mass`` [N/kg]
    and ``d_com`` (3,) [N/m, world frame] map each movable body to the derivatives by its mass, with the centre of mass
    in place, and by the position of its centre of mass, with the contacts in place. ``d_point`` (3,) [N/m, world frame]
    is the derivative by the point of the push, whose direction stays the same. ``moving`` holds the names of the bodies
    that move in ``mechanism``.
    """

    body: str
    d_mu: Table[Pair, float]
    d_mass: Table[str, float]
    d_com: Table[str, Float]
    d_point: Float = column("3")

    plain = "body force lower upper status moving mode d_mu d_mass d_com d_point"

    force = First[float]("force", "The largest push [N].")

    def summary(self) -> Summary:
        """Summarise the answer by its largest derivatives."""
        by_pair = sorted(self.d_mu.items(), key=lambda item: -abs(item[1]))
        rows = [[f"friction of {a} on {b}", f"{value:.4g} N"] for (a, b), value in by_pair[:SHOWN]]
        by_mass = sorted(self.d_mass.items(), key=lambda item: -abs(item[1]))
        rows += [[f"mass of {name}", f"{value:.4g} N/kg"] for name, value in by_mass[:NAMED]]
        headline = f"{number(self.force, 'N')} on {self.body}, {gives_way(self.mode, self.moving)}"
        return Summary(headline, self.facts(), ("with", "grows by"), rows, self.notes)


def sensitivity(
    assembly: Assembly | Scene,
    body: str,
    point: ArrayLike,
    direction: ArrayLike,
    *,
    standing: Iterable[Load] = (),
) -> Sensitivity:
    """Compute the derivatives of R(p, e) by engine ``limit``, all from one solve.

    ``point`` (3,) [m] and ``direction`` (3,) are in the world frame. The contact nodes, the push and the ``standing``
    loads are held in place.

    The derivatives are exact where R is differentiable, that is where there is one mechanism and its sliding contacts
    have unique forces. At a kink of R, two mechanisms give way at the same push, and the derivatives belong to one of
    them or are a mean of both. As R is concave in the masses, the derivatives by mass give an upper bound of R even
    there. Kinks are not detected.

    Raises HoldfastError if R is zero, infinite or undecided, and SceneError if the direction is zero.
    """
    assembly = checked_assembly(assembly)
    where = f"sensitivity of {quoted(body)}"
    if assembly.scene.friction.cohesion:  # where it closes the cone, the tension depends on friction
        refuse_joined(assembly, where, "leave out cohesion: a tension alone is taken")
    p = checked(point, (3,), f"{where}: point", within=PLACE)
    e, index = checked_direction(direction, f"{where}: direction"), body_number(assembly, body)
    method = engine_of(CERTAIN_ENGINE)
    groups = prepared(method, assembly, total_wrench(assembly, standing))
    column = push_columns(assembly, index, p[None], e[None])
    if index == FIXED:
        raise HoldfastError(message(where, "the body is fixed", "a push on it changes nothing: name a movable body"))
    state, rows = groups.together([index], where)
    found = GRADIENTS.of(state, engine=method.name, where=where).gradient(column[rows, 0], where)
    members = rows[::6] // 6
    J = len(assembly.movable)
    d_mass, d_com, twists = np.zeros(J), np.zeros((J, 3)), np.zeros((J, 6))  # zero for bodies of other groups
    d_mass[members], d_com[members], twists[members] = found.d_mass, found.d_com, found.twists
    by_pair = {frozenset(pair): value for pair, value in found.d_mu.items()}
    names = [b.name for b in assembly.movable]
    answers = groups.in_whole(index, found.answers)
    force = float(answers.force[0])
    return Sensitivity(
        answers=answers,
        body=body,
        d_mu=Table({i.bodies: by_pair.get(frozenset(i.bodies), 0.0) for i in assembly.interfaces}),
        d_mass=Table(zip(names, d_mass.tolist(), strict=True)),
        d_com=Table(zip(names, d_com, strict=True)),
        d_point=-force * np.cross(e, twists[index, 3:]),
    )
