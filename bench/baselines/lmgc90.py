"""LMGC90 as a referee: non-smooth contact dynamics of rigid convex blocks (Dubois et al.).

Contacts are found by LMGC90 itself, between faces at the corners of the polygon they share: four on a rectangle. They
are rigid (law IQS_CLB), or springs of one ``stiffness`` (ELASTIC_REPELL_CLB). An engine that is compared with it should
use the same points.

Optional: ``pip install --no-deps compas_lmgc90``; only its compiled module is used, so its dependencies are not needed.
It allows one simulation at a time in a process and one friction coefficient, and ends the process on an error.
"""

from __future__ import annotations

import importlib
from dataclasses import dataclass
from typing import Any

import numpy as np

from bench.baselines.search import Peak, Trial, largest_load, push, trial_under
from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import Float
from holdfast.base.errors import HoldfastError, message
from holdfast.scene.body import Body

STEP = 1e-3  # [s]
THETA = 0.5  # parameter of the theta method of time integration
SETTLE = 0.1  # [s] time under the weight alone
RAMP = 0.1  # [s] time over which a load grows
HOLD = 0.2  # [s] shortest time under the full load
LONGEST = 1.0  # [s] longest time under the full load, if neither rest nor motion is seen earlier
ALERT = 1e-3  # [m] distance below which LMGC90 looks for contacts
FAR = 5e-4  # displacement under the load, in sizes of the assembly, above which a body counts as moving
SLOW = 1e-4  # speed at the end, in sizes of the assembly per second, below which bodies count as resting
GRAVITY = np.array([0.0, 0.0, -9.81])  # [m/s²] as LMGC90 has it


def holds(assembly: Assembly, load: Float | None = None) -> Trial:
    """Whether the assembly comes to rest under its weight, and then under ``load`` (6J,) [N, N m] as well.

    Contact points are rigid. Drifts are those of the centres of mass.
    """
    return trial_under(World(assembly), load)


def peak(
    assembly: Assembly,
    body: str,
    point: Float,
    direction: Float,
    *,
    stiffness: float | None = None,
    accuracy: float = 5e-3,
) -> Peak:
    """The largest push [N] at ``point`` [m] of ``body`` along ``direction`` that comes to rest, by bisection.

    Every load is tried from rest under the weight alone, to ``accuracy`` times the load.
    """
    return largest_load(World(assembly, stiffness), assembly.weight, push(assembly, body, point, direction), accuracy)


class World:
    """An assembly in LMGC90, which cannot restore a state: every trial begins with the weight alone."""

    def __init__(self, assembly: Assembly, stiffness: float | None = None) -> None:
        _check(assembly)
        self.assembly, self.stiffness = assembly, stiffness
        self.weighed = self.trial(np.zeros(6 * len(assembly.movable)))

    def trial(self, load: Float) -> Trial:
        """Simulate the weight and then ``load`` (6J,) [N, N m] on top, until rest or motion is seen."""
        return _run(self.assembly, load, self.stiffness).trial


def contact_points(assembly: Assembly) -> tuple[Float, list[tuple[str, str]]]:
    """The contacts that LMGC90 finds under the weight alone: points (I, 3) [m] and the two bodies of each."""
    _check(assembly)
    seen = _run(assembly, np.zeros(6 * len(assembly.movable)), None).state
    names = [body.name for body in assembly.bodies]
    pairs = [(names[a - 1], names[b - 1]) for a, b in seen.interaction_bodies]
    return np.array(seen.interaction_coords).reshape(-1, 3), pairs


@dataclass(frozen=True, eq=False)
class _Run:
    """The verdict of a simulation and LMGC90's last state."""

    trial: Trial
    state: Any


