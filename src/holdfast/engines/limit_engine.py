"""Engine ``limit``: limit analysis (limit_state.py), and whether the equilibrium that exists comes about.

The forces of limit analysis need not come about. Engine ``compliant`` tells, so this stands above limit/ and
compliant/, and limit/ knows nothing of compliant/.

Over a box of masses and centres of mass the worst case is at one of the corners. R is the largest value of a cone
program, and therefore concave in the wrench of the weights w_g, which is affine in each mass and in each centre of mass
while the others are held. A concave function on an interval is smallest at an end of the interval. Applied to one value
after another, this shows that R is smallest at a corner of the box.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from typing import Literal

import numpy as np
from scipy import sparse

from holdfast.assembly.assembly import Assembly
from holdfast.assembly.contact_nodes import ContactNodes, contact_nodes, equilibrium_operator, wrenches_of
from holdfast.assembly.strengths import with_pull
from holdfast.base.arrays import Bool, Float
from holdfast.base.errors import HoldfastError, message
from holdfast.base.progress import reported
from holdfast.base.public import Record
from holdfast.conic.solve import ConeProgram, Outcome, solve
from holdfast.engines.answers import Answers, joined
from holdfast.engines.compliant.engine import Compliant
from holdfast.engines.compliant.refinement import REFINEMENTS
from holdfast.engines.contract import Corner, State, Weakest
from holdfast.engines.forces import EXACT, ConeChoice, FrictionCone
from holdfast.engines.limit.limit_state import CLAIM, NAME, LimitState, balanced_under
from holdfast.engines.rest import Rest
from holdfast.engines.trees.forest import forest_of
from holdfast.engines.trees.tree_state import FIRM
from holdfast.engines.verdict import Status, Verdict
from holdfast.scene.hold import held_names

MAX_CORNERS = 4096  # largest number of corners, that of twelve uncertain values; each corner takes a program of its own

GUARANTEE = (
    "exact for engine limit: R grows with every friction coefficient, is concave in the weights' wrench, and that is "
    "affine in each mass and in each centre of mass, so a corner of the box is weakest"
)

# At 1 a force 0 that is known has its place: nothing can be weaker, except what does not stand
_WEAKEST_FIRST = {Status.UNSTABLE: 0, Status.UNDECIDED: 2, Status.FINITE: 3, Status.INFINITE: 4}


def weakest(
    assembly: Assembly, prepare: Callable[[Float], State], standing: Float, W: Float, corners: tuple[Corner, ...]
) -> Weakest:
    """Find the smallest value of the largest factor of each column of W (6J, n) over all ``corners``.

    ``prepare`` prepares the engine under a wrench (6J,) that acts in addition to the nominal weights. ``standing``
    (6J,) is the part of this wrench that is the same at every corner.
    """
    found = (prepare(standing + change_at(assembly, c)).load_factor(W) for c in reported("worst case", corners))
    answers, corner = least_of(found, "force")
    return Weakest(answers=answers, corner=corner, corners=corners, guarantee=GUARANTEE)


def least_of(tables: Iterable[Answers], by: Literal["force", "lower"]) -> tuple[Answers, tuple[int, ...]]:
    """Return the weakest of the answers to the same n loads in several tables, and the number of its table (n,) each.

    They are ranked ``by`` a column, after what does not stand and what is undecided. ``lower`` and ``upper`` are the
    least of all tables.
    """
    worst: dict[int, tuple[int, float, int]] = {}
    rows: dict[int, Answers] = {}
    lower, upper = np.array(np.inf), np.array(np.inf)
    for number, found in enumerate(tables):
        lower, upper = np.minimum(lower, found.lower), np.minimum(upper, found.upper)
        for k in range(len(found)):
            # an undecided corner may be weaker than every finite one above 0: the worst case is then undecided, too
            certain = found.status[k] is Status.FINITE and not found.force[k] > 0
            place = 1 if certain else _WEAKEST_FIRST[found.status[k]]
            here = (place, float(getattr(found, by)[k]), number)
            if k not in worst or here < worst[k]:
                worst[k], rows[k] = here, found.rows(slice(k, k + 1))
    answers = joined([rows[k] for k in range(len(rows))])
    force = np.minimum(answers.force, upper)  # another corner may have the least one
    return replace(answers, force=force, lower=lower, upper=upper), tuple(worst[k][2] for k in range(len(rows)))


def corners_of(
    assembly: Assembly, masses: Mapping[str, tuple[float, float]], coms: Mapping[str, Float], where: str
) -> tuple[Corner, ...]:
    """Return all corners of a box of masses and centres of mass, both keyed by body name.

    ``masses`` are intervals (low, high) [kg], and ``coms`` are half widths (3,) [m] along the world axes around the
    nominal centres of mass. ``where`` names the query in error messages. More than MAX_CORNERS raise HoldfastError.
    """
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
        corners.append(Corner(weights, {name: (c[0], c[1], c[2]) for name, c in centres.items()}))
    return tuple(corners)


def change_at(assembly: Assembly, corner: Corner) -> Float:
    """Return the change (6J,) of the wrench of the weights at a corner, about the nominal centres of mass."""
    change = np.zeros((len(assembly.movable), 6))
    for name in {**corner.masses, **corner.coms}:
        k = assembly.index[name]
        pull = corner.masses.get(name, float(assembly.mass[k])) * assembly.scene.gravity
        change[k, :3] = pull - assembly.mass[k] * assembly.scene.gravity
        change[k, 3:] = np.cross(np.array(corner.coms.get(name, assembly.com[k])) - assembly.com[k], pull)
    return change.ravel()


COMES_ABOUT = "an equilibrium exists that needs no self-stress"


class Limit(Record):
    """Static limit analysis over all corners of all patches, which carry whatever the patches can.

    ``cone``: "exact", or a polygon of ``sides`` "inscribed" (cautious) or "circumscribed" (optimistic).

    For example:

    >>> cube = hf.shipped_scene("cube")  # 1 kg, friction 0.6: it slips at 5.886 N
    >>> push = ("cube", (-0.05, 0, 0.05), (1, 0, 0))
    >>> print(f"{hf.robustness(cube, *push, engine=hf.Limit()).upper[0]:.3f} N")
    5.886 N
    """

    cone: ConeChoice = "exact"
    sides: int = 8

    name = NAME
    claim = CLAIM
    takes_holds = True

    def __post_init__(self) -> None:
        FrictionCone(self.cone, self.sides)

    def prepare(
        self, assembly: Assembly, standing: Float | None = None, acceleration: Float | None = None
    ) -> LimitState:
        """Test s = 0 first: an assembly that does not stand must not score because a push would hold it."""
        wrench = assembly.weight_wrench(acceleration)
        if standing is not None:
            wrench = wrench + standing
        return self.on(assembly, wrench)

    def firm(self, assembly: Assembly, wrench: Float) -> tuple[Bool, Verdict]:
        """Which bodies rest as trees; see ``Judging.firm``. Exact cones alone."""
        rests = np.zeros(len(assembly.movable), dtype=bool)
        if self.cone == "exact":
            rests = forest_of(assembly, wrench).decided
        return rests, replace(FIRM, reason=COMES_ABOUT)

    def on(self, assembly: Assembly, wrench: Float, nodes: ContactNodes | None = None) -> LimitState:
        """The state under ``wrench`` (6J,), on ``nodes`` if given (cautious: corners carry most)."""
        cone = FrictionCone(self.cone, self.sides)
        state = balanced_under(assembly, wrench, nodes, cone)
        return replace(state, rest=_rest_that_comes_about(state, assembly, wrench))

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
        """The smallest factor of each column of W over boxes of masses and centres of mass: at one of its corners."""
        return weakest(assembly, prepare, standing, W, corners_of(assembly, masses, coms, where))

    def comes_loose(self, assembly: Assembly, body: str, up: Float) -> bool:
        """Whether no contact can hold ``body``; over the exact cone, for a polygon inside it would prove nothing."""
        return comes_loose(assembly, body, up)


def _rest_that_comes_about(state: LimitState, assembly: Assembly, wrench: Float) -> Rest:
    """Return the rest of a state, STABLE only where its forces come about, else UNDECIDED though an equilibrium exists.

    Forces that build up on elastic contacts without any slip do. Where some contacts have to slip, forces in balance
    may press bodies together that nothing presses, and friction with the ground may hold them so, whatever the contacts
    that they need. Then engine ``compliant`` is asked whether contacts come to rest that slip as they are loaded. Holds
    are at will: they exert what leaves contacts well inside their cones.
    """
    rest, holds = state.rest, assembly.scene.holds
    verdict = rest.verdict
    if verdict.status is not Status.STABLE:
        return rest
    needed: bool | None = False
    if verdict.self_stress is not False:
        if holds:
            # on bodies that are held act holds with all that contacts do not balance
            given, own, inside = state.assembly, state.rest.nodes.contacts, state.proofs.resting
            forces = state.rest.forces if inside is None else inside.reshape(-1, 3)
            pressed = with_pull(given, wrenches_of(given, own, forces[: len(own)]))
            names = held_names(given.scene.holds)
            held = np.repeat([body.name in names for body in given.movable], 6)
            wrench = np.where(held, -pressed, wrench)
            assembly = replace(assembly, scene=replace(assembly.scene, holds=()))
        found = Compliant().on(assembly, wrench, refinements=REFINEMENTS).verdict()
        needed = {Status.STABLE: False, Status.UNSTABLE: None if holds else True}.get(found.status)
    if needed is False:
        return replace(rest, verdict=replace(verdict, self_stress=False, reason=COMES_ABOUT))
    reason = "an equilibrium exists, but it rests on contacts that would have to be pressed together by something else"
    if needed is None:
        reason = f"an equilibrium exists; whether it needs self-stress was not settled: {found.reason}"
    return replace(rest, verdict=replace(verdict, status=Status.UNDECIDED, self_stress=needed, reason=reason))


def comes_loose(assembly: Assembly, name: str, up: Float) -> bool:
    """Return True if it is proved that no contact holds the body ``name`` once its weight is supported.

    Suppose that the weight is supported and that an additional force c >= 0 acts along ``up`` (3,) at the centre of
    mass. The contacts of the body then have to balance this force alone. The function returns True if

        G_b f + c (up, 0) = 0,   f in the friction cones,   Σ f_n = 1,   c >= 0

    has no solution. All contact forces on the body are then zero from that moment on, whatever the other bodies do, and
    the body takes none of them along. The nodes are the corners of the patches, which can carry every load that the
    whole patches can carry. A body without contacts is loose.
    """
    k = assembly.index[name]
    every = contact_nodes(assembly, 4, "corners")
    nodes = every.chosen((every.a == k) | (every.b == k))
    if not len(nodes):
        return True
    size = assembly.scene.body(name).size
    G = sparse.csr_matrix(equilibrium_operator(assembly, nodes))[6 * k : 6 * k + 6]
    G = sparse.diags(np.repeat([1.0, 1 / size], 3)) @ G
    C, cones = EXACT.rows(nodes)
    count = 3 * len(nodes)
    pressing = np.zeros((1, count))
    pressing[0, ::3] = 1.0
    lift = np.concatenate([up, np.zeros(4 + C.shape[0])])
    A = sparse.hstack([sparse.vstack([G, sparse.csr_matrix(pressing), C]), sparse.csr_matrix(lift[:, None])])
    A = sparse.csc_matrix(sparse.vstack([A, sparse.csr_matrix(([-1.0], ([0], [count])), shape=(1, count + 1))]))
    b = np.zeros(A.shape[0])
    b[6] = 1.0
    program = ConeProgram(
        sparse.csc_matrix((count + 1, count + 1)),
        np.zeros(count + 1),
        A,
        b,
        (("zero", 7), *cones, ("nonnegative", 1)),
    )
    return solve(program, tolerance=1e-9).outcome is Outcome.INFEASIBLE
