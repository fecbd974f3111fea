"""Poses of a single body that are decided for all at once: in the air, deep in others, and flush with a flat face."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from holdfast.base.arrays import Bool, Int
from holdfast.engines.verdict import Status
from holdfast.queries.poses.decisions import Decided, Groups, Locals, overlapping
from holdfast.queries.poses.neighbourhoods import Piece
from holdfast.queries.poses.on_faces import OnFaces
from holdfast.queries.poses.outlines import shared_ball
from holdfast.scene.body import Body

SURE = 2.0  # [gaps] radius of a ball that two bodies share, which proves an overlap of 4/3 gaps between convex bodies


@dataclass(frozen=True, eq=False)
class PlainCases:
    """The verdicts that follow from where the bodies are, without a search for contacts."""

    local: Locals
    _on_faces: dict[str, OnFaces] = field(default_factory=dict, init=False, repr=False)

    def at_once(self, piece: Piece, rows: Int) -> Iterator[tuple[Int, Groups]]:
        """Yield rows at which a piece has the same verdicts; all other ``rows`` have to be decided one by one."""
        joins = self.local.around.assembly.scene.friction.joins  # faces may hold what hangs
        if len(piece.moved) > 1 or self.local.around.rest is None or joins:
            return
        (name,) = piece.moved
        if not piece.beside:
            yield rows, (Decided((name,), Status.UNSTABLE, _in_the_air(name), (name,)),)
        rest = tuple(group for group in self.local.rest if not piece.others.isdisjoint(group.names))
        if not piece.beside or any(group.status is not Status.STABLE for group in rest):
            return
        deep, meets = self._deep(piece, rows), self._meets(piece, rows)
        left = np.ones(len(rows), dtype=bool)
        for pattern in np.unique(np.hstack([deep, meets]), axis=0):
            into, touched = (_named(piece, part) for part in np.split(pattern, 2))
            movable = {other for other in touched if not self.local.around.assembly.scene.body(other).fixed}
            # whatever falls would move the overlapping bodies against each other, which nobody knows to happen
            if into and movable <= into:
                at = (deep == pattern[: deep.shape[1]]).all(1) & (meets == pattern[deep.shape[1] :]).all(1)
                left &= ~at
                yield rows[at], overlapping(name, self._texts(name, into), rest)
        if name not in self._on_faces:
            self._on_faces[name] = OnFaces(self.local, name)
        yield from self._on_faces[name].at_once(piece, rows[left], rest)

    def _meets(self, piece: Piece, rows: Int) -> Bool:
        """Tell which of the bodies beside a piece, in alphabetical order, may touch its body (n, m)."""
        around, (name,) = self.local.around, piece.moved
        meets = around.meets[rows, around.given.names.index(name)]
        its = np.array([[other == beside for other, _ in around.parts] for beside in sorted(piece.beside)])
        return np.asarray((meets[:, None] & its).any(2))

    def _deep(self, piece: Piece, rows: Int) -> Bool:
        """Tell which of the bodies beside a piece, in alphabetical order, surely overlap its body (n, m)."""
        around, (name,) = self.local.around, piece.moved
        scene = around.assembly.scene
        body, own = scene.body(name), around.outlines[name]
        apart = around.apart[rows, around.given.names.index(name)]
        deep = np.zeros((len(rows), len(piece.beside)), dtype=bool)
        for number, beside in enumerate(sorted(piece.beside)):
            other, its = scene.body(beside), around.outlines[beside]
            if len(own) > 1 or len(its) > 1 or scene.touching(body, other) != [(body, other)]:
                continue
            sure = self._sure(body, other)
            part = next(k for k, (each, _) in enumerate(around.parts) if each == beside)
            at = np.flatnonzero(apart[:, part] <= -2 * sure)  # along any direction they share twice the ball's radius
            poses = around.given.of(name)[rows[at]]
            deep[at, number] = shared_ball(own[0], poses, its[0], np.broadcast_to(other.pose, poses.shape)) > sure
        return deep

    def _sure(self, a: Body, b: Body) -> float:
        """Return the radius [m] of a ball in two convex bodies, beyond which they overlap and do not touch as well.

        A convex part of volume V and area A with a ball of radius r inside has V >= r A / 3, and an overlap counts as
        2 V / A deep at least. If the two touched within their gap somewhere, a plane there would have both on different
        sides, but for the gap and the angle that is allowed between their faces.
        """
        own = self.local.around.assembly.tolerances.between(a, b)
        if a.fixed or b.fixed:  # where else they touch makes no difference
            return SURE * own.gap
        return SURE * own.gap + float(np.sin(np.radians(own.angle))) * min(o.shape.surface.diagonal for o in (a, b))

    def _texts(self, name: str, into: frozenset[str]) -> dict[tuple[str, str], str]:
        """Say of each pair of a body and one of the bodies ``into`` that they overlap."""
        around, found = self.local.around, {}
        for other in sorted(into, key=around.order):
            first, second = sorted((name, other), key=around.order)
            allowed = f"{1e3 * around.gap(name, other):.2g} mm"
            found[first, second] = (
                f"{first} and {second} overlap by more than their tolerance of {allowed}, so what they carry there is "
                "not known: settle, or correct the poses"
            )
        return found


def _named(piece: Piece, which: Bool) -> frozenset[str]:
    """Return the bodies beside a piece that ``which`` (m,) tells, in alphabetical order."""
    return frozenset(name for name, one in zip(sorted(piece.beside), which, strict=True) if one)


def _in_the_air(name: str) -> str:
    return f"unsupported: {name}: no chain of contacts leads to a fixed body; nothing is within reach of it"
