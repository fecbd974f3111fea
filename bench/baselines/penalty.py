"""A discrete-element referee: rigid bodies on springs, dashpots and sliders, integrated in time.

Cundall & Strack (1979): at every contact node a normal spring and dashpot that cannot pull, and a tangential spring
that remembers how far it was stretched and slides at μ times the normal force. Explicit steps in time. Displacements
are small: nodes and normals stay where they are. Cundall's local damping (a share of each unbalanced force, against
the motion) removes the energy; it vanishes at rest, so it cannot hold a body that drifts.

Only the nodes and their tributary areas are shared with the engines; no equilibrium is ever solved for. Friction
depends on history here, whereas the law of engine ``compliant`` depends on displacements alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from bench.baselines.search import Peak, Trial, grid_nodes, no_peak, push
from holdfast.assembly.assembly import Assembly
from holdfast.assembly.contact_nodes import ContactNodes
from holdfast.base.arrays import Float, Int

SIDE = 7  # nodes along a side unless given
SINK = 1e-6  # compression of contacts under the weight, in sizes of the assembly; verdicts do not depend on it
DAMPING = 0.6  # damping of unbalanced forces
DASHPOT = 0.2  # damping, as a share of the critical damping of the fastest vibration
STEP = 0.4  # time step times the fastest angular frequency; 2 is the limit of stability
BALANCED = 1e-6  # largest unbalanced force at rest, in total weights (torques divided by the assembly's size)
FAR = 20.0  # times the displacement before a load step: a node displaced farther counts as moving
UNWEIGHED = (
    10.0  # times SINK, and the clearances: taken for the displacement before the first load step, where it is zero
)
CHECK = 200  # time steps between two checks for motion, and at balance before the assembly counts as resting
MOST = 400_000  # time steps after which neither rest nor motion was seen
FIRST = 0.02  # total weights: the first step of load
GROWTH = 0.08  # largest step of the load, as a share of it
PARTS = 100  # equal steps in which a given load comes on
ENDLESS = 30.0  # total weights: the largest load that is tried

REST, MOVES, NEITHER = 0, 1, 2


class Blocks(NamedTuple):
    """J bodies and I nodes: ``a``, ``b`` (I,) bodies (FIXED: -1); ``on_a``, ``on_b`` (I, 3, 6) a unit force along each
    axis of a node as a wrench on the body; ``k`` (I,) [N/m], ``c`` (I,) [N s/m], ``mu`` (I,); ``apart`` (I,) [m] the
    distance of the faces before anything moves; ``inverse`` (J, 6, 6) of the masses; ``lever`` (6,) that makes torques
    forces; ``ratio`` tangential over normal stiffness; ``dt`` [s].
    """  # noqa: D205

    a: Int
    b: Int
    on_a: Float
    on_b: Float
    k: Float
    c: Float
    mu: Float
    apart: Float
    inverse: Float
    lever: Float
    ratio: float
    dt: float


@dataclass(frozen=True, eq=False)
class State:
    """Displacements and velocities q, v (J, 6) [m, rad, m/s, rad/s] and the tangential springs z (I, 2) [m]."""

    q: Float
    v: Float
    z: Float

    def copy(self) -> State:
        """An independent copy, which can be integrated further."""
        return State(self.q.copy(), self.v.copy(), self.z.copy())


def holds(
    assembly: Assembly,
    load: Float | None = None,
    nodes: ContactNodes | None = None,
) -> Trial:
    """Whether the assembly comes to rest under its weight, and then under ``load`` (6J,) [N, N m] as well.

    The weight comes on at once, the load in PARTS steps; the drift returned is that of the last. ``nodes``: grids of
    SIDE x SIDE on every (rectangular) patch unless given. Tangential and normal stiffness are equal.
    """
    nodes = grid_nodes(assembly, SIDE) if nodes is None else nodes
    model = blocks(assembly, nodes)
    weight = assembly.weight_wrench()
    state, trial = settled(assembly, model, weight, still(assembly, nodes))
    if load is not None and trial.holds:
        steps = trial.steps
        for k in range(PARTS):
            state, trial = settled(assembly, model, weight + (k + 1) / PARTS * load, state)
            steps += trial.steps
            if not trial.holds:
                break
        trial = Trial(trial.holds, trial.drift, trial.speed, steps)
    return trial


def peak(
    assembly: Assembly,
    body: str,
    point: Float,
    direction: Float,
    nodes: ContactNodes | None = None,
    *,
    ratio: float = 1.0,
    accuracy: float = 1e-3,
    apart: Float | None = None,
) -> Peak:
    """The largest push [N] at ``point`` [m] of ``body`` along ``direction`` that comes to rest, found by raising it.

    Every step of load starts from rest under the one before; where the assembly moves, it goes back there and takes a
    smaller step, down to ``accuracy`` times the load. ``nodes`` as in ``holds``; ``ratio``: tangential over normal
    stiffness. ``apart`` (I,) is the clearance of each node, in units of the compression of all contacts under the
    weight; 0 unless given.
    """
    nodes = grid_nodes(assembly, SIDE) if nodes is None else nodes
    column = push(assembly, body, point, direction)
    model = blocks(assembly, nodes, ratio, apart)
    weight = assembly.weight_wrench()
    state, trial = settled(assembly, model, weight, still(assembly, nodes))
    if not trial.holds:
        return no_peak(trial)
    held, moves, step = 0.0, np.inf, FIRST * assembly.weight
    steps, undecided, drift, drift_beyond = trial.steps, 0, 0.0, 0.0
    while held < ENDLESS * assembly.weight and step > accuracy * held:
        tried, trial = settled(assembly, model, weight + (held + step) * column, state)
        steps += trial.steps
        if trial.holds:
            held, state, drift = held + step, tried, trial.drift
            step = min(1.5 * step, GROWTH * held) if np.isinf(moves) else (moves - held) / 2
        else:
            undecided += trial.holds is None
            moves, drift_beyond = held + step, trial.drift
            step /= 2
    return Peak(held, moves, drift, drift_beyond, undecided, steps)


def blocks(assembly: Assembly, nodes: ContactNodes, ratio: float = 1.0, apart: Float | None = None) -> Blocks:
    """The bodies and springs of an assembly; springs are as stiff as their tributary area is large.

    ``apart`` as in ``peak``.
    """
    centre = np.vstack([assembly.com, np.zeros((1, 3))])  # the last one is FIXED
    on = []
    for sign, end in ((-1.0, nodes.a), (1.0, nodes.b)):
        arm = nodes.points - centre[end]
        wrench = sign * np.concatenate([nodes.axes, np.cross(arm[:, None], nodes.axes)], axis=2)
        on.append(np.where((end >= 0)[:, None, None], wrench, 0.0))
    k = nodes.weights / nodes.weights.sum() * (assembly.weight or 1.0) / (SINK * assembly.size)
    count = len(assembly.movable)
    inverse = np.zeros((count, 6, 6))
    for j, body in enumerate(assembly.movable):
        assert body.mass is not None
        turn = body.pose[:3, :3]
        inverse[j, :3, :3] = np.eye(3) / body.mass
        inverse[j, 3:, 3:] = turn @ np.linalg.inv(body.inertia_com) @ turn.T
    masses = np.zeros((6 * count, 6 * count))
    for j in range(count):
        masses[6 * j : 6 * j + 6, 6 * j : 6 * j + 6] = inverse[j]
    fastest = float(np.sqrt(np.abs(np.linalg.eigvals(masses @ stiffness(nodes.a, nodes.b, on, k, ratio, count))).max()))
    lever = np.repeat([1.0, 1 / assembly.size], 3)
    c = 2 * DASHPOT / fastest * k
    on_a, on_b = (np.ascontiguousarray(w) for w in on)
    mu = np.ascontiguousarray(nodes.mu)
    clear = np.zeros(len(nodes)) if apart is None else SINK * assembly.size * apart
    return Blocks(nodes.a, nodes.b, on_a, on_b, k, c, mu, clear, inverse, lever, ratio, STEP / fastest)


def stiffness(a: Int, b: Int, on: Sequence[Float], k: Float, ratio: float, count: int) -> Float:
    """The stiffness (6J, 6J) of J bodies whose nodes all stick; arguments as in ``Blocks``, both wrenches in ``on``."""
    total = np.zeros((6 * count + 6, 6 * count + 6))  # the last body is FIXED
    for i in range(len(k)):
        rows = np.r_[6 * (a[i] % (count + 1)) + np.arange(6), 6 * (b[i] % (count + 1)) + np.arange(6)]
        B = np.hstack([on[0][i], on[1][i]])
        total[np.ix_(rows, rows)] += k[i] * (B.T * [1, ratio, ratio]) @ B
    return total[:-6, :-6]


def bonded(m: Blocks, load: Float) -> float:
    """The largest relative displacement [m] of a node under ``load`` (6J,) if all nodes stick and none opens."""
    count = len(load) // 6
    q = np.linalg.lstsq(stiffness(m.a, m.b, (m.on_a, m.on_b), m.k, m.ratio, count), load, rcond=None)[0]
    return float(apart(m, np.asarray(q, np.float64).reshape(-1, 6), np.zeros((count, 6))))


def still(assembly: Assembly, nodes: ContactNodes) -> State:
    """The state without displacements, velocities and tangential forces."""
    shape = (len(assembly.movable), 6)
    return State(np.zeros(shape), np.zeros(shape), np.zeros((len(nodes), 2)))


def settled(
    assembly: Assembly, model: Blocks, wrench: Float, state: State, far: float | None = None, most: int = MOST
) -> tuple[State, Trial]:
    """Integrate from ``state`` under ``wrench`` (6J,) until rest or motion is seen; the last state and the verdict.

    What a node is displaced by beyond ``far`` [m] is motion (FAR unless given); ``most`` time steps are made.
    """
    end = state.copy()
    first = UNWEIGHED * SINK * assembly.size + float(np.abs(model.apart).max(initial=0.0))
    far = FAR * (extent(model, state) or first) if far is None else far
    outcome = np.zeros(3)
    kind = run(model, wrench.reshape(-1, 6), end.q, end.v, end.z, BALANCED * assembly.weight, far, most, outcome)
    return end, Trial({REST: True, MOVES: False}.get(kind), float(outcome[0]), float(outcome[1]), int(outcome[2]))


def extent(model: Blocks, state: State) -> float:
    """The largest relative displacement [m] of a node."""
    return float(apart(model, state.q, np.zeros_like(state.q)))


def matrix(m: Blocks) -> Float:
    """What makes the relative displacements (3, I) of all nodes, one row after the other, of displacements (6J,)."""
    count = len(m.k)
    found = np.zeros((3, count, m.inverse.shape[0], 6))
    for body, on in ((m.a, m.on_a), (m.b, m.on_b)):
        for i in np.flatnonzero(body >= 0):
            found[:, i, body[i]] += on[i]
    return found.reshape(3 * count, -1)


def apart(m: Blocks, q: Float, other: Float) -> float:
    """The largest relative displacement [m] of a node between displacements q and ``other`` (J, 6)."""
    u = (matrix(m) @ (q - other).ravel()).reshape(3, -1)
    return float(np.sqrt((u * u).sum(0).max(initial=0.0)))


def run(
    m: Blocks, wrench: Float, q: Float, v: Float, z: Float, balanced: float, far: float, most: int, outcome: Float
) -> int:
    """Integrate q, v, z in place until rest (REST), motion (MOVES) or ``most`` time steps (NEITHER).

    Rest: unbalanced forces stay within ``balanced`` [N]. Motion: a node is displaced by more than ``far`` [m].

    ``outcome`` (3,) is filled with drift [m], speed [m/s] and time steps.
    """
    start, B, count = q.copy(), matrix(m), len(m.k)
    stiff, kind, quiet, step = m.ratio * m.k, NEITHER, 0, 0
    slid = np.ascontiguousarray(z.T)
    for step in range(1, most + 1):
        u, w = B[:count] @ q.ravel() + m.apart, (B @ v.ravel()).reshape(3, count)
        normal = -m.k * u - m.c * w[0]
        touching = (u < 0) & (normal > 0)
        slid = np.where(touching, slid + m.dt * w[1:], 0.0)
        along = -stiff * slid - m.c * w[1:]
        wanted, most_held = np.hypot(*along), m.mu * normal
        slides = touching & (wanted > most_held)
        along *= np.where(slides, most_held / np.where(slides, wanted, 1.0), 1.0)
        slid = np.where(slides, -along / stiff, slid)
        forces = np.where(touching, np.vstack([normal, along]), 0.0)
        F = wrench + (B.T @ forces.ravel()).reshape(-1, 6)
        worst = float((np.abs(F) * m.lever).max())
        F -= DAMPING * np.abs(F) * np.sign(v)
        v += m.dt * (m.inverse @ F[..., None])[..., 0]
        q += m.dt * v
        quiet = quiet + 1 if worst <= balanced else 0
        if quiet >= CHECK:
            kind = REST
            break
        if step % CHECK == 0 and apart(m, q, start) > far:
            kind = MOVES
            break
    z[:] = slid.T
    outcome[:] = apart(m, q, start), apart(m, v, np.zeros_like(v)), step
    return kind
