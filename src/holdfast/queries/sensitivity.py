"""How one answer of engine ``limit`` changes with friction, masses, centres of mass and the point; the worst of a box.

Why: R is the largest s with G f + w_g + s w_e = 0 and f in the cones, so for a dual motion y with y·w_e = 1

    R = -y·w_g,   u = Gᵀy in the dual cones,   f·u = 0 at the optimum,

and where f and y are unique the derivative of R is that of the Lagrangian with f and y held (envelope theorem). As the
largest value of a cone program R is concave in w_g, and it grows with every cone: the facts ``worst_case`` rests on.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

import numpy as np

from holdfast.assembly.assembly import FIXED, Assembly
from holdfast.base.arrays import Float, Objects, checked, checked_number, objects, unit
from holdfast.base.errors import HoldfastError, SceneError, message
from holdfast.base.progress import report
from holdfast.engines.answers import Claim
from holdfast.engines.limit.engine import Limit, LimitState
from holdfast.engines.mechanism import describe, relative_velocity
from holdfast.engines.verdict import Status
from holdfast.queries.push import robustness
from holdfast.queries.request import Load, body_number, push_columns, total_wrench
from holdfast.scene.scene import Scene

MAX_CORNERS = 4096

Pair: TypeAlias = tuple[str, str]
MuRange: TypeAlias = float | tuple[float, float] | Mapping[Pair, tuple[float, float]]
MassRange: TypeAlias = float | Mapping[str, tuple[float, float]]
ComRange: TypeAlias = float | Mapping[str, Any]
Corner: TypeAlias = tuple[dict[str, float], dict[str, tuple[float, float, float]]]


@dataclass(frozen=True, eq=False)
class Sensitivity:
    """Derivatives of the largest push ``force`` [N] (between ``lower`` and ``upper``).

    ``d_mu`` [N] by the two bodies of an interface; ``d_mass`` [N/kg] by movable body, its centre of mass held;
    ``d_com`` (3,) [N/m] by movable body, for its centre of mass in the world, contacts held; ``d_point`` (3,) [N/m] for
    the point of the push, direction held. ``moving``: the bodies of the mechanism.
    """

    engine: str
    claim: Claim
    body: str
    force: float
    lower: float
    upper: float
    d_mu: dict[Pair, float]
    d_mass: dict[str, float]
    d_com: dict[str, Float]
    d_point: Float
    moving: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class WorstCase:
    """The smallest R at each of n points over all that is uncertain.

    ``force`` (n,) [N] with bounds ``lower``, ``upper`` and ``status`` (n,) as in Robustness: UNSTABLE where a corner
    does not stand, UNDECIDED (force 0) where a corner was not settled. ``nominal`` (n,) [N] is R without uncertainty.
    ``mu`` are the coefficients it is taken at; ``masses`` [kg] and ``coms`` (world [m]) (n,) hold, by uncertain body,
    the corner where each point is weakest. ``corners`` were tried. ``guarantee`` says what was proved.
    """

    engine: str
    claim: Claim
    body: str
    force: Float
    lower: Float
    upper: Float
    status: Objects
    nominal: Float
    mu: dict[Pair, float]
    masses: Objects
    coms: Objects
    corners: int
    guarantee: str


GUARANTEE = (
    "exact for engine limit: R grows with every friction coefficient, is concave in the weights' wrench, and that is "
    "affine in each mass and in each centre of mass, so a corner of the box is weakest"
)


def sensitivity(
    assembly: Assembly,
    body: str,
    point: Any,  # noqa: ANN401 - (3,) numbers, checked
    direction: Any,  # noqa: ANN401 - (3,) numbers, checked
    *,
    standing: Iterable[Load] = (),
) -> Sensitivity:
    """Derivatives of R(p, e) by engine ``limit``, all from one solve; ``point``, ``direction`` (3,) world.

    They hold where R is differentiable: one mechanism, and contact forces that are unique where it slides. At a kink
    (two mechanisms at the same push) they belong to one of the mechanisms or a mean of them, and in masses they still
    bound R from above (R is concave in them); whether a kink is met is not tested. Contact nodes, the push and
    standing loads stay where they are. Raises HoldfastError where R is zero, infinite or undecided.
    """
    where = f"sensitivity of {body!r}"
    p = checked(point, (3,), f"{where}: point")
    e = checked(direction, (3,), f"{where}: direction")
    if not np.linalg.norm(e) > 0:
        raise SceneError(message(where, "the direction is zero", "needs a vector with a length"))
    e, number = unit(e), body_number(assembly, body)
    state = Limit().prepare(assembly, total_wrench(assembly, standing))
    verdict = state.verdict()
    if not verdict.equilibrium_exists:
        raise HoldfastError(message(where, f"the assembly is {verdict.status}", verdict.reason))
    solved = state.solve(push_columns(assembly, number, p[None], e[None])[:, 0])
    if solved.twists is None:
        problem = f"the push is {solved.status}"
        raise HoldfastError(message(where, problem, "there are derivatives only where a finite push moves something"))
    motion = solved.twists.reshape(-1, 6)
    names = [b.name for b in assembly.movable]
    pull = assembly.mass[:, None] * assembly.scene.gravity
    d_com = -np.cross(pull, motion[:, 3:])
    return Sensitivity(
        state.engine.name,
        state.engine.claim,
        body,
        solved.factor,
        solved.lower,
        solved.upper,
        _by_friction(state, motion),
        {name: float(v) for name, v in zip(names, -motion[:, :3] @ assembly.scene.gravity, strict=True)},
        dict(zip(names, d_com, strict=True)),
        -solved.factor * np.cross(e, motion[number, 3:]),
        describe(state.kinematics, motion, "none", dual=True).moving,
    )


def _by_friction(state: LimitState, motion: Float) -> dict[Pair, float]:
    """dR/dμ of every pair: Σ |u_t| f_n over its nodes, for where a node slides its multiplier is |u_t|."""
    assembly, nodes = state.assembly, state.rest.nodes
    prepared, _ = state._prepared
    normal = prepared.solve().x[:-1].reshape(-1, 3)[:, 0] * assembly.weight
    slip = np.linalg.norm(relative_velocity(nodes, assembly.com, motion)[:, 1:], axis=1)
    found = dict.fromkeys((interface.bodies for interface in assembly.interfaces), 0.0)
    for k, share in zip(nodes.interface, slip * np.maximum(normal, 0), strict=True):
        found[assembly.interfaces[k].bodies] += float(share)
    return found


def worst_case(
    assembly: Assembly,
    body: str,
    points: Any,  # noqa: ANN401 - (n, 3) or (3,) numbers, checked
    directions: Any,  # noqa: ANN401 - (n, 3) or (3,) numbers, checked
    *,
    mu: MuRange | None = None,
    mass: MassRange | None = None,
    com: ComRange | None = None,
    standing: Iterable[Load] = (),
) -> WorstCase:
    """The smallest R(p, e) by engine ``limit`` over intervals of friction and boxes of masses and centres of mass.

    ``mu``: a relative width (0.2: ± 20 %) or (low, high) for all touching pairs, or a dict of (low, high) by the two
    bodies' names. ``mass``: a relative width for all movable bodies, or a dict of (low, high) [kg] by body. ``com``: a
    half width [m] for all movable bodies, or a dict of half widths (3,) [m] by body: a box along the world axes around
    the centre of mass. What is not named is taken as known. Poses, contacts and points stay as they are.

    Exact, not sampled: the lower end of every μ, and of masses and centres of mass all corners (``guarantee`` says
    why), at one set-up each. Their number doubles with every uncertain value (shifts along gravity do not count); more
    than 4,096 raise HoldfastError.
    """
    where = f"worst case of {body!r}"
    loads = list(standing)
    nominal = robustness(assembly, body, points, directions, loads, engine="limit")
    low = {pair: ends[0] for pair, ends in friction_intervals(assembly, mu, where).items()}
    rough = assembly if mu is None else with_friction(assembly, low)
    corners = _corners(rough, _mass_boxes(rough, mass, where), _com_boxes(rough, com, where), where)
    columns = push_columns(rough, body_number(rough, body), nominal.points, nominal.directions)
    base = total_wrench(rough, loads)
    n = len(nominal.force)
    lower, upper = np.full(n, np.inf), np.full(n, np.inf)
    worst = [(len(_WEAKEST_FIRST), np.inf, 0)] * n
    for number, corner in enumerate(corners):
        report("worst case", number, len(corners))
        found = Limit().prepare(rough, base + _change(rough, corner)).load_factor(columns)
        lower, upper = np.minimum(lower, found.lower), np.minimum(upper, found.upper)
        ranks = [_WEAKEST_FIRST.index(status) for status in found.status]
        here = zip(ranks, found.force.tolist(), [number] * n, strict=True)
        worst = [min(pair) for pair in zip(worst, here, strict=True)]
    report("worst case", len(corners), len(corners))
    return WorstCase(
        nominal.engine,
        nominal.claim,
        body,
        np.array([force for _, force, _ in worst]),
        lower,
        upper,
        objects([_WEAKEST_FIRST[rank] for rank, _, _ in worst]),
        nominal.force,
        low,
        objects([corners[k][0] for _, _, k in worst]),
        objects([corners[k][1] for _, _, k in worst]),
        len(corners),
        GUARANTEE,
    )


_WEAKEST_FIRST = (Status.UNSTABLE, Status.UNDECIDED, Status.FINITE, Status.INFINITE)


def friction_intervals(assembly: Assembly, mu: MuRange | None, where: str) -> dict[Pair, tuple[float, float]]:
    """(low, high) of the coefficient of every touching pair."""
    pairs = {i.bodies: m for i, m in zip(assembly.interfaces, assembly.mu, strict=True)}
    if mu is None:
        return {p: (m, m) for p, m in pairs.items()}
    if isinstance(mu, Mapping):
        given = {frozenset(pair): interval for pair, interval in mu.items()}
        unknown = [pair for pair in mu if frozenset(pair) not in {frozenset(p) for p in pairs}]
        if unknown:
            raise SceneError(message(f"{where}: mu", f"no contact between {unknown[0]!r}", "name touching bodies"))
        return {p: _interval(given.get(frozenset(p), (m, m)), f"{where}: mu of {p!r}") for p, m in pairs.items()}
    if isinstance(mu, tuple | list):
        return dict.fromkeys(pairs, _interval(mu, f"{where}: mu"))
    width = _width(mu, f"{where}: mu")
    return {p: (m * (1 - width), m * (1 + width)) for p, m in pairs.items()}


def with_friction(assembly: Assembly, mu: Mapping[Pair, float]) -> Assembly:
    """The assembly with these coefficients, by the two bodies' names; its contacts stay."""
    old = assembly.scene
    known = {(min(p), max(p)): m for p, m in mu.items()}
    table = replace(old.friction, pairs={**old.friction.pairs, **known})
    return replace(assembly, scene=Scene(old.bodies, table, old.gravity, old.name))


