"""Decide whether an assembly stands, explain why, and tell by what share it may worsen before something moves."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from functools import cached_property, partial

import numpy as np

from holdfast.assembly.assembly import Assembly, body_forces
from holdfast.base.arrays import Float, Int
from holdfast.base.errors import HoldfastError, message, warn
from holdfast.base.public import Of, PublicValue, Summary
from holdfast.base.text import listed
from holdfast.base.values import altered
from holdfast.certificates.certified import Certified, asking
from holdfast.certificates.question import Question
from holdfast.engines.answers import Bound, Claim
from holdfast.engines.bearing import Bearing, bearings, limited
from holdfast.engines.contract import Engine
from holdfast.engines.groups import prepared
from holdfast.engines.mechanism import Mechanism
from holdfast.engines.rest import undecided
from holdfast.engines.verdict import Certificate, ContactForces, GroupVerdict, Status, Verdict
from holdfast.queries.lower_bounds import unless_crushed, verdict_on_bearing
from holdfast.queries.request import (
    DEFAULT_ENGINE,
    EngineChoice,
    Load,
    checked_assembly,
    checked_loads,
    engine_of,
    pressed_by,
    total_wrench,
)
from holdfast.scene.hold import Grip
from holdfast.scene.scene import Scene

WAYS = 36  # level directions that are asked; between them at most 1 - cos(180° / 36) = 0.4 % is lost
CLOSE = 1e-3  # share of all friction to which a margin is known


class Stability(Certified, PublicValue, ask=".stable or .status"):
    """The verdict on whether an assembly stands at rest.

    ``status`` is STABLE, UNSTABLE or UNDECIDED, and ``reason`` explains it in words. ``equilibrium_exists`` is True or
    False with evidence, or None if it is not known. ``self_stress`` says whether contacts can press each other without
    any load, as those of a box between two rails: then pushes, loads and accelerations of engine ``limit`` may count on
    squeezing that nothing causes. It is worked out when it is first asked for, and None if it was not settled.

    If the assembly stands, ``forces`` are the contact forces, and ``residual`` is their equilibrium error divided by
    the total weight. If it does not stand, ``moving`` holds the names of the bodies that move, ``mechanism`` says how
    they move, and ``certificate`` proves that no contact can prevent it. All of these are attributes of ``verdict``,
    the worst of the verdicts on the groups of bodies that touch each other. ``groups`` holds these verdicts, in the
    order of ``assembly.groups``, each with the names of its ``bodies``. ``bearing`` says of every body with a limit how
    much it bears, the one nearest to its limit first, as far as the contact forces are known. ``notes`` say what the
    reader of the scene's file guessed or left out, and which simplifications the answer depends on.

    ``balanced`` names the bodies that are only balanced. ``margin`` and ``margins`` are worked out when they are first
    asked for. Answers that were saved, pickled or copied have lost them.
    """

    engine: str
    claim: Claim
    verdict: Verdict
    groups: tuple[GroupVerdict, ...]
    notes: tuple[str, ...]
    bearing: tuple[Bearing, ...] = ()

    plain = (
        "engine claim status equilibrium_exists self_stress forces residual moving mechanism certificate reason notes "
        "groups stable bearing"
    )

    status = Of[Status](
        "verdict.status", "STABLE, UNSTABLE or UNDECIDED, of the verdict. Rigid bodies stand, even if they are crushed."
    )
    reason = Of[str]("verdict.reason", "The reason for the verdict, in words.")
    balanced = Of[tuple[str, ...]](
        "verdict.balanced",
        "The names of the bodies that are only balanced: they stand, but the least push moves them.",
    )
    equilibrium_exists = Of[bool | None](
        "verdict.equilibrium_exists",
        "Whether an equilibrium exists: True or False with evidence, None if that is not known.",
    )
    self_stress = Of[bool | None](
        "verdict.self_stress", "Whether contacts can press each other without any load, None if that is not known."
    )
    forces = Of[ContactForces | None]("verdict.forces", "The contact forces if the assembly stands, else None.")
    residual = Of[float]("verdict.residual", "The equilibrium error of the contact forces over the total weight.")
    mechanism = Of[Mechanism | None]("verdict.mechanism", "The motion with which the bodies begin to move, or None.")
    certificate = Of[Certificate | None](
        "verdict.certificate", "The proof that no contact can prevent the motion, or None."
    )

    @property
    def stable(self) -> bool:
        """Whether the assembly certainly stands and nothing is crushed: False also where that is undecided."""
        return self.verdict.stable and not self.crushed

    @property
    def crushed(self) -> tuple[str, ...]:
        """The names of the bodies that bear more than they may, the most crushed first."""
        return tuple(dict.fromkeys(one.body for one in self.bearing if one.crushed))

    @cached_property
    def margin(self) -> float:
        """The share m by which things may worsen, from 0 to 1: 0 unless the assembly certainly stands.

        The assembly still rests if every movable body is pulled level, in any one direction, by m times its weight. It
        also rests if there is no such pull, and all friction coefficients are lower by the share m. What is only
        ``balanced``, as a ball is, bears no such force, and a warning names it; if there is nothing else, the margin is
        0. Raises HoldfastError for an engine that promises no lower bound, and for an answer that was saved, pickled or
        copied.
        """
        found = self._margin_of(None)
        if found and self.balanced:
            warn(message("margin", f"leaves out {listed(self.balanced)}, which is only balanced", "see .margins"))
        return found

    @cached_property
    def margins(self) -> tuple[float, ...]:
        """The margin of each group of bodies, in the order of ``groups``; 0 where all of it is only balanced."""
        return tuple(self._margin_of([number]) for number in range(len(self.groups)))

    def _margin_of(self, groups: Sequence[int] | None) -> float:
        asked: Callable[[Sequence[int] | None], float] | None = getattr(self, "_margin_asked", None)
        if self.crushed:
            return 0.0
        if asked is None:
            raise HoldfastError(message("margin", "was lost when the answer was saved or copied", "ask stability anew"))
        return asked(groups)

    @property
    def moving(self) -> tuple[str, ...]:
        """The names of the bodies that move; empty if there is no mechanism."""
        return () if self.verdict.mechanism is None else self.verdict.mechanism.moving

    def explain(self) -> str:
        """Explain in lines of text how the verdict came about: what was looked at, in order, and what decided.

        Bodies that touch each other are decided together, so every group of them has steps of its own.
        """
        lines = [f"{self.status}, by engine {self.engine} ({self.claim.words})"]
        for group in self.groups:
            lines += [f"{listed(group.bodies)}:", *group.verdict.explained.splitlines()]
        lines += [f"{'crushed' if one.crushed else 'bearing'}: {one.text}" for one in self.bearing]
        return "\n".join([*lines, *(f"note: {note}" for note in self.notes)])

    def summary(self) -> Summary:
        """Summarise the verdict and its reason."""
        facts = [("engine", f"{self.engine} ({self.claim.words})"), ("reason", self.reason)]
        standing = sum(group.verdict.status is Status.STABLE for group in self.groups)
        if len(self.groups) > 1:
            facts.append(("groups that stand", f"{standing} of {len(self.groups)}"))
        if self.mechanism is not None:
            facts.append(("moving", listed(self.moving)))
        if self.bearing:
            facts.append(("nearest to its limit", self.bearing[0].text))
        crushed = f", but {listed(self.crushed)} crushed" if self.crushed else ""
        return Summary(f"{self.status}{crushed}: {self.reason}", facts, notes=self.notes)


def stability(
    assembly: Assembly | Scene, *, loads: Iterable[Load] = (), engine: EngineChoice = DEFAULT_ENGINE
) -> Stability:
    """Decide whether the assembly stands under its weight and ``loads``.

    ``engine`` is the name of an engine, or an engine itself. An assembly that does not stand is an answer, not an
    error: see Stability. An assembly without movable bodies is UNDECIDED, because there is nothing to decide.

    For example:

    >>> found = hf.stability(hf.shipped_scene("stack"))
    >>> print(found.status)
    stable
    >>> print(found.reason)
    every contact on the way to the support presses and has friction to spare
    """
    assembly = checked_assembly(assembly)
    method = engine_of(engine)
    loads = checked_loads(loads)
    standing, pressed = total_wrench(assembly, loads), pressed_by(assembly, loads)
    state = prepared(method, assembly, standing)
    verdict = state.verdict() if assembly.movable else undecided("nothing here can move: every body is fixed")
    groups = state.verdicts
    notes = (*assembly.notes, *state.notes)
    bearing = bearings(assembly, groups, pressed)
    lacking = {*limited(assembly.bodies)} - {one.body for one in bearing}
    if verdict.stable and lacking:
        notes = (*notes, f"what {listed(sorted(lacking))} may bear was not compared: forces on it are not known")
    found = Stability(
        engine=method.name,
        claim=method.claim,
        verdict=verdict,
        groups=groups,
        notes=notes,
        bearing=bearing,
    )
    vars(found)["_margin_asked"] = partial(margin_of, method, assembly, standing, pressed)
    return asking(found, Question(assembly, standing))


def margin_of(
    engine: Engine, assembly: Assembly, standing: Float, pressed: Float, groups: Sequence[int] | None = None
) -> float:
    """Return the largest share m in [0, 1] by which either of two things may be worse, 0 if it does not surely stand.

    Every movable body of some ``groups``, by default of all, may bear m times its weight as a level force, all in the
    same direction, whichever that is; and all coefficients of friction may be (1 - m) times as large. Bodies that are
    only balanced bear no such force, and where no other is left, the share is 0. ``standing`` (6J,) [N, N m] are loads
    that act all the time, and ``pressed`` (B,) [N] is how much they press each body down. Nothing is crushed either
    way. Raises HoldfastError if the engine promises no lower bound.
    """
    numbers = np.flatnonzero(np.isin(assembly.group_of, range(len(assembly.groups)) if groups is None else groups))
    verdict = prepared(engine, assembly, standing).verdict_on(numbers.tolist())
    loaded = np.array([assembly.movable[k].name not in verdict.balanced for k in numbers], dtype=bool)
    if not verdict.stable or not loaded.any():
        return 0.0
    level = _level(engine, assembly, standing, pressed, numbers[loaded])
    stands, falls = 0.0, min(level, 1.0)

    def rests(share: float) -> bool:
        slippery = _slippery(assembly, 1 - share)
        return verdict_on_bearing(prepared(engine, slippery, standing), pressed, numbers.tolist()).stable

    if rests(falls):
        return falls
    while falls - stands > CLOSE:
        share = (stands + falls) / 2
        stands, falls = (share, falls) if rests(share) else (stands, share)
    return stands


def _slippery(assembly: Assembly, share: float) -> Assembly:
    """Return the assembly with this share of all friction, that of fingers and suction cups included."""
    less = assembly.with_mu([share * mu for mu in assembly.mu])
    if not assembly.scene.holds:
        return less
    holds = (altered(hold, mu=share * hold.mu) if isinstance(hold, Grip) else hold for hold in assembly.scene.holds)
    return replace(less, scene=replace(less.scene, holds=tuple(holds)))


def _level(engine: Engine, assembly: Assembly, standing: Float, pressed: Float, bodies: Int) -> float:
    """Return the share of the weight of some bodies that may act along any level direction, inf without gravity.

    Loads that move nothing form a convex set about 0, as far as they are known to be balanced, so that between two
    directions it reaches at least as far as the chord.
    """
    gravity = float(np.linalg.norm(assembly.scene.gravity))
    if not gravity:
        return np.inf
    ways = assembly.scene.horizontal_directions(WAYS)
    weight = np.zeros(len(assembly.movable))
    weight[bodies] = gravity * assembly.mass[bodies]
    W = np.column_stack([body_forces(weight[:, None] * way) for way in ways])
    state = prepared(engine, assembly, standing)
    found = unless_crushed(state.load_factor(W), state, W, (pressed, np.zeros((len(pressed), WAYS))))
    if found.lower_bound is Bound.NONE:
        remedy = "ask engine 'compliant' or 'limit'"
        raise HoldfastError(message("margin", f"engine {engine.name!r} promises no lower bound", remedy))
    return float(found.lower.min() * np.cos(np.pi / WAYS))
