"""Compute how fast the carrier may accelerate before something moves on it (Nadeau & Kelly, Sec. VII-B, Algorithm 3).

The fixed bodies are the carrier; a tilted one is the same scene with its gravity rotated. In its frame, a body
with mass m and inertia I (about its centre of mass, which is at r from the pivot) is subject to its weight and, by
d'Alembert's principle, to

    force  -m (a + α x r + ω x (ω x r))        torque  -I α - ω x I ω

Here a is the acceleration of the carrier at the pivot, α its angular acceleration and ω its angular velocity. All
vectors are along the axes of the scene, which move with the carrier. At s times the speed, a and α are multiplied by s²
and ω by s, so every force and torque is multiplied by s².
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from holdfast.assembly.assembly import FIXED, Assembly, body_forces
from holdfast.base.archive import to_dict
from holdfast.base.arrays import Bool, Float, checked, checked_directions, checked_number, objects
from holdfast.base.errors import HoldfastError, SceneError, hinting, message
from holdfast.base.painters import paint
from holdfast.base.public import Of, Summary, column
from holdfast.base.ranges import ACCELERATION, PLACE, TURNING
from holdfast.base.text import listed, quoted
from holdfast.certificates.certified import Certified, asking
from holdfast.certificates.question import Question
from holdfast.engines.answers import Claim, Undecided
from holdfast.engines.imperfect import Imperfect
from holdfast.queries import request
from holdfast.queries.push import load_factors
from holdfast.queries.request import DEFAULT_ENGINE, EngineChoice, Load
from holdfast.queries.result import ROW, Columns, least, vector_text, verdict_words
from holdfast.queries.sampler import Sample, Sampled, sampler
from holdfast.queries.sets import ConvexSet
from holdfast.queries.uncertain import Uncertain
from holdfast.scene.scene import Scene

# ω ωᵀ where one of the products that ``motion_coordinates`` ends with is 1 and the others are 0
SQUARES = np.zeros((6, 3, 3))
for _k, (_i, _j) in enumerate([(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)]):
    SQUARES[_k, _i, _j] = SQUARES[_k, _j, _i] = 1.0
SQUARES.setflags(write=False)
PARALLEL = 1e-9  # largest 1 - cosine at which an acceleration counts as parallel to the direction of a limit


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
    given_assembly = request.checked_assembly(assembly)
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


class TransportLimits(Certified, Columns):
    """The largest acceleration of the carrier along each of n directions before anything moves on it.

    ``acceleration`` (n,) [m/s²] is along the unit ``directions`` (n, 3), in the axes of the scene. ``status`` (n,) says
    what it means: FINITE; INFINITE; UNSTABLE (the acceleration is 0: the assembly does not stand on the carrier even at
    rest); UNDECIDED (the acceleration 0 is no answer: see ``undecided``). ``lower`` and ``upper`` (n,) [m/s²] bound the
    true answer as far as the engine can promise. ``moving`` (names), ``mode`` and ``mechanism``, each (n,), say what
    gives way; where the mode is "crush", a body bears as much as it may. ``verdict`` says whether ``assembly`` stands
    on the carrier before it accelerates.
    """

    assembly: Assembly
    directions: Float = column("n 3")

    unit = "m/s²"
    heads = ("along", "answer")
    plain = f"directions acceleration {ROW}"

    acceleration = Of[Float]("answers.force", "The largest acceleration (n,) [m/s²] before anything moves.")

    def save_png(
        self,
        path: str | os.PathLike[str],
        *,
        others: Sequence[TransportLimits] = (),
        names: Sequence[str] | None = None,
    ) -> None:
        """Draw the limits along horizontal directions as a polar plot (PNG).

        The limits in ``others``, of the same assembly, are drawn beneath. ``names`` are the texts of the legend, first
        that of these limits and then those of ``others``; by default they are the names of the engines.
        """
        paint(self, path, ".png", others=others, names=names)

    def about(self) -> dict[str, Any]:
        """Return what applies to the whole table as plain data, with the scene and its gravity."""
        scene = self.assembly.scene
        return {"scene": scene.name, "gravity": to_dict(scene.gravity)} | super().about()

    def where(self, row: int) -> dict[str, Any]:
        """Return the direction that a row answers, as plain data."""
        return {"direction": to_dict(self.directions[row])}

    def summary(self) -> Summary:
        """Summarise the answer by the directions with the smallest limits."""
        name = self.assembly.scene.name or "assembly"
        how_much = least(self.answers, "m/s²")
        headline = (
            f"{name} on its carrier: {verdict_words(self.verdict)}; {len(self.directions):,} directions, {how_much}"
        )
        places = objects([vector_text(way, ".3f") for way in self.directions])
        return self.table(headline, places)


def transport_limits(
    assembly: Assembly | Scene,
    directions: ArrayLike | None = None,
    *,
    tilt_degrees: ArrayLike | None = None,
    standing: Iterable[Load] = (),
    engine: EngineChoice = DEFAULT_ENGINE,
    bodies: Sequence[str] | None = None,
    bounds: bool = False,
    imperfect: Imperfect | None = None,
) -> TransportLimits:
    """Compute the largest acceleration of the carrier along each direction before anything moves on it.

    ``directions`` (n, 3) or (3,), in the axes of the scene, need not have unit length; by default they are 100
    horizontal directions. The carrier is tilted throughout by ``tilt_degrees`` (3,), see ``Scene.tilted``. The
    ``standing`` loads act throughout; for a carrier that also rotates or is jolted, give the ``inertial_loads`` of that
    motion. ``bounds`` and ``imperfect`` have the same meaning as in ``robustness``.

    By default the limit is the acceleration at which anything moves. With ``bodies``, a list of names, only these
    bodies count and the groups that they belong to: all movable bodies that touch them, directly or through others. So
    an orange that rolls off a fixed shelf does not determine the limit of the boxes beside it. ``notes`` name the
    bodies that do not count.

    Raises SceneError if there is no direction, if one is zero, or if one of ``bodies`` is unknown or fixed.

    For example, 1 kg on friction of 0.6:

    >>> limits = hf.transport_limits(hf.shipped_scene("cube"), (1, 0, 0))
    >>> print(f"{limits.lower[0]:.2f} m/s², {limits.mode[0]}")
    5.89 m/s², slip
    """
    given = _on_carrier(assembly, tilt_degrees)
    if directions is None:
        ways = given.scene.horizontal_directions()
    else:
        ways = checked_directions(directions, "transport_limits: directions")
        if not len(ways):
            raise SceneError(message("transport_limits: directions", "is empty", "needs at least one"))
    method = request.engine_of(engine)
    counted, note = counted_bodies(given, bodies, "transport_limits")
    W = carrier_columns(given, counted, ways)
    standing = request.checked_loads(standing)
    standing_wrench = request.total_wrench(given, standing)
    pressed = request.pressed_by(given, standing), np.zeros((len(given.bodies), len(ways)))
    found = load_factors(method, given, W, standing_wrench, bounds=bounds, imperfect=imperfect, pressed=pressed)
    found = replace(found, notes=(*found.notes, *note))
    return asking(
        TransportLimits(answers=found, assembly=given, directions=ways), Question(given, standing_wrench, None, W)
    )


def _on_carrier(assembly: Assembly | Scene, tilt_degrees: ArrayLike | None) -> Assembly:
    """Return the assembly on a carrier that is tilted throughout."""
    given = request.checked_assembly(assembly)
    return given if tilt_degrees is None else given.tilted(tilt_degrees)


def carrier_columns(assembly: Assembly, counted: Bool, ways: Float) -> Float:
    """Return the load columns W (6J, n) of a carrier that accelerates by 1 m/s² along ``ways`` (n, 3).

    Only the ``counted`` bodies (J,) have inertia.
    """
    mass = np.where(counted, assembly.mass, 0.0)
    return np.column_stack([body_forces(-mass[:, None] * way) for way in ways])


def counted_bodies(assembly: Assembly, bodies: Sequence[str] | None, where: str) -> tuple[Bool, tuple[str, ...]]:
    """Return which movable bodies (J,) are in the groups of ``bodies`` (None: all), and a note on the others.

    ``where`` names the question in the errors: SceneError for a body that is unknown or fixed.
    """
    if bodies is None:
        return np.ones(len(assembly.movable), dtype=bool), ()
    numbers = request.body_numbers(assembly, bodies, where)
    fixed = [name for name, number in numbers.items() if number == FIXED]
    if fixed:
        raise SceneError(message(where, f"{quoted(fixed[0])} is fixed", "name movable bodies"))
    counted = np.isin(assembly.group_of, assembly.group_of[list(numbers.values())])
    others = [body.name for body, taken in zip(assembly.movable, counted, strict=True) if not taken]
    return counted, (
        f"the limits do not apply to these bodies, which may move earlier: {listed(others)}",
    ) if others else ()


def safe_time_scale(
    accelerations: ArrayLike,
    limits: ConvexSet | TransportLimits,
    *,
    margin: float = 0.0,
) -> float:
    """Return the largest factor s on the speed along a path at which all its accelerations stay within the limits.

    ``accelerations`` (n, 3) [m/s²] are those of the carrier along the path, in the axes of the scene. If the path q(t)
    is followed as q(s t), they are multiplied by s². A factor below 1 means that the path must be slowed down to it. It
    is inf if the path has no acceleration.

    ``limits`` are a set of sustainable accelerations that hold, of which ``inner`` is used, or the transport
    limits along those ``accelerations`` that are not zero, of which ``lower`` is used. ``margin`` in [0, 1) is the
    share of every limit that remains unused. The result is valid only if the carrier keeps its orientation and its
    load.

    Raises HoldfastError if ``margin`` is out of range, or if the limits are along other directions or do not say what
    holds, as those of engine ``limit``.
    """
    where = "safe_time_scale"
    a = checked(accelerations, (None, 3), f"{where}: accelerations", within=ACCELERATION)
    if isinstance(limits, ConvexSet | TransportLimits) and limits.claim is not Claim.HOLDS:
        problem = f"engine {limits.engine!r} does not say what holds, but {limits.claim.words}"
        raise HoldfastError(message(where, problem, "take limits of the default engine"))
    used = np.atleast_1d(limits.usage(a)) if isinstance(limits, ConvexSet) else _usage(a, limits)
    return speed_within(used, margin, where)


def _usage(a: Float, limits: object) -> Float:
    """Return the share of its limit that each nonzero acceleration uses."""
    if not isinstance(limits, TransportLimits):
        remedy = "needs hf.sets.sustainable_accelerations(...) or hf.transport_limits(...)"
        raise HoldfastError(message("safe_time_scale: limits", f"is a {type(limits).__name__}", remedy))
    size = np.linalg.norm(a, axis=1)
    a, size = a[size > 0], size[size > 0]
    ways = limits.directions
    if len(a) != len(ways) or (np.einsum("nk,nk->n", a, ways) < (1 - PARALLEL) * size).any():
        remedy = "ask transport_limits along the accelerations of the path that are not zero, or give a set"
        raise HoldfastError(message("safe_time_scale", "the limits are along other directions", remedy))
    return np.asarray(np.divide(size, limits.lower, out=np.full(len(a), np.inf), where=limits.lower > 0))


class TransportUnder(Sampled):
    """The largest acceleration of the carrier along each of n directions, in each of ``samples`` samples.

    ``acceleration`` (samples, n) [m/s²] is 0 where a sample does not stand, and inf where no acceleration moves
    anything. Where the sample or the limit is undecided, the 0 is no answer. ``status`` (samples, n) distinguishes
    these cases, as in TransportLimits, and ``undecided_limits`` counts the undecided ones. ``lower`` and ``upper``
    (samples, n) [m/s²] bound the true answer of each sample.

    ``stands`` is the share of samples that certainly stand on the carrier at rest (STABLE), and ``undecided`` the share
    that may stand; the remaining samples do not stand. ``nominal`` (n,) [m/s²] is the limit of the assembly as it was
    given, without uncertainty, and ``nominal_status`` (n,) is its status. The unit ``directions`` (n, 3) are in the
    axes of the scene. ``seed`` is the seed of the samples, and ``notes`` are the simplifications on which the answer
    depends.
    """

    unit: ClassVar[str] = "m/s²"
    place: ClassVar[str] = "along"

    scene: str
    directions: Float = column("n 3")

    plain = "scene directions acceleration status nominal nominal_status stands undecided undecided_limits samples seed"

    acceleration = Of[Float]("_values", "The largest acceleration (samples, n) [m/s²] before anything moves.")
    undecided_limits = Of[Undecided](
        "answers.undecided", "How many of the limits on all samples are not known (``count``, ``share``), and why."
    )

    def summary(self) -> Summary:
        """Summarise the answer by quantiles of the directions with the smallest medians."""
        headline = f"{self.samples} samples of {self.scene or 'assembly'} on its carrier"
        return self.weakest(headline, objects([vector_text(way, ".3f") for way in self.directions]))


@hinting(uncertain=Uncertain)
def transport_under(
    assembly: Assembly | Scene,
    directions: ArrayLike | None = None,
    uncertain: Uncertain | None = None,
    *,
    tilt_degrees: ArrayLike | None = None,
    standing: Iterable[Load] = (),
    engine: EngineChoice = DEFAULT_ENGINE,
    bodies: Sequence[str] | None = None,
) -> TransportUnder:
    """Compute how fast the carrier may accelerate in samples of uncertain poses, friction, masses and faces.

    ``directions``, ``tilt_degrees``, ``standing``, ``engine`` and ``bodies`` have the same meaning as in
    ``transport_limits``, and ``uncertain`` the same as in ``robustness_under``, from which the samples do not differ:
    standing loads move with their body, and directions stay fixed in the scene. With ``bodies``, ``stands`` is about
    the groups of these bodies alone.

    Raises SceneError as ``transport_limits`` does, and HoldfastError as ``robustness_under`` does. See
    docs/howto/uncertainty.md.
    """
    given = _on_carrier(assembly, tilt_degrees)
    method, loads = request.engine_of(engine), request.checked_loads(standing)
    samples = sampler(given, uncertain, method, loads, "transport under uncertainty")
    nominal = transport_limits(given, directions, standing=loads, engine=method, bodies=bodies)
    counted, _ = counted_bodies(given, bodies, "transport_under")

    def columns(sample: Sample) -> Float:
        return carrier_columns(sample.assembly, counted, nominal.directions)

    return TransportUnder(
        scene=given.scene.name,
        directions=nominal.directions,
        **samples.fields(nominal, np.flatnonzero(counted), columns),
    )
