"""A block on four springs, made by hand: what the tests of load paths share."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from path_events import Event

from holdfast.elastic.model import Elastic, Runs
from holdfast.elastic.system import QUICK, System, fronts_of
from holdfast.native import core

Array = NDArray[np.float64]

FLOOR = -1
HALF = 0.5  # of its width: the nodes are at the corners
HEIGHT = 1.0  # of its centre of mass


def block(mu: float) -> Elastic:
    """One body of unit weight, whose base is a sheet of four nodes on the floor; lengths in units of its width."""
    x, y = (HALF * np.array(signs, dtype=float) for signs in ((-1, 1, -1, 1), (-1, -1, 1, 1)))
    R = np.array([[0.0, 0, 1], [1, 0, 0], [0, 1, 0]])  # rows: normal, two tangents
    model = Elastic(
        first=np.array([0, 4]),
        x=x,
        y=y,
        k=np.full(4, 0.25),
        apart=np.zeros(4),
        mu=np.array([mu]),
        rho=1.0,
        a=np.array([FLOOR]),
        b=np.array([0]),
        axes=R[None],
        arm_a=np.zeros((1, 3)),
        arm_b=np.array([[0, 0, -HEIGHT]]),
        wrench=np.array([0.0, 0, -1, 0, 0, 0]),
        scale=np.ones(6),
        bonded=np.zeros((1, 6, 6)),
        unit=np.ones(6),
        runs=Runs.of(np.array([0, 4]), x, y, np.zeros(4)),
        hold=np.zeros(6),
        still=np.zeros(6),
    )
    core.bond(model, model.bonded, model.still)
    core.set_units(model, model.unit)
    return model


def twist_matrices(m: Elastic) -> tuple[Array, Array]:
    """T (P, 6, 6) of the bodies a and b of every sheet (frames.py), by their definition; zero for fixed ones."""
    found = []
    for ends, arm in ((m.a, m.arm_a), (m.b, m.arm_b)):
        T = np.zeros((len(ends), 6, 6))
        T[:, :3, :3] = T[:, 3:, 3:] = m.axes
        T[:, :3, 3:] = np.cross(arm[:, None], m.axes)  # R (ω x p) = (p x R) ω, row by row
        T[ends < 0] = 0.0
        found.append(T)
    return found[0], found[1]


def push(force: tuple[float, float, float], height: float = 0.0) -> Array:
    """A load (6,): ``force`` at ``height`` above the centre of mass."""
    return np.concatenate([force, np.cross((0, 0, height), force)]).astype(float)


class Walk:
    """A path of a block, step by step."""

    def __init__(self, mu: float, load: Array, start: Array | None = None) -> None:
        self.model = block(mu)
        self.fronts = fronts_of(self.model)
        self.work = core.Work(self.model, self.fronts)
        self.stepper = core.Stepper(np.zeros(6), QUICK)
        start = System.dense(self.model).come_to_rest().q if start is None else start
        self.event = Event(core.begin(self.model, self.work, self.stepper, start, load, self.fronts))

    def step(self) -> Event:
        self.event = Event(core.advance(self.model, self.work, self.stepper, self.fronts))
        return self.event

    def set_out(self) -> bool:
        return core.set_out(self.model, self.work, self.stepper, self.fronts)

    def cross(self) -> Event:
        return Event(core.cross_change(self.model, self.work, self.stepper, self.fronts))


def at(**known: float) -> core.Progress:
    now = core.Progress(QUICK)
    now.elastic, now.s, now.highest, now.slope, now.length, now.at_peak = 1.0, 1.0, 1.0, 0.5, 1.0, 1.0
    now.flat_since = now.similar_since = np.inf
    for name, value in known.items():
        setattr(now, name, value)
    return now
