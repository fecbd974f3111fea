"""The contract that every engine fulfils.

``Engine.prepare(assembly)`` returns a ``State``. ``State.verdict()`` says whether the assembly stands, and
``State.load_factor(W)`` gives the largest factor of every load in W.

Abilities that only some engines have are protocols as well. A query asks for one by its name: an engine, or the state
that it prepares, offers it by having the method, and need not inherit from the protocol or be registered.
``SETS.of(state, ...)`` returns the object typed as one that has the method, or raises an error that says which ability
is missing.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Generic, NamedTuple, Protocol, TypeAlias, TypeVar, cast, runtime_checkable

import numpy as np

from holdfast.assembly.assembly import Assembly
from holdfast.assembly.contact_nodes import ContactNodes
from holdfast.base.arrays import Bool, Float, Int, checked_number
from holdfast.base.errors import HoldfastError, message
from holdfast.base.rigid import cross
from holdfast.engines.answers import Answers, Claim
from holdfast.engines.verdict import ContactForces, Verdict


@dataclass(frozen=True)
class Exact:
    """Accuracy: every load is solved on its own, and all bounds that the engine can give are computed."""


@dataclass(frozen=True)
class Within:
    """Accuracy: an engine that proves both bounds may stop as soon as (upper - lower) / upper <= ``relative`` > 0.

    Loads on one body may then share work. An engine without proved bounds solves every load as ``Exact`` does.
    """

    relative: float

    def __post_init__(self) -> None:
        checked_number(self.relative, "Within: relative", above=0)


@dataclass(frozen=True)
class ForcesOnly:
    """Accuracy: every load is solved on its own, and bounds that take further work are left out."""


Accuracy: TypeAlias = Exact | Within | ForcesOnly

EXACT, FORCES_ONLY = Exact(), ForcesOnly()


class State(Protocol):
    """An engine prepared for one assembly under given standing loads.

    All queries share what was computed once during the preparation, such as the state of rest.
    """

    def verdict(self) -> Verdict:
        """Say whether the assembly stands under its weight and the standing loads."""
        ...

    def load_factor(self, W: Float, accuracy: Accuracy = EXACT) -> Answers:
        """Find the largest factor of each load before something moves.

        Each column of W (6J, n) is one load: the wrenches (force [N], torque [N m]) on the J movable bodies, about
        their centres of mass and along the world axes. It acts in addition to the weight and the standing loads.
        Row k of the result answers for column k.
        """
        ...

    @property
    def notes(self) -> tuple[str, ...]:
        """The simplifications that the answers rest on, in plain words."""
        ...


class Engine(Protocol):
    """A method of computing answers, together with its options."""

    @property
    def name(self) -> str:
        """The name of the engine, as in ``engine="graph"``."""
        ...

    @property
    def claim(self) -> Claim:
        """What the answers of this engine promise."""
        ...

    def prepare(self, assembly: Assembly, standing: Float | None = None, acceleration: Float | None = None) -> State:
        """Prepare the engine for one assembly.

        ``standing`` (6J,) are wrenches [N, N m] on the movable bodies that act all the time, in addition to the weight.
        They are about the centres of mass and along the world axes; None means no such loads. ``acceleration`` (3,)
        [m/s²] is that of the support, along the world axes; None means a support at rest.
        """
        ...


T_co = TypeVar("T_co", covariant=True)


@dataclass(frozen=True, eq=False)
class LoadSet:
    """A convex set of loads, bounded from inside and from outside by polyhedra, in units of the box |x_k| <= 1.

    Each row a of ``inner`` (m, d) and ``outer`` (k, d) is a half-space a·x <= 1. ``inner`` is cut off at the box,
    ``outer`` is not. ``vertices`` (v, d) are the vertices of ``inner``. Along every ray from 0, ``inner`` reaches at
    least (1 - ``accuracy``) times as far as the intersection of ``outer`` and the box, and along the ray to ``worst``
    (d,) no farther than that. ``solves`` is the number of programs that were solved.
    """

    inner: Float
    outer: Float
    vertices: Float
    accuracy: float
    worst: Float
    solves: int


@dataclass(frozen=True, eq=False)
class LoadHull:
    """Points of a convex set of loads, whose hull is inside the set, in units of the box |x_k| <= 1.

    The gauge of the set, 1/R, is at most ``price`` (m,) at the points ``known`` (m, d). The first 2 d points lie along
    the positive and then the negative axes. Of the last loads whose rays were looked at, half leave the hull at (1 -
    ``accuracy``) of the largest factor or later, and nine in ten at (1 - ``accuracy_of_most``). ``solves`` is the
    number of programs that were solved.
    """

    known: Float
    price: Float
    accuracy: float
    accuracy_of_most: float
    solves: int


@dataclass(frozen=True, eq=False)
class Gradient:
    """The largest factor of one load and its derivatives. They hold where the factor is differentiable.

    ``answers`` has one row, which is the answer for the load. ``twists`` (J, 6) is the motion that limits the load: the
    twist of each movable body about its centre of mass, along the world axes. It is scaled so that the power of the
    load is 1, so a change of the load by dw changes the factor by -factor twists·dw.

    ``d_mu`` holds the derivative by the friction coefficient of an interface, keyed by the names of its two bodies.
    ``d_mass`` (J,) [1/kg] is the derivative by a body's mass, with its centre of mass held. ``d_com`` (J, 3) [1/m] is
    the derivative by a body's centre of mass in the world frame, with its contacts held.

    ``forces`` (I, 3) [N], world axes, act at the contact ``nodes`` on the second body of each, at the limit. The bodies
    of ``twists`` and of the nodes are numbered as in ``assembly``.
    """

    answers: Answers
    assembly: Assembly
    nodes: ContactNodes
    forces: Float
    twists: Float
    d_mu: dict[tuple[str, str], float]
    d_mass: Float
    d_com: Float


class Slope(NamedTuple):
    """The derivatives of the ``factor`` of a load, at which the contact of the bodies ``pair`` gives way.

    Bodies are numbered as in ``assembly``. ``twist`` (6,) about the world's origin is that of all bodies ``beyond``
    (k,), scaled so that the power of the load is 1: another load dw changes the factor by -factor twist·dw.
    ``by_friction`` is by the coefficient of the pair. By motions of the bodies of the pair as far as they move the
    contact, it changes by ``by_plane``·(v1 + v2) / 2 for their twists (6,) about the world's origin, and by the sum of
    ``by_edges`` (n,) times how far places of edges (n, 3) [m] move along their ``outward`` normals (n, 3) against that
    plane. Each is a place of the second body (``owners`` 1), of the first (-1), or of both (0), whichever is less.
    """

    factor: float
    assembly: Assembly
    pair: tuple[str, str]
    beyond: Int
    twist: Float
    by_friction: float
    by_plane: Float
    by_edges: Float
    places: Float
    outward: Float
    owners: Int

    def by_motion(self, number: int, origin: Float) -> tuple[Float, Float]:
        """Return the slopes (6,) by motions of one body of the pair about ``origin``, and what kinks add beyond."""
        sign = 1.0 if number else -1.0
        spin = cross(self.places - origin, self.outward)
        moved = np.concatenate([self.outward, spin], axis=1)
        plane = np.concatenate([self.by_plane[:3], self.by_plane[3:] + cross(-origin, self.by_plane[:3])])
        smooth = plane / 2 + sign * (self.by_edges * self.owners) @ moved / 2
        return smooth, -(self.by_edges * (self.owners == 0)) @ np.abs(moved) / 2


class Corner(NamedTuple):
    """One corner of a box of uncertain masses and centres of mass.

    ``masses`` [kg] and ``coms`` (centres of mass, world frame [m]) are keyed by body name.
    """

    masses: dict[str, float]
    coms: dict[str, tuple[float, float, float]]


@dataclass(frozen=True, eq=False)
class Weakest:
    """The worst case of n loads over all ``corners`` of a box of masses and centres of mass.

    For each load, ``corner`` (n,) is the number of the corner with the smallest of the largest factors, and the row of
    ``answers`` (n rows) is the answer at that corner. Its ``lower`` and ``upper`` are the smallest over all corners.
    ``guarantee`` says in words what was proved.
    """

    answers: Answers
    corner: tuple[int, ...]
    corners: tuple[Corner, ...]
    guarantee: str


@runtime_checkable
class Sets(Protocol):
    """A state that bounds the set of all loads that its assembly carries, not only loads that were asked about."""

    def load_set(self, columns: Float, accuracy: float, solves: int | None, where: str) -> LoadSet:
        """Find the set of x (d,), with d = 3 or 6, for which the load ``columns`` @ x is carried.

        Each of the ``columns`` (6J, d) is the load at x_k = 1, the bound of the box |x_k| <= 1. The two polyhedra
        approach each other until they are within ``accuracy``, or until that many ``solves`` are used up; None stands
        for the engine's own. ``where`` names the query in error messages and progress reports. Raises HoldfastError if
        0 is not inside the set.
        """
        ...


@runtime_checkable
class Hulls(Protocol):
    """A state that finds points of the convex set of loads that it carries, where loads are likely."""

    def load_hull(self, columns: Float, near: Float, accuracy: float, solves: int, where: str) -> LoadHull:
        """Find points of the set of x (d,) for which ``columns`` @ x is carried, where ``columns`` is (6J, d).

        They are found until the hull is within ``accuracy`` of the set for half of the loads, or that many ``solves``
        are used up. Loads are drawn anywhere and, if there are any, among ``near`` (n, d), in units of the box.
        ``where`` names the query in error messages and progress reports. Raises HoldfastError if 0 is not inside the
        set.
        """
        ...


@runtime_checkable
class Gradients(Protocol):
    """A state that gives the derivatives of the largest factor of a load by properties of the assembly."""

    def gradient(self, load: Float, where: str) -> Gradient:
        """Compute the derivatives of the largest factor of ``load`` (6J,) [N, N m].

        ``where`` names the query in error messages. Raises HoldfastError if the largest factor is not finite.
        """
        ...


@runtime_checkable
class Sloping(Protocol):
    """A state that knows which contact gives way under some loads, and the derivatives of their largest factors."""

    def slope(self, load: Float) -> Slope | None:
        """Return the derivatives of the largest factor of ``load`` (6J,), or None where they are not known."""
        ...


@runtime_checkable
class WorstCases(Protocol):
    """An engine that finds its worst answer over a box of masses and centres of mass from finitely many points."""

    def weakest(
        self,
        assembly: Assembly,
        standing: Float,
        W: Float,
        *,
        masses: Mapping[str, tuple[float, float]],
        coms: Mapping[str, Float],
        prepare: Callable[[Float], State],
        where: str,
    ) -> Weakest:
        """Find the smallest value over the box of the largest factor of each load column of W (6J, n).

        ``standing`` (6J,) are loads that act in addition to the weight. The box is given by name of movable body:
        ``masses`` as (low, high) [kg], and ``coms`` as half widths (3,) [m] along the world axes. ``prepare`` prepares
        the engine for the assembly under standing loads (6J,). ``where`` names the query in error messages.
        """
        ...


@runtime_checkable
class Releases(Protocol):
    """An engine that can prove that a body comes free of its neighbours."""

    def comes_loose(self, assembly: Assembly, body: str, up: Float) -> bool:
        """Return True if it is proved that no contact holds ``body`` once its weight is supported.

        ``body`` is a body name. Its weight is supported by a force along ``up`` (3,), the direction against gravity.
        """
        ...


@runtime_checkable
class Holding(Protocol):
    """A state that can tell of loads that they move nothing for less than it takes to say what would."""

    def held(self, W: Float) -> Bool:
        """Tell which loads, columns of W (6J, n), certainly move nothing: those of which ``load_factor`` is above 1.

        Where False, that is not known.
        """
        ...


@runtime_checkable
class Judging(Protocol):
    """An engine that can tell without being prepared that bodies rest."""

    def firm(self, assembly: Assembly, wrench: Float) -> tuple[Bool, Verdict]:
        """Tell which movable bodies (J,) certainly rest under ``wrench`` (6J,), and the verdict on groups of them.

        What ``prepare`` finds of these groups is the same, for the same reason; where False, it has to be asked. The
        verdict has no forces.
        """
        ...


@runtime_checkable
class Loadable(Protocol):
    """A state that finds contact forces under a load for less than it takes to be prepared for it."""

    def forces_under(self, load: Float) -> ContactForces | None:
        """Return the contact forces once a ``load`` (6J,) [N, N m] acts as well, or None if they are not known."""
        ...


@runtime_checkable
class Remembering(Protocol):
    """A state whose answers draw on what it was asked before."""

    def fresh(self) -> State:
        """Return the same prepared state as it was before it was asked anything."""
        ...


def held_by(state: State, W: Float) -> Bool:
    """Tell which loads, columns of W (6J, n), certainly move nothing; False where that is not known without asking."""
    return state.held(W) if isinstance(state, Holding) else np.zeros(W.shape[1], dtype=bool)


def fresh(state: State) -> State:
    """Return the same prepared state as it was before it was asked anything."""
    return state.fresh() if isinstance(state, Remembering) else state


@dataclass(frozen=True)
class Capability(Generic[T_co]):
    """One ability: the ``protocol`` of objects that have it, and the words for an engine that ``lacks`` it."""

    protocol: type
    lacks: str

    def of(self, offering: object, *, engine: str, where: str) -> T_co:
        """Return ``offering`` if it has the ability; raise HoldfastError if it does not.

        ``offering`` is an engine or its state. ``engine`` is the name of the engine and ``where`` that of the query,
        both for the error message.
        """
        if not isinstance(offering, self.protocol):
            raise HoldfastError(message(where, f"engine {engine!r} {self.lacks}", "use engine='limit'"))
        return cast(T_co, offering)


SETS = Capability[Sets](Sets, "proves nothing about loads that it was not asked")
HULLS = Capability[Hulls](Hulls, "proves nothing about loads that it was not asked")
GRADIENTS = Capability[Gradients](Gradients, "gives no derivatives")
WORST_CASES = Capability[WorstCases](WorstCases, "proves nothing about a box of masses and centres of mass")
RELEASES = Capability[Releases](Releases, "proves of no body that it comes loose")
