"""What only some engines can do, each ability under a name that a question asks for.

An engine, or the state that it prepares, offers an ability by having the method of the protocol; it inherits nothing
and is registered nowhere. ``SETS.of(state, ...)`` hands out the object as one that has the method, or says what is
missing.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Generic, NamedTuple, Protocol, TypeVar, cast, runtime_checkable

from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import Float
from holdfast.base.errors import HoldfastError, message
from holdfast.engines.answers import Answers

T_co = TypeVar("T_co", covariant=True)


@dataclass(frozen=True, eq=False)
class LoadSet:
    """A convex set of loads between two polyhedra, in units of the box |x_k| <= 1.

    ``inner`` (m, d) and ``outer`` (k, d) are rows a of a·x <= 1; ``inner`` ends at the box, ``outer`` does not.
    ``vertices`` (v, d) are those of ``inner``. ``gap``: along every ray from 0 the reach of ``inner`` is at least
    (1 - gap) times that of ``outer`` and box. ``solves`` is what it took.
    """

    inner: Float
    outer: Float
    vertices: Float
    gap: float
    solves: int


@dataclass(frozen=True, eq=False)
class Gradient:
    """The largest factor of one load, the only row of ``answers``, and its derivatives where it is differentiable.

    ``twists`` (J, 6): the motion that limits the load, about the bodies' centres of mass, scaled so that the load does
    work at unit power: a change of the load by dw changes the factor by -factor twists·dw. ``d_mu`` by the two bodies
    of an interface; ``d_mass`` (J,) [1/kg] by a body's mass, its centre of mass held; ``d_com`` (J, 3) [1/m] by a
    body's centre of mass in the world, its contacts held.
    """

    answers: Answers
    twists: Float
    d_mu: dict[tuple[str, str], float]
    d_mass: Float
    d_com: Float


class Corner(NamedTuple):
    """One corner of a box of uncertain bodies: ``masses`` [kg] and ``coms`` (world [m]) by body."""

    masses: dict[str, float]
    coms: dict[str, tuple[float, float, float]]


@dataclass(frozen=True, eq=False)
class Weakest:
    """The smallest of each load's largest factors over all ``corners`` of a box.

    ``answers`` (n rows) are those of the corners where each load is weakest, ``corner`` (n,) their numbers; the bounds
    are the smallest of all corners. ``guarantee`` says in words what was proved.
    """

    answers: Answers
    corner: tuple[int, ...]
    corners: tuple[Corner, ...]
    guarantee: str


@runtime_checkable
class Sets(Protocol):
    """A state that bounds all the loads that its assembly carries, those included that nobody asked about."""

    def load_set(self, columns: Float, gap: float, where: str) -> LoadSet:
        """The x (d,), d 3 or 6, for which the load ``columns`` @ x, (6J, d), is carried; to within ``gap`` if it can.

        ``columns`` are loads at the bounds of the box |x_k| <= 1. ``where`` names the question in errors and progress.
        Raises HoldfastError where 0 is not inside the set.
        """
        ...


@runtime_checkable
class Gradients(Protocol):
    """A state that tells how the largest factor of a load changes with the assembly."""

    def gradient(self, load: Float, where: str) -> Gradient:
        """Derivatives of the largest factor of ``load`` (6J,); raises HoldfastError where that is not finite."""
        ...


@runtime_checkable
class WorstCases(Protocol):
    """An engine that knows its answer over a box of masses and centres of mass from finitely many points of the box."""

    def weakest(
        self,
        assembly: Assembly,
        standing: Float,
        W: Float,
        *,
        masses: Mapping[str, tuple[float, float]],
        coms: Mapping[str, Float],
        where: str,
    ) -> Weakest:
        """For each load column of W (6J, n): the smallest factor over the box, besides ``standing`` (6J,) loads.

        ``masses`` (low, high) [kg] and ``coms``, half widths (3,) [m] along the world axes, by movable body.
        """
        ...


@runtime_checkable
class Releases(Protocol):
    """An engine that can prove that a body comes free of its neighbours."""

    def comes_loose(self, assembly: Assembly, body: str, up: Float) -> bool:
        """True if for certain no contact holds ``body`` once its weight is taken along ``up`` (3,), against gravity."""
        ...


@dataclass(frozen=True)
class Capability(Generic[T_co]):
    """One ability: the protocol that an object with it satisfies, and what is said of one that ``lacks`` it."""

    protocol: type
    lacks: str

    def of(self, offering: object, *, engine: str, where: str) -> T_co:
        """``offering``, an engine or a state of the engine of that name, if it has the ability; else HoldfastError."""
        if not isinstance(offering, self.protocol):
            raise HoldfastError(message(where, f"engine {engine!r} {self.lacks}", "use engine='limit'"))
        return cast(T_co, offering)


SETS = Capability[Sets](Sets, "proves nothing about loads that it was not asked")
GRADIENTS = Capability[Gradients](Gradients, "gives no derivatives")
WORST_CASES = Capability[WorstCases](WorstCases, "proves nothing about a box of masses and centres of mass")
RELEASES = Capability[Releases](Releases, "proves of no body that it comes loose")
