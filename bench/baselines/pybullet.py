"""PyBullet, the simulator of Nadeau & Kelly: their Algorithm 2 as printed, and loads that are held for half a second.

As printed (``printed``): a force is applied, one time step simulated, and the assembly is called moving where its
kinetic energy exceeds 1e-4 J; 100 bisections of 0 to 100 N; "the full Coulomb friction cone and no force restitution".
What the paper leaves open, and what is chosen here:

- Time step: 1/240 s, PyBullet's own. The answer depends on it: a body of mass m that slides only gains 1e-4 J in one
  step dt from an excess force sqrt(2e-4 J m) / dt on, 3.4 N for 1 kg.
- Start of every trial: the state reached after 1 s under the weight alone, contact impulses included, restored for each
  force. From the poses as given the first step ends in free fall (8e-4 J for 1 kg): nothing would ever hold.
- Kinetic energy: of all movable bodies, linear and rotational, at the end of the step.
- Solver: PyBullet's own (sequential impulses, 50 iterations, contact ERP 0.2); no damping, no sleeping.
- Shapes: boxes and spheres are PyBullet's own, all else convex hulls without margin.
- Friction: PyBullet multiplies the coefficients of both bodies; they are set so that every pair has its own.
- The answer is infinite where no force up to the end of the range moves anything, unstable where every force does.

Held (``holds``, ``peak``): the full load is applied at once and stays on for 0.5 s; it holds if no point drifts farther
than FAR in the second half. Steps are shorter and the solver may iterate more (STEP, ITERATIONS). PyBullet keeps about
four contact points a face, so its answers should be compared with those of ``compliant`` on corners.

Optional: the extra ``bench``; there are wheels for Python 3.11 alone.
"""

from __future__ import annotations

import importlib
import weakref
from types import ModuleType
from typing import Any

import numpy as np
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from bench.baselines.search import Peak, Trial, largest_load, push, trial_under
from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import Float
from holdfast.base.errors import HoldfastError, message
from holdfast.scene.body import Body
from holdfast.scene.shapes import Box, Sphere

PRINTED_STEP = 1 / 240  # [s]
PRINTED_ITERATIONS = 50  # iterations of the contact solver
PRINTED_BISECTIONS = 100
PRINTED_RANGE = 100.0  # [N] largest force of the search
PRINTED_ENERGY = 1e-4  # [J] kinetic energy above which the assembly counts as moving
STEP = 1e-3  # [s]
ITERATIONS = 200  # iterations of the contact solver
SETTLE = 1.0  # [s] time under the weight alone
HOLD = 0.5  # [s] time under a load
FAR = 2e-3  # drift in the second half of HOLD, in sizes of the assembly, above which points count as moving
CONVEX = 1e-6  # protrusion beyond the plane of a face, in sizes of a body, that a convex shape may have
SMOOTH = 1e-9  # friction coefficient used for 0, which has no logarithm


def printed(assembly: Assembly, body: str, point: Float, direction: Float) -> Peak:
    """Algorithm 2 as printed: a push [N] at ``point`` (3,) [m] of ``body`` along ``direction`` (3,), world axes."""
    column = push(assembly, body, point, direction)
    return World(assembly, PRINTED_STEP, PRINTED_ITERATIONS).printed(column)


def holds(assembly: Assembly, load: Float | None = None) -> Trial:
    """Whether the assembly rests under its weight, and then under ``load`` (6J,) [N, N m] as well for HOLD."""
    return trial_under(World(assembly), load)


def peak(assembly: Assembly, body: str, point: Float, direction: Float, *, accuracy: float = 5e-3) -> Peak:
    """The largest push [N] at ``point`` [m] of ``body`` along ``direction`` that is held, by bisection.

    Every load is tried from rest under the weight alone, to ``accuracy`` times the load.
    """
    column = push(assembly, body, point, direction)
    return largest_load(World(assembly), assembly.weight, column, accuracy)