def _run(assembly: Assembly, load: Float, stiffness: float | None) -> _Run:
    """The weight alone for SETTLE, then ``load`` (6J,) on top."""
    solver = _lmgc90().LMGC90Solver()
    solver.initialize(STEP, THETA, False)
    (mu,) = set(assembly.mu)
    if stiffness is None:
        solver.add_one_tact_behav("iqsc0", "IQS_CLB", [mu])
    else:
        solver.add_one_tact_behav("iqsc0", "ELASTIC_REPELL_CLB", [float(stiffness), mu])
    densities = [_density(body) for body in assembly.bodies]
    known = sorted(set(densities))
    solver.set_materials(known)
    solver.set_see_tables(ALERT)
    solver.set_nb_bodies(len(densities))
    wrench = load.reshape(-1, 6)
    for k, body in enumerate(assembly.bodies):
        surface = body.surface_world
        centre = surface.vertices.mean(0)
        faces, vertices = (surface.faces + 1).ravel().tolist(), (surface.vertices - centre).ravel().tolist()
        driven = [] if body.fixed else np.flatnonzero(wrench[assembly.index[body.name]]).tolist()
        material = f"s{known.index(densities[k]) + 1:0>4}"
        solver.set_one_polyr(material, centre.tolist(), faces, vertices, 6 * body.fixed, len(driven))
        for dof in range(6 * body.fixed):
            solver.set_drvdof(k + 1, dof + 1, [0.0] * 6, True, False)
        for dof in driven:
            value = float(wrench[assembly.index[body.name], dof])
            times = [0.0, SETTLE, SETTLE + RAMP, 1e3]
            solver.set_drvdof(k + 1, dof + 1, [*times, 0.0, 0.0, value, value], False, True)
    solver.close_before_computing()
    solver.get_initial_state()
    try:
        return _watched(assembly, solver)
    finally:
        solver.finalize()


def _watched(assembly: Assembly, solver: Any) -> _Run:  # noqa: ANN401 - LMGC90 has no types
    """Simulate until rest or motion is seen."""
    size = assembly.size
    settled, enough, most = (round(t / STEP) for t in (SETTLE, SETTLE + RAMP + HOLD, SETTLE + RAMP + LONGEST))
    before = last = np.zeros((len(assembly.bodies), 3))
    drift = speed = 0.0
    state: Any = None
    for step in range(1, most + 1):
        state = solver.compute_one_step()
        places = np.array(state.bodies)
        if step == 1:
            before = places
        drift = float(np.linalg.norm(places - before, axis=1).max())
        speed = float(np.linalg.norm(places - last, axis=1).max()) / STEP
        last = places
        if drift > FAR * size or not np.isfinite(drift):
            return _Run(Trial(False, drift, speed, step), state)
        if step == settled:
            before = places
        if step >= enough and speed < SLOW * size:
            return _Run(Trial(True, drift, speed, step), state)
    return _Run(Trial(None, drift, speed, most), state)


def _density(body: Body) -> float:
    """[kg/m³], uniform; fixed bodies may have any."""
    return 1000.0 if body.fixed or body.mass is None else body.mass / body.shape.mass_properties.volume


def _check(assembly: Assembly) -> None:
    """Refuse an assembly that LMGC90 cannot represent as it is."""
    if len(set(assembly.mu)) != 1:
        problem = f"the contacts have friction {sorted(set(assembly.mu))}"
        raise HoldfastError(message("referee LMGC90", problem, "takes one coefficient for all"))
    if not np.allclose(assembly.scene.gravity, GRAVITY):
        problem = f"gravity is {assembly.scene.gravity.tolist()}"
        raise HoldfastError(message("referee LMGC90", problem, f"needs {GRAVITY.tolist()}"))
    for body in assembly.movable:
        if np.abs(body.com_body - body.shape.mass_properties.com).max() > 1e-6 * body.size:
            problem = "the centre of mass is not that of the shape"
            raise HoldfastError(message(f"referee LMGC90: body {body.name!r}", problem, "needs uniform density"))


def _lmgc90() -> Any:  # noqa: ANN401 - LMGC90 has no types
    try:
        return importlib.import_module("compas_lmgc90._lmgc90")
    except ImportError:
        remedy = "pip install --no-deps compas_lmgc90"
        raise HoldfastError(message("referee LMGC90", "is not installed", remedy)) from None
