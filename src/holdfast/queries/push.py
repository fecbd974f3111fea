"""How hard may one push here: robustness at given points, and the factor of a set of loads."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from numpy.typing import ArrayLike

from holdfast.assembly.assembly import Assembly
from holdfast.base.archive import archived
from holdfast.base.arrays import Float, checked
from holdfast.base.errors import HoldfastError, message
from holdfast.base.public import Summary, number
from holdfast.engines.answers import Answers, Claim
from holdfast.engines.contract import Engine
from holdfast.queries.request import (
    CERTAIN_ENGINE,
    DEFAULT_ENGINE,
    EngineChoice,
    Load,
    checked_assembly,
    engine_of,
    pushes,
    total_wrench,
)
from holdfast.queries.result import Forces, Single, gives_way, least, places_of, told
from holdfast.scene.scene import Scene


@archived
@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Robustness(Forces):
    """The largest push at each of n points.

    ``force`` (n,) [N], with ``status`` FINITE, INFINITE (force inf: no push moves anything), UNSTABLE (force 0: it
    does not stand anyway) or UNDECIDED (force 0: not known). ``lower`` and ``upper`` (n,) [N] bound the true answer as
    far as the engine can promise; ``lower_bound`` and ``upper_bound`` say how they are known. ``moving`` (names),
    ``mode`` ("slip", "topple", "mixed", "none") and ``mechanism`` (Mechanism or None), each (n,), tell what gives way.
    ``points`` and ``directions`` (n, 3), world. ``engine``, ``claim``, ``verdict`` and ``notes`` are of the whole
    answer.
    """

    body: str
    points: Float
    directions: Float

    def to_dict(self) -> dict[str, Any]:
        """Plain data for JSON: all columns."""
        names = ("force", "status", "lower", "upper", "moving", "mode", "mechanism", "solved", "error")
        return self.about() | {"body": self.body} | self.columns("points", "directions", *names)

    def summary(self) -> Summary:
        """The weakest pushes."""
        headline = f"{len(self.force):,} pushes on {self.body}: {told(self.verdict)}, {least(self.force, 'N')}"
        return self.table(headline, places_of(self.points))


@archived
@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class LoadFactor(Single):
    """The largest ``factor`` by which a set of loads may be multiplied together.

    ``status``, ``lower``, ``upper``, ``moving``, ``mode``, ``mechanism`` are single values here, with the same meaning
    as in Robustness.
    """

    @property
    def factor(self) -> float:
        """The largest factor before anything moves."""
        return float(self.answers.force[0])

    def to_dict(self) -> dict[str, Any]:
        """Plain data for JSON."""
        return self.about() | self.values("factor", "status", "lower", "upper", "moving", "mode", "mechanism")

    def summary(self) -> Summary:
        """Factor, bounds and what gives way."""
        between = f"{number(self.lower)} to {number(self.upper)}"
        facts = [("factor", number(self.factor)), ("between", between), ("status", str(self.status))]
        facts += [("gives way", gives_way(self.mode, self.moving)), *self.facts()]
        return Summary(f"the loads may be taken {number(self.factor)} times", facts, notes=self.notes)


def robustness(
    assembly: Assembly | Scene,
    body: str,
    points: ArrayLike,
    directions: ArrayLike,
    *,
    standing: Iterable[Load] = (),
    engine: EngineChoice = DEFAULT_ENGINE,
    bound: bool = False,
) -> Robustness:
    """R(p, e): the largest force [N] at each point of ``body`` along each direction before anything moves (eq. 12).

    ``points`` and ``directions`` are (n, 3) or (3,), world frame; a single one is repeated for the other; directions
    need not be of unit length. ``standing`` loads act all the while. ``bound`` asks engine ``compliant`` for ``upper``:
    above it no equilibrium exists, by engine ``limit``. A point further from the body's surface than the
    contact tolerance raises SceneError.
    """
    assembly = checked_assembly(assembly)
    p, e, W = pushes(assembly, body, points, directions, f"robustness of {body!r}")
    method = engine_of(engine)
    held = total_wrench(assembly, standing)
    found = asked(method, assembly, W, held, bound=bound)
    return Robustness(answers=found, body=body, points=p, directions=e)


def load_factor(
    assembly: Assembly | Scene,
    loads: Iterable[Load],
    *,
    standing: Iterable[Load] = (),
    acceleration: ArrayLike | None = None,
    engine: EngineChoice = DEFAULT_ENGINE,
    bound: bool = False,
) -> LoadFactor:
    """The largest factor by which all ``loads`` together may be multiplied before anything moves.

    ``standing`` loads and the inertial forces of a support that accelerates by ``acceleration`` (3,) [m/s²] act all
    the while, unscaled. ``bound`` as in ``robustness``.
    """
    assembly = checked_assembly(assembly)
    method = engine_of(engine)
    W = total_wrench(assembly, loads)[:, None]
    moved = None if acceleration is None else checked(acceleration, (3,), "load_factor: acceleration")
    held = total_wrench(assembly, standing)
    return LoadFactor(answers=asked(method, assembly, W, held, moved, bound=bound))


def asked(
    method: Engine,
    assembly: Assembly,
    W: Float,
    standing: Float,
    acceleration: Float | None = None,
    *,
    bound: bool,
) -> Answers:
    """The engine's answers for load columns W (6J, n).

    ``bound``: with upper bounds by limit analysis over the corners of the patches, which contain all nodes.
    """
    found = method.prepare(assembly, standing, acceleration).load_factor(W)
    if not bound or method.claim is Claim.EXISTS:
        return found
    if method.claim is Claim.ESTIMATED:
        remedy = "engine graph is not ordered against limit: ask 'compliant', or 'limit' itself"
        raise HoldfastError(message("bound", f"asked of engine {method.name!r}", remedy))
    return found.bounded_by(engine_of(CERTAIN_ENGINE).prepare(assembly, standing, acceleration).load_factor(W))