class World:
    """An assembly in PyBullet after SETTLE under its weight; ``weighed`` is the trial under the weight alone."""

    def __init__(self, assembly: Assembly, step: float = STEP, iterations: int = ITERATIONS) -> None:
        self.assembly, self.step = assembly, step
        self.bullet = _pybullet()
        self.client: int = self.bullet.connect(self.bullet.DIRECT)
        weakref.finalize(self, self.bullet.disconnect, self.client)
        self.bullet.setPhysicsEngineParameter(
            fixedTimeStep=step,
            numSolverIterations=iterations,
            enableConeFriction=1,
            deterministicOverlappingPairs=1,
            physicsClientId=self.client,
        )
        self.bullet.setGravity(*assembly.scene.gravity, physicsClientId=self.client)
        factors = _friction(assembly)
        self.numbers: list[int] = []
        self.principal: list[Float] = []
        for body in assembly.bodies:
            number = self._add(body, factors[body.name])
            if not body.fixed:
                self.numbers.append(number)
        self.start: int | None = None
        self.weighed = self.trial(np.zeros(6 * len(self.numbers)), SETTLE)
        self.start = self.bullet.saveState(physicsClientId=self.client)

    def trial(self, load: Float, duration: float = HOLD) -> Trial:
        """Apply ``load`` (6J,) [N, N m] at once and measure the drift in the second half of ``duration`` [s]."""
        self._restore()
        half = round(duration / 2 / self.step)
        self._run(load, half)
        before = self._places()
        self._run(load, half)
        drift = float(np.linalg.norm(self._places() - before, axis=1).max(initial=0.0))
        rests = bool(drift <= FAR * self.assembly.size)  # False where a drift is no number
        return Trial(rests, drift, drift / (half * self.step), 2 * half)

    def printed(self, column: Float) -> Peak:
        """Bisect the multiple of a unit push (6J,) as Algorithm 2 does; the last bracket [N]."""
        low, high, moved = 0.0, PRINTED_RANGE, False
        for _ in range(PRINTED_BISECTIONS):
            force = (low + high) / 2
            self._restore()
            self._run(force * column, 1)
            if self.energy() > PRINTED_ENERGY:
                high, moved = force, True
            else:
                low = force
        moves = np.inf if not moved else high if low > 0 else 0.0
        return Peak(low, moves, 0.0, 0.0, 0, PRINTED_BISECTIONS)

    def energy(self) -> float:
        """Kinetic energy of all movable bodies [J]."""
        total = 0.0
        for k, number in enumerate(self.numbers):
            velocity, spin = self.bullet.getBaseVelocity(number, physicsClientId=self.client)
            _, turn = self._pose(number)
            local = turn.T @ np.array(spin)
            total += 0.5 * float(self.assembly.mass[k] * np.dot(velocity, velocity) + self.principal[k] @ local**2)
        return total

    def _restore(self) -> None:
        if self.start is not None:
            self.bullet.restoreState(self.start, physicsClientId=self.client)

    def _run(self, load: Float, steps: int) -> None:
        """Simulate ``steps`` time steps under ``load`` (6J,), whose forces keep their direction while bodies move."""
        frame, client = self.bullet.WORLD_FRAME, self.client
        wrench = load.reshape(-1, 6).tolist()
        pushed = [(number, w[:3], w[3:]) for number, w in zip(self.numbers, wrench, strict=True) if any(w)]
        for _ in range(steps):
            for number, force, torque in pushed:
                centre, _ = self.bullet.getBasePositionAndOrientation(number, physicsClientId=client)
                self.bullet.applyExternalForce(number, -1, force, centre, frame, physicsClientId=client)
                self.bullet.applyExternalTorque(number, -1, torque, frame, physicsClientId=client)
            self.bullet.stepSimulation(physicsClientId=client)

    def _pose(self, number: int) -> tuple[Float, Float]:
        """Centre of mass (3,) and axes (3, 3) of a body."""
        centre, quaternion = self.bullet.getBasePositionAndOrientation(number, physicsClientId=self.client)
        turn = np.array(self.bullet.getMatrixFromQuaternion(quaternion)).reshape(3, 3)
        return np.array(centre), turn

    def _places(self) -> Float:
        """Positions (6J, 3) [m] of six points of every movable body, half its size from its centre along its axes."""
        places = []
        for body, number in zip(self.assembly.movable, self.numbers, strict=True):
            centre, turn = self._pose(number)
            places.append(centre + body.size / 2 * np.vstack([turn.T, -turn.T]))
        return np.vstack(places) if places else np.empty((0, 3))

    def _add(self, body: Body, friction: float) -> int:
        """Add a body whose frame lies at its centre of mass along its principal axes, as PyBullet stores inertia."""
        moments, axes = np.linalg.eigh(body.inertia_com) if not body.fixed else (np.zeros(3), np.eye(3))
        axes = axes * np.sign(np.linalg.det(axes))
        turn = body.pose[:3, :3] @ axes
        mass = 0.0 if body.mass is None or body.fixed else body.mass
        centre = body.com_world
        shape = self._shape(body, centre, turn)
        number: int = self.bullet.createMultiBody(
            mass, shape, basePosition=centre.tolist(), baseOrientation=_quaternion(turn), physicsClientId=self.client
        )
        self.bullet.changeDynamics(
            number,
            -1,
            lateralFriction=friction,
            restitution=0.0,
            spinningFriction=0.0,
            rollingFriction=0.0,
            linearDamping=0.0,
            angularDamping=0.0,
            collisionMargin=0.0,
            activationState=self.bullet.ACTIVATION_STATE_DISABLE_SLEEPING,
            physicsClientId=self.client,
        )
        if not body.fixed:
            self.bullet.changeDynamics(number, -1, localInertiaDiagonal=moments.tolist(), physicsClientId=self.client)
            self.principal.append(moments)
        return number

    def _shape(self, body: Body, centre: Float, turn: Float) -> int:
        """The collision shape, placed relative to ``centre`` (3,) and axes ``turn`` (3, 3)."""
        bullet, client = self.bullet, self.client
        placed: dict[str, Any] = {
            "collisionFramePosition": (turn.T @ (body.pose[:3, 3] - centre)).tolist(),
            "collisionFrameOrientation": _quaternion(turn.T @ body.pose[:3, :3]),
            "physicsClientId": client,
        }
        if isinstance(body.shape, Box):
            half = (body.shape.size / 2).tolist()
            return int(bullet.createCollisionShape(bullet.GEOM_BOX, halfExtents=half, **placed))
        if isinstance(body.shape, Sphere):
            return int(bullet.createCollisionShape(bullet.GEOM_SPHERE, radius=body.shape.radius, **placed))
        surface = body.shape.surface
        corners = surface.vertices[ConvexHull(surface.vertices).vertices]
        beyond = (corners - surface.vertices[surface.faces[:, :1]]) @ surface.normals[:, :, None]
        if beyond.max() > CONVEX * body.size:
            raise HoldfastError(message(f"pybullet: body {body.name!r}", "is not convex", "needs convex bodies"))
        return int(bullet.createCollisionShape(bullet.GEOM_MESH, vertices=corners.tolist(), **placed))


