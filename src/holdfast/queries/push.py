"""Compute how hard one can push: the robustness, the load factor of a set of loads, and how a robustness changes."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from holdfast.assembly.assembly import FIXED, Assembly
from holdfast.assembly.strengths import refuse_joined
from holdfast.base.archive import to_dict
from holdfast.base.arrays import Float, checked, checked_direction, checked_truth
from holdfast.base.errors import HoldfastError, message
from holdfast.base.public import Summary, at_least, at_most, column, number
from holdfast.base.ranges import ACCELERATION, PLACE
from holdfast.base.text import quoted
from holdfast.base.values import Table
from holdfast.certificates.certified import Certified, asking
from holdfast.certificates.question import Question
from holdfast.engines.answers import Answers, Claim
from holdfast.engines.contract import GRADIENTS, Engine
from holdfast.engines.groups import prepared
from holdfast.engines.imperfect import Imperfect
from holdfast.queries.lower_bounds import Pressed, covering, unless_crushed
from holdfast.queries.request import (
    CERTAIN_ENGINE,
    DEFAULT_ENGINE,
    EngineChoice,
    Load,
    body_number,
    checked_assembly,
    checked_loads,
    engine_of,
    pressed_by,
    pressed_by_pushes,
    pulls,
    push_columns,
    pushes,
    total_wrench,
)
from holdfast.queries.result import (
    NAMED,
    ROW,
    SHOWN,
    First,
    Forces,
    Single,
    amount,
    gives_way,
    least,
    places_of,
    verdict_words,
)
from holdfast.queries.uncertain import Pair
from holdfast.scene.scene import Scene


class Robustness(Certified, Forces):
    """The largest push at each of n points before anything moves.

    ``force`` (n,) [N] is the answer, and ``status`` (n,) says what it means: FINITE; INFINITE (the force is inf: no
    push moves anything); UNSTABLE (the force is 0: the assembly does not stand even without a push); UNDECIDED (the
    force 0 is no answer: see ``undecided``). FINITE with force 0 means that something is only balanced: the smallest
    push moves it. ``lower`` and ``upper`` (n,) [N] bound the true answer as far as the engine can promise;
    ``lower_bound`` and ``upper_bound`` say how these bounds are known.

    Where a body has a ``top_load`` or a ``pressure``, ``force`` and ``lower`` also end where it is crushed.

    Three columns (n,) say what gives way: ``moving`` holds the names of the moving bodies, ``mode`` is "slip",
    "topple", "mixed", "roll", "crush" or "none", and ``mechanism`` is a Mechanism or None. ``points`` (n, 3) [m] and
    the unit ``directions`` (n, 3) are in the world frame. ``engine``, ``claim``, ``verdict`` and ``notes`` apply to the
    whole answer.
    """

    body: str
    points: Float = column("n 3")
    directions: Float = column("n 3")

    plain = f"body points directions force {ROW}"

    def where(self, row: int) -> dict[str, Any]:
        """Return the push that a row answers, as plain data."""
        return {"point": to_dict(self.points[row]), "direction": to_dict(self.directions[row])}

    def summary(self) -> Summary:
        """Summarise the answer by its weakest pushes."""
        headline = (
            f"{len(self.force):,} pushes on {self.body}: {verdict_words(self.verdict)}, {least(self.answers, 'N')}"
        )
        return self.table(headline, places_of(self.points))


class LoadFactor(Certified, Single):
    """The largest ``factor`` by which a set of loads can be multiplied before anything moves.

    All loads are multiplied by the same factor. ``status``, ``lower``, ``upper``, ``moving``, ``mode`` and
    ``mechanism`` have the same meaning as in Robustness, but each is a single value.
    """

    factor = First[float](
        "force", "The largest factor before anything moves; 0 if it is UNSTABLE or UNDECIDED, inf if it is INFINITE."
    )

    plain = f"factor {ROW}"

    def summary(self) -> Summary:
        """Summarise the answer by the factor, its bounds and what gives way."""
        between = f"{at_most(self.lower)} to {at_least(self.upper)}"
        facts = [("factor", amount(self.status, self.factor)), ("between", between), ("status", str(self.status))]
        facts += [("gives way", gives_way(self.mode, self.moving)), *self.facts()]
        headline = f"the loads may be multiplied by {number(self.factor)}"
        return Summary(self.answers.undecided.text or headline, facts, notes=self.notes)


def robustness(
    assembly: Assembly | Scene,
    body: str,
    points: ArrayLike,
    directions: ArrayLike,
    *,
    standing: Iterable[Load] = (),
    engine: EngineChoice = DEFAULT_ENGINE,
    bounds: bool = False,
    imperfect: Imperfect | None = None,
) -> Robustness:
    """Compute R(p, e), the largest force [N] at points of ``body`` along directions before anything moves (eq. 12).

    ``points`` [m] and ``directions`` are (n, 3) or (3,), in the world frame. A single point is used with all
    directions, and a single direction with all points. Directions need not have unit length. The ``standing`` loads act
    throughout.

    With ``bounds``, an answer of engine ``compliant`` has ``upper`` as well: engine ``limit`` proves that no
    equilibrium exists above it.

    With ``imperfect``, ``lower`` also holds on faces that are not flat or not equally stiff; all other columns remain
    those of ideal faces. Only engine ``compliant`` takes it.

    Raises SceneError if there is no point, if the body is unknown, or if a point is further from the body's surface
    than the contact tolerance. Raises HoldfastError if engine ``graph`` is given with ``bounds``, or an engine other
    than ``compliant`` with ``imperfect``.

    For example, 1 kg on friction of 0.6, pushed at half its height:

    >>> push = hf.robustness(hf.shipped_scene("cube"), "cube", (-0.05, 0, 0.05), (1, 0, 0))
    >>> print(f"{push.lower[0]:.2f} to {push.force[0]:.2f} N, {push.mode[0]}")
    5.89 to 5.89 N, slip
    """
    assembly = checked_assembly(assembly)
    p, e, W = pushes(assembly, body, points, directions, f"robustness of {quoted(body)}")
    method = engine_of(engine)
    standing = checked_loads(standing)
    standing_wrench = total_wrench(assembly, standing)
    pressed = pressed_by(assembly, standing), pressed_by_pushes(assembly, [body], e)
    found = load_factors(method, assembly, W, standing_wrench, bounds=bounds, imperfect=imperfect, pressed=pressed)
    found = replace(found, notes=(*found.notes, *pulls(assembly, body, p, e)))
    return asking(
        Robustness(answers=found, body=body, points=p, directions=e), Question(assembly, standing_wrench, None, W, p)
    )


def load_factor(
    assembly: Assembly | Scene,
    loads: Iterable[Load],
    *,
    standing: Iterable[Load] = (),
    acceleration: ArrayLike | None = None,
    engine: EngineChoice = DEFAULT_ENGINE,
    bounds: bool = False,
    imperfect: Imperfect | None = None,
) -> LoadFactor:
    """Compute the largest factor by which all ``loads`` can be multiplied together before anything moves.

    The ``standing`` loads act throughout and are not multiplied. The same holds for the inertial forces of a support
    that accelerates by ``acceleration`` (3,) [m/s²], world frame. ``bounds`` and ``imperfect`` have the same meaning as
    in ``robustness``.
    """
    assembly = checked_assembly(assembly)
    method = engine_of(engine)
    loads, standing = checked_loads(loads), checked_loads(standing)
    W = total_wrench(assembly, loads)[:, None]
    moved = (
        None if acceleration is None else checked(acceleration, (3,), "load_factor: acceleration", within=ACCELERATION)
    )
    standing_wrench = total_wrench(assembly, standing)
    pressed = pressed_by(assembly, standing), pressed_by(assembly, loads)[:, None]
    found = load_factors(
        method, assembly, W, standing_wrench, moved, bounds=bounds, imperfect=imperfect, pressed=pressed
    )
    point = np.array([loads[0].point]) if len(loads) == 1 and not np.any(loads[0].moment) else None
    return asking(LoadFactor(answers=found), Question(assembly, standing_wrench, moved, W, point))


def load_factors(
    method: Engine,
    assembly: Assembly,
    W: Float,
    standing: Float,
    acceleration: Float | None = None,
    *,
    bounds: bool,
    imperfect: Imperfect | None = None,
    pressed: Pressed | None = None,
) -> Answers:
    """Return the answers of the engine for the load columns W (6J, n).

    ``standing`` (6J,) is the wrench of the standing loads. With ``bounds``, the upper bounds come from limit analysis
    with forces at the corners of the patches; these can replace the forces at any nodes inside the patches.
    ``imperfect`` is as in ``robustness``. With ``pressed``, no answer goes beyond where a body is crushed (see
    lower_bounds.py). Raises HoldfastError for ``bounds`` with an engine that only estimates.
    """
    bounded = checked_truth(bounds, "bounds")
    covers = covering(imperfect, method, assembly, standing, acceleration)
    state = prepared(method, assembly, standing, acceleration)
    found = state.load_factor(W)
    found = found if covers is None else covers.over(found, W)
    if bounded and method.claim is not Claim.EXISTS:
        if method.claim is Claim.ESTIMATED:
            remedy = "engine graph is not ordered against limit: ask 'compliant', or 'limit' itself"
            raise HoldfastError(message("bounds", f"asked of engine {method.name!r}", remedy))
        certain = prepared(engine_of(CERTAIN_ENGINE), assembly, standing, acceleration)
        found = found.bounded_by(certain.load_factor(W))
    return found if pressed is None else unless_crushed(found, state, W, pressed)


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
