"""What is to become firmer: the least push on each body, or the least factor of a motion."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np

from holdfast.applications.carrying.carry import carry
from holdfast.applications.carrying.profile import Profile
from holdfast.assembly.assembly import FIXED, Assembly
from holdfast.assembly.on_surface import check_on_surface
from holdfast.base.arrays import Float, Int, Objects, objects
from holdfast.base.errors import SceneError, message
from holdfast.base.text import quoted
from holdfast.base.values import Table
from holdfast.engines.answers import Answers, Claim
from holdfast.engines.contract import Engine
from holdfast.queries.map import exposed_cells
from holdfast.queries.push import asked
from holdfast.queries.request import Load, checked_loads, pressed_by_pushes, push_columns

MOST_PUSHES = 150  # approximate number of pushes of a default map, on all bodies together


@dataclass(frozen=True, eq=False)
class Firmness:
    """How firm an assembly is: the ``least`` of each name, and the ``answers`` that this is from.

    It is promised, and 0 for the names in ``undecided``. The truth is at most about ``most``, the least force that is
    known.
    """

    least: Table[str, float]
    most: Table[str, float]
    undecided: tuple[str, ...]
    answers: Answers

    @classmethod
    def of(cls, answers: Answers, names: Objects) -> Firmness:
        """Return how firm the names (n,) of the rows are."""
        low, high = promised(answers), np.where(answers.decided, answers.force, np.inf)
        rows = {name: np.flatnonzero(names == name) for name in dict.fromkeys(names)}
        return cls(
            Table({name: float(low[own].min()) for name, own in rows.items()}),
            Table({name: float(high[own].min()) for name, own in rows.items()}),
            tuple(name for name, own in rows.items() if not answers.decided[own].all()),
            answers,
        )


def promised(answers: Answers) -> Float:
    """Return the bounds (n,) that answers promise from below; the forces of an engine that only estimates."""
    return answers.force if answers.claim is Claim.ESTIMATED else answers.lower


@dataclass(eq=False)
class Pushes:
    """Pushes that travel with their bodies: ``points`` and ``directions`` (n, 3) in the frame of each ``body`` (n,).

    The ``weakest`` in any answer so far are asked first: where these are no firmer, the others need not be asked.
    """

    engine: Engine
    body: Objects
    points: Float
    directions: Float
    asked: int = 0
    weakest: set[int] = field(default_factory=set)

    @classmethod
    def map_of(cls, assembly: Assembly, names: Sequence[str], engine: Engine) -> Pushes:
        """Return inward pushes all over the exposed surfaces of the bodies ``names``."""
        areas = np.array([assembly.scene.body(name).surface_world.area for name in names])
        bodies, points, normals = [], [np.zeros((0, 3))], [np.zeros((0, 3))]
        for name, most in zip(names, np.ceil(MOST_PUSHES * areas / areas.sum()).astype(int).tolist(), strict=True):
            cells = exposed_cells(assembly, name, float(np.sqrt(areas.sum() / MOST_PUSHES)))[0]
            every = max(len(cells.points) // most, 1)  # a round side has many facets, each with cells of its own
            points.append(cells.points[::every])
            normals.append(cells.normals[::every])
            bodies += [name] * len(points[-1])
        return cls._in_frames(assembly, engine, bodies, np.vstack(points), -np.vstack(normals))

    @classmethod
    def given(cls, assembly: Assembly, loads: Iterable[Load], engine: Engine) -> Pushes:
        """Return the pushes of ``loads``, each of which is asked on its own."""
        found = checked_loads(loads)
        for load in found:
            where = f"firmer: push on {quoted(load.body)}"
            if assembly.index.get(load.body, FIXED) == FIXED or np.any(load.moment) or not np.any(load.force):
                raise SceneError(message(where, "is no force on a movable body", "needs hf.Load(body, point, force)"))
            check_on_surface(assembly, load.body, np.array([load.point]), where)
        if not found:
            raise SceneError(message("firmer: pushes", "is empty", "give pushes, or None for all over the bodies"))
        forces = np.array([load.force for load in found])
        forces /= np.linalg.norm(forces, axis=1, keepdims=True)
        return cls._in_frames(
            assembly, engine, [load.body for load in found], np.array([load.point for load in found]), forces
        )

    @classmethod
    def _in_frames(
        cls, assembly: Assembly, engine: Engine, bodies: Sequence[str], points: Float, directions: Float
    ) -> Pushes:
        poses = np.array([assembly.scene.body(name).pose for name in bodies])
        points = np.einsum("nji,nj->ni", poses[:, :3, :3], points - poses[:, :3, 3])
        return cls(engine, objects(bodies), points, np.einsum("nji,nj->ni", poses[:, :3, :3], directions))

    def firmness(self, assembly: Assembly) -> Firmness:
        """Return the least push on each body [N]."""
        answers = self._answers(assembly, np.arange(len(self.body)))
        values = promised(answers)
        for name in self.names:
            own = np.flatnonzero(self.body == name)
            self.weakest.add(int(own[np.argmin(values[own])]))
        return Firmness.of(answers, self.body)

    def at_most(self, assembly: Assembly) -> Firmness:
        """Return what the assembly is at most as firm as, by the pushes that were the weakest anywhere."""
        rows = np.array(sorted(self.weakest))
        return Firmness.of(self._answers(assembly, rows), self.body[rows])

    @property
    def names(self) -> list[str]:
        """The names of the bodies that are pushed."""
        return list(dict.fromkeys(self.body))

    def _answers(self, assembly: Assembly, rows: Int) -> Answers:
        self.asked += len(rows)
        W, ways = np.zeros((6 * len(assembly.movable), len(rows))), np.zeros((len(rows), 3))
        for name in self.names:
            mine = np.flatnonzero(self.body[rows] == name)
            pose = assembly.scene.body(name).pose
            points = self.points[rows[mine]] @ pose[:3, :3].T + pose[:3, 3]
            ways[mine] = self.directions[rows[mine]] @ pose[:3, :3].T
            W[:, mine] = push_columns(assembly, assembly.index[name], points, ways[mine])
        pressed = np.zeros(len(assembly.bodies)), pressed_by_pushes(assembly, self.body[rows].tolist(), ways)
        return asked(self.engine, assembly, W, np.zeros(len(W)), bounds=False, pressed=pressed)


@dataclass(eq=False)
class CarrierMotion:
    """A motion of the carrier: how many times faster its accelerations may be."""

    engine: Engine
    profile: Profile
    asked: int = 0

    def firmness(self, assembly: Assembly) -> Firmness:
        """Return the least factor of the inertial loads over all times."""
        found = carry(assembly, self.profile, engine=self.engine).answers
        self.asked += len(found.force)
        return Firmness.of(found, objects(["motion"] * len(found)))

    def at_most(self, assembly: Assembly) -> None:
        """Return no bound: one answer covers many times."""
