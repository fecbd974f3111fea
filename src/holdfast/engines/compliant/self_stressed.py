"""Answers that depend on stiffness: lower bounds of self-stressed bodies cover other springs and other nodes.

Where contact forces can balance each other without any load, as on a wedge in a groove, what presses the contacts is
decided by how stiff they are and not by the weight alone. Then the ratio of tangential to normal stiffness, which is
seldom known, and the places of the nodes move the answer by far more than the discretisation error elsewhere.

How pressure spreads over a face is decided by stiffness, too, and rigid bodies that press each other touch at edges and
corners. Two nodes a side are all at corners. The same holds where the load itself presses what holds it, far above the
weight.

Bodies that are about to fall, as pipes in a free pile, hold by what their stiffness lends them, too.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import ClassVar

import numpy as np

from holdfast.assembly.assembly import body_forces
from holdfast.assembly.contact_nodes import contact_nodes
from holdfast.base.arrays import Float, Int
from holdfast.elastic.system import PathOutcome
from holdfast.engines.answers import Answers
from holdfast.engines.compliant.amendment import MATTERS, Amendment, LoadQuestion
from holdfast.engines.compliant.elastic_model import Springs
from holdfast.engines.compliant.grid import Grid
from holdfast.engines.compliant.load_bearing import HUGE
from holdfast.engines.compliant.rest_verdict import TAKEN_ALONG
from holdfast.engines.forces import clampable, self_stressed

RATIOS = (0.3, 3.0)  # times the engine's ratio of tangential to normal stiffness
# Nodes along a side of coarse grids, on which pressure is concentrated at edges. The pile of pipes of finding T3 holds
# 59 N on 7 nodes a side, 50 on 2, 37 on 5, and a simulation moves it at 43
COARSE = (2, 3, 5)
JAMMED = 3.0  # a load above this many times the weight beside it decides itself what presses the contacts that hold it
CORNERS = 4  # smallest number of nodes of a patch
# Share of the weight, along one of WAYS level directions, that bodies near their limit do not bear: 0.05 along any. The
# piles of pipes of finding S5 bear 0.0024, and a push that they hold is nearly twice as large on springs twice as stiff
# along the contacts, and nothing on springs half as stiff
LEVEL, WAYS = 0.05 / np.cos(np.pi / 4), 4


@dataclass(frozen=True, eq=False)
class SelfStressed(Amendment):
    """Lowers the bounds of answers that depend on stiffness: of bodies self-stressed, or near their limit."""

    name: ClassVar[str] = "stiffness"
    why: ClassVar[str] = (
        "bodies that press each other without any load, or are about to fall, hold by their stiffness: lower covers "
        "other stiffness"
    )

    @cached_property
    def possible(self) -> bool:
        """Whether contact forces can balance each other without any load; True where that is not settled.

        Bodies are peeled off by the directions of their contacts first, for which one node of every sheet will do.
        """
        assembly, places = self.grid.assembly, self.grid.places
        if places.given is None:
            begins = np.zeros(len(places.nodes), dtype=bool)
            begins[places.sheets.first[:-1]] = True
            if not clampable(places.nodes.chosen(begins)).any():
                return False
        return self_stressed(assembly, contact_nodes(assembly, CORNERS, "corners")) is not False

    @cached_property
    def near(self) -> frozenset[str]:
        """The bodies that move first where the group does not bear a small share of its weight along some level way.

        None where each has one plane contact with what bears it: there no force depends on stiffness.
        """
        grid, assembly = self.grid, self.grid.assembly
        gravity = float(np.linalg.norm(assembly.scene.gravity))
        if len(grid.places.sheets.a) <= len(assembly.movable) or not gravity:
            return frozenset()
        ways = LEVEL * gravity * assembly.scene.horizontal_directions(WAYS)
        W = np.column_stack([body_forces(assembly.mass[:, None] * way) for way in ways])
        paths = grid.paths(W, most=1.0)
        ends = ~np.isin(paths.outcome, (PathOutcome.REACHED, PathOutcome.ENDLESS))
        motion = np.abs(paths.motion[ends]).reshape(-1, len(assembly.movable), 6).max(axis=2)
        moved = (motion > TAKEN_ALONG * motion.max(axis=1, initial=0.0)[:, None]).any(axis=0)
        return frozenset(body.name for body, one in zip(assembly.movable, moved, strict=True) if one)

    @cached_property
    def by_stiffness(self) -> bool:
        """Whether some answers depend on stiffness, whatever the load."""
        return self.possible or bool(self.near)

    def amend(self, answers: Answers, question: LoadQuestion) -> Answers | None:
        """Return ``answers`` with lower bounds that also hold on other springs and nodes.

        A path that is lost on one of them counts as far as it was followed. An answer without an end keeps its status,
        but its lower bound is finite where others end within HUGE times the weight. Springs of imperfect faces are a
        sample already, and are left alone.
        """
        if not question.bounded or self.grid.springs.faces is not None:
            return None
        rows = np.flatnonzero((answers.force > 0) & question.W.any(axis=0))
        if not len(rows):
            return answers
        stiff = np.array([self.possible or not self.near.isdisjoint(answers.moving[k]) for k in rows], dtype=bool)
        why = "self-stressed" if self.possible else "near their limit"
        answers = self._covered(answers, question.W, rows[stiff], why, softer=True)
        # those whose load itself presses what holds it, far above the weight beside it
        near = rows[~stiff]
        loads = self.grid.loads(question.W[:, near])
        size = np.abs(loads).max(axis=1) * np.where(np.isfinite(answers.force[near]), answers.force[near], 0.0)
        heavy = np.flatnonzero(size > JAMMED * self.grid.lightest)
        jams = [k for k in heavy.tolist() if size[k] > JAMMED * self.grid.load_bearing.weight(loads[k])]
        return self._covered(answers, question.W, near[jams], "self-stressed", softer=False)

    def _covered(self, answers: Answers, W: Float, rows: Int, why: str, *, softer: bool) -> Answers:
        """Return ``answers`` with bounds of the ``rows`` (k,) on coarse grids, and with ``softer`` on other springs."""
        if not len(rows):
            return answers
        least = answers.force[rows]
        farthest = np.where(np.isinf(least), HUGE / np.abs(self.grid.loads(W[:, rows])).max(axis=1), np.inf)
        for other in (*self._coarse, *self._softer_and_stiffer) if softer else self._coarse:
            paths = other.paths(W[:, rows])
            least = np.minimum(least, np.where(paths.sure >= farthest, np.inf, paths.sure))
        with np.errstate(invalid="ignore"):  # what has no end here or there
            share = np.where(
                np.isinf(answers.force[rows]), 1.0, answers.lower[rows] / answers.force[rows]
            )  # less the error
        lower = np.array(answers.lower)
        lower[rows] = np.minimum(lower[rows], share * least)
        telling = int((least < (1 - MATTERS) * answers.force[rows]).sum())
        if not telling:
            return replace(answers, lower=lower)
        many = f"{telling} of {len(answers)} answers depend on stiffness"
        ratios = f" {RATIOS[0]:g} to {RATIOS[1]:g} times as stiff along their faces, and" if softer else ""
        covers = f"contacts{ratios} with {COARSE[0]} or more nodes a side"
        note = f"{many}, as bodies are {why}: lower is what holds for all {covers}"
        return replace(answers, lower=lower, notes=(*answers.notes, note))

    @cached_property
    def _coarse(self) -> tuple[Grid, ...]:
        """Grids with pressure on edges: they tell most where the load itself presses what holds it."""
        springs = self.grid.springs
        return tuple(self._on(replace(springs, nodes=nodes)) for nodes in COARSE if nodes < springs.nodes)

    @cached_property
    def _softer_and_stiffer(self) -> tuple[Grid, ...]:
        springs = self.grid.springs
        return tuple(self._on(replace(springs, ratio=factor * springs.ratio)) for factor in RATIOS)

    def _on(self, springs: Springs) -> Grid:
        return Grid.of(self.grid.assembly, self.grid.wrench, springs, hold=self.grid.hold)