def _friction(assembly: Assembly) -> dict[str, float]:
    """A coefficient for every body such that the product over each touching pair is that pair's coefficient.

    The logarithms solve a linear system; HoldfastError where it has no solution.
    """
    names = [body.name for body in assembly.bodies]
    number = {name: k for k, name in enumerate(names)}
    rows = np.zeros((len(assembly.interfaces), len(names)))
    for i, interface in enumerate(assembly.interfaces):
        rows[i, [number[name] for name in interface.bodies]] = 1.0
    wanted = np.log(np.maximum(np.array(assembly.mu), SMOOTH))
    factors = np.linalg.lstsq(rows, wanted, rcond=None)[0] if len(rows) else np.zeros(len(names))
    if len(rows) and np.abs(rows @ factors - wanted).max() > 1e-9:
        problem = f"no coefficients of single bodies give those of the pairs, {sorted(set(assembly.mu))}"
        raise HoldfastError(message("pybullet", problem, "takes friction that is a product over both bodies"))
    return dict(zip(names, np.exp(factors).tolist(), strict=True))


def _quaternion(turn: Float) -> list[float]:
    """(x, y, z, w) of a rotation (3, 3)."""
    return [float(x) for x in Rotation.from_matrix(turn).as_quat()]


def _pybullet() -> ModuleType:
    try:
        return importlib.import_module("pybullet")
    except ImportError:
        remedy = "pip install -e '.[bench]' (Python 3.11: there are no wheels for later ones)"
        raise HoldfastError(message("pybullet", "PyBullet is not installed", remedy)) from None