def _mass_boxes(assembly: Assembly, mass: MassRange | None, where: str) -> dict[str, tuple[float, float]]:
    """(low, high) [kg] by body."""
    if mass is None:
        return {}
    if not isinstance(mass, Mapping):
        width = _width(mass, f"{where}: mass")
        return {
            b.name: (m * (1 - width), m * (1 + width)) for b, m in zip(assembly.movable, assembly.mass, strict=True)
        }
    _check_movable(assembly, mass, f"{where}: mass")
    return {name: _interval(interval, f"{where}: mass of {name!r}") for name, interval in mass.items()}


def _com_boxes(assembly: Assembly, com: ComRange | None, where: str) -> dict[str, Float]:
    """Half widths (3,) [m] by body."""
    if com is None:
        return {}
    if not isinstance(com, Mapping):
        width = checked_number(com, f"{where}: com", minimum=0)
        return {b.name: np.full(3, width) for b in assembly.movable}
    _check_movable(assembly, com, f"{where}: com")
    boxes = {name: checked(half, (3,), f"{where}: com of {name!r}") for name, half in com.items()}
    for name, half in boxes.items():
        if (half < 0).any():
            raise SceneError(message(f"{where}: com of {name!r}", f"is {half.tolist()}", "needs half widths >= 0"))
    return boxes


def _corners(
    assembly: Assembly, masses: Mapping[str, tuple[float, float]], coms: Mapping[str, Float], where: str
) -> list[Corner]:
    """All corners of the boxes: masses [kg] and world centres of mass [m] by uncertain body."""
    gravity = assembly.scene.gravity
    matters = [k for k in range(3) if np.linalg.norm(np.delete(gravity, k)) > 0]  # weight may slide along itself
    values: list[tuple[str, int, tuple[float, ...]]] = [
        (name, -1, tuple(dict.fromkeys(interval))) for name, interval in masses.items()
    ]
    values += [(name, k, (-half[k], half[k])) for name, half in coms.items() for k in matters if half[k] > 0]
    count = int(np.prod([len(choices) for _, _, choices in values], dtype=object))
    if count > MAX_CORNERS:
        problem = f"{len(values)} uncertain values have {count:,} corners"
        raise HoldfastError(message(where, problem, f"at most {MAX_CORNERS:,}: name the bodies that matter"))
    corners = []
    for chosen in itertools.product(*(choices for _, _, choices in values)):
        weights: dict[str, float] = {}
        centres = {name: assembly.com[assembly.index[name]].tolist() for name in coms}
        for (name, axis, _), value in zip(values, chosen, strict=True):
            if axis < 0:
                weights[name] = value
            else:
                centres[name][axis] += value
        corners.append((weights, {name: (c[0], c[1], c[2]) for name, c in centres.items()}))
    return corners


def _change(assembly: Assembly, corner: Corner) -> Float:
    """(6J,) what the corner's masses and centres of mass add to the weights' wrench about the nominal centres."""
    masses, coms = corner
    change = np.zeros((len(assembly.movable), 6))
    for name in {**masses, **coms}:
        k = assembly.index[name]
        pull = masses.get(name, float(assembly.mass[k])) * assembly.scene.gravity
        change[k, :3] = pull - assembly.mass[k] * assembly.scene.gravity
        change[k, 3:] = np.cross(np.array(coms.get(name, assembly.com[k])) - assembly.com[k], pull)
    return change.ravel()


def _check_movable(assembly: Assembly, names: Iterable[str], where: str) -> None:
    for name in names:
        if body_number(assembly, name) == FIXED:
            raise SceneError(message(where, f"{name!r} is fixed", "name movable bodies"))


def _interval(value: Any, where: str) -> tuple[float, float]:  # noqa: ANN401
    low, high = (float(v) for v in checked(value, (2,), where))
    if not 0 <= low <= high:
        raise SceneError(message(where, f"is ({low:g}, {high:g})", "needs 0 <= low <= high"))
    return low, high


def _width(value: Any, where: str) -> float:  # noqa: ANN401
    width = checked_number(value, where, minimum=0)
    if width >= 1:
        raise SceneError(message(where, f"relative width {width:g}", "needs less than 1; give (low, high) instead"))
    return width
