"""Mechanisms: how bodies begin to move, as twists and, on demand, in words."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from typing import Literal, NamedTuple

import numpy as np

from holdfast.assembly.assembly import Assembly
from holdfast.assembly.contact_nodes import NO_NODES, ContactNodes, joined_nodes, reordered_nodes
from holdfast.base.arrays import Bool, Float, Int, frozen
from holdfast.base.errors import HoldfastError, message
from holdfast.base.public import Record, column
from holdfast.base.rigid import cross, shift_twist
from holdfast.base.text import listed

SLIGHT = 1e-3  # speed, relative to the fastest body, below which one of elastic bodies yields and does not move
AT_REST = 1e-6  # speed, relative to the largest, below which something counts as at rest
MOST_BODIES = 1_000_000  # of an assembly that is read from a file
FARTHEST = 1e10  # of all coordinates [m] and coefficients that are read from a file
CLOSED = 0.02  # opening, relative to a node's own speed, up to which it stays closed
SHARE = 0.05  # of sliding and opening together, by the fastest node of each, below which one of them does not count
STILL = 1e-4  # speed at contacts, relative to that of the bodies, below which nothing slides or opens
NAMED = 8  # the most body names in one part of a sentence

Mode = Literal["slip", "topple", "mixed", "roll", "crush", "none"]


class Kinematics(Record):
    """The bodies and contact nodes that are needed to put a motion into words. All mechanisms of one state share them.

    ``names`` are those of the K movable bodies that were considered, the bodies of one group of the assembly or of all
    groups. ``com`` (K, 3) [m] are their centres of mass in the world frame, ``numbers`` (K,) their numbers among the
    ``count`` movable bodies of the assembly, and ``size`` [m] is the diagonal of their bounding box. ``pairs`` gives
    the names of the two bodies of every interface, and ``nodes`` are the contact nodes on these interfaces.
    """

    names: tuple[str, ...] = column("K")
    com: Float = column("K 3")
    numbers: Int = column("K")
    count: int
    size: float
    pairs: tuple[tuple[str, str], ...]
    nodes: ContactNodes

    def checked_after_load(self) -> None:
        """Raise HoldfastError if a number that was read from a file is that of no body, contact or place."""
        ends, order = np.concatenate([self.nodes.a, self.nodes.b, [-1]]), np.append(0, self.nodes.interface)
        known: bool = len(self.names) <= self.count <= MOST_BODIES and ends.min() >= -1 and ends.max() < len(self.names)
        known = known and bool(((self.numbers >= 0) & (self.numbers < self.count)).all())
        if not (known and (np.diff(order) >= 0).all() and order[-1] < max(len(self.pairs), 1)):
            remedy = "needs the numbers of its own bodies and contacts"
            raise HoldfastError(message("kinematics", "has a number of something that is not there", remedy))
        places = (self.com, self.nodes.points, self.nodes.axes, self.nodes.mu, np.array(self.size))
        if max(float(np.abs(array).max(initial=0)) for array in places) > FARTHEST:
            raise HoldfastError(message("kinematics", "has a place beyond all", f"needs at most {FARTHEST:g}"))

    @classmethod
    def of(cls, assembly: Assembly, nodes: ContactNodes) -> Kinematics:
        """Return the kinematics of an assembly with these contact nodes."""
        return cls(
            names=tuple(body.name for body in assembly.movable),
            com=assembly.com,
            numbers=np.arange(len(assembly.movable)),
            count=len(assembly.movable),
            size=assembly.size,
            pairs=tuple(interface.bodies for interface in assembly.interfaces),
            nodes=nodes.contacts,
        )

    @classmethod
    def joined(cls, parts: Sequence[Kinematics]) -> Kinematics:
        """Return the kinematics of groups of one assembly that move independently; the size is the largest."""
        return cls(
            names=tuple(name for part in parts for name in part.names),
            com=np.vstack([part.com for part in parts]),
            numbers=np.concatenate([part.numbers for part in parts]),
            count=parts[0].count,
            size=max(part.size for part in parts),
            pairs=tuple(pair for part in parts for pair in part.pairs),
            nodes=joined_nodes(
                [part.nodes for part in parts],
                [len(part.pairs) for part in parts],
                [len(part.names) for part in parts],
            ),
        )

    def within(self, numbers: Int, count: int, interfaces: Int, pairs: Sequence[tuple[str, str]]) -> Kinematics:
        """Return the kinematics of the same bodies as part of a larger assembly of ``count`` movable bodies.

        There the bodies have the ``numbers`` (K,) and the interfaces the numbers ``interfaces`` (I,), with the names of
        the ``pairs``. Bodies and interfaces are put in the order of these numbers.
        """
        order, sheets = np.argsort(numbers), np.argsort(interfaces)
        return Kinematics(
            names=tuple(self.names[k] for k in order.tolist()),
            com=self.com[order],
            numbers=numbers[order],
            count=count,
            size=self.size,
            pairs=tuple(pairs[k] for k in sheets.tolist()),
            nodes=reordered_nodes(self.nodes, np.argsort(order), np.argsort(sheets)),
        )


class Mechanism(Record, kw_only=True):
    """The motion with which bodies begin to move.

    ``twists`` (J, 6) are the twists of all movable bodies about their centres of mass, along the world axes; bodies of
    other groups are at rest. They are scaled so that the fastest body has |velocity| + size |angular velocity| = 1,
    with the size of the group. ``moving`` gives the names of the bodies that move. ``mode`` says whether contacts
    slide, open, both or neither (``modes_of``). If ``dual`` is True, this is a dual motion like those of engine
    ``limit``: a contact that slides by |u_t| also opens by μ |u_t|. ``text`` describes the motion of each group of
    bodies and names the contacts that slide, open or roll. ``own`` (K, 6) are the twists of the bodies of the
    ``kinematics`` alone.

    Where ``mode`` is "crush", nothing moves: ``moving`` names the body that bears as much as it may, and there are no
    twists.
    """

    moving: tuple[str, ...]
    own: Float = column("K 6")
    mode: Mode
    dual: bool
    kinematics: Kinematics

    plain = "moving twists mode text"

    def __post_init__(self) -> None:
        self.own.setflags(write=False)  # the only array that is not sealed yet: maps make thousands of mechanisms

    def checked_after_load(self) -> None:
        """Raise HoldfastError if a body that was read from a file moves, but is not considered, or rests."""
        names = self.kinematics.names
        if len(self.own) != len(names) or not np.isfinite(self.own).all():
            problem = f"has {len(self.own)} twists for {len(names)} bodies, or infinite ones"
            raise HoldfastError(message("mechanism", problem, "needs a twist for each body"))
        still = {*self.moving} - {name for name, twist in zip(names, self.own, strict=True) if twist.any()}
        if still and self.mode != "crush":
            problem = f"{listed(sorted(still), NAMED)} moves without a twist"
            raise HoldfastError(message("mechanism", problem, "needs one for each body that moves"))

    def within(self, kinematics: Kinematics) -> Mechanism:
        """Return the mechanism with the ``kinematics`` of the same bodies in a larger assembly (Kinematics.within)."""
        place = {name: k for k, name in enumerate(self.kinematics.names)}
        order = [place[name] for name in kinematics.names]
        moves = set(self.moving)
        moving = tuple(name for name in kinematics.names if name in moves)
        return replace(self, moving=moving, own=self.own[order], kinematics=kinematics)

    @cached_property
    def twists(self) -> Float:
        """The twists (J, 6) of all movable bodies; composed on demand, since most bodies of large scenes rest."""
        every = np.zeros((self.kinematics.count, 6))
        every[self.kinematics.numbers] = self.own
        return frozen(every)

    def velocities(self) -> Float:
        """Return the velocities (I, 3) of body b relative to body a at the contact nodes, along their axes."""
        return relative_velocity(self.kinematics.nodes, self.kinematics.com, self.own)

    @cached_property
    def text(self) -> str:
        """The motion in words, composed on demand: maps hold thousands of mechanisms that nobody reads."""
        if self.mode == "crush":
            return f"{listed(self.moving, NAMED)} bears as much as it may"
        return "; ".join(_groups(self) + _contacts(self))


def crush_of(body: str, count: int) -> Mechanism:
    """Return the mechanism of a ``body`` that is crushed, in an assembly of ``count`` movable bodies."""
    nobody = Kinematics((), np.zeros((0, 3)), np.zeros(0, dtype=np.int64), count, 0.0, (), NO_NODES)
    return Mechanism(moving=(body,), own=np.zeros((0, 6)), mode="crush", dual=False, kinematics=nobody)


def relative_velocity(nodes: ContactNodes, com: Float, twists: Float) -> Float:
    """Return the velocity (..., I, 3) of body b relative to body a at every contact, along (normal, t1, t2): u = Gᵀ q.

    ``com`` (J, 3) [m] are the centres of mass, about which ``twists`` (..., J, 6) are taken, all in the world frame.
    """
    nodes = nodes.contacts
    velocity = np.zeros((*twists.shape[:-2], len(nodes), 3))
    for body, sign in ((nodes.b, 1.0), (nodes.a, -1.0)):
        free = np.flatnonzero(body >= 0)
        twist, arm = twists[..., body[free], :], nodes.points[free] - com[body[free]]
        velocity[..., free, :] += sign * (twist[..., :3] + cross(twist[..., 3:], arm))
    return np.asarray(np.einsum("ikx,...ix->...ik", nodes.axes, velocity))


def about_origin(assembly: Assembly, twists: Float, pair: tuple[str, str]) -> tuple[Float, Float]:
    """Return the twists (6,) about the world's origin of a pair of bodies in a motion ``twists`` (J, 6)."""
    first, second = (
        np.zeros(6) if k < 0 else shift_twist(twists[k], assembly.com[k], np.zeros(3))
        for k in (assembly.index[name] for name in pair)
    )
    return first, second


def moving_bodies(motion: Float, scale: Float) -> Bool:
    """Tell which bodies (..., J) move noticeably in motions (..., 6J), with components in units of ``scale`` (6J,)."""
    speeds = np.abs(motion / scale).reshape(*motion.shape[:-1], -1, 6).max(axis=-1)
    return np.asarray(speeds > AT_REST * speeds.max(axis=-1, keepdims=True, initial=0.0))


class Parting(NamedTuple):
    """How fast each contact node slides while it stays closed, and how fast it opens, (..., I) each; one of them is 0.

    A node that opens does no work. One that stays closed carries what is carried at that moment, so its sliding is what
    friction works against.
    """

    sliding: Float
    opening: Float

    @property
    def least(self) -> Float:
        """(...) the speed below which a contact counts neither as sliding nor as opening: a SHARE of both together."""
        return np.asarray(SHARE * (self.sliding.max(-1, initial=0.0) + self.opening.max(-1, initial=0.0)))


def parting(nodes: ContactNodes, velocities: Float, *, dual: bool) -> Parting:
    """Return how nodes part in motions with these relative velocities (..., I, 3).

    In a ``dual`` motion, a contact that slides also opens by u_n = μ |u_t|, and rises by at least as much everywhere,
    since it is rigid. There a node counts as opening only if it opens faster than the fastest sliding on its interface
    lifts it.
    """
    normal, tangential = velocities[..., 0], np.sqrt((velocities[..., 1:] ** 2).sum(-1))
    speed = np.sqrt(normal**2 + tangential**2)
    lifted = np.zeros_like(normal)
    if dual and len(nodes):
        touches = normal <= nodes.mu * tangential + CLOSED * speed
        _, first, back = np.unique(nodes.interface, return_index=True, return_inverse=True)
        fastest = np.maximum.reduceat(np.where(touches, tangential, 0.0), first, axis=-1)
        lifted = nodes.mu * np.maximum(fastest[..., back], tangential)
    opening = normal - lifted
    closed = opening <= CLOSED * speed
    return Parting(np.where(closed, tangential, 0.0), np.where(closed, 0.0, opening))


def modes_of(assembly: Assembly, nodes: ContactNodes, twists: Float, velocities: Float, *, dual: bool) -> list[Mode]:
    """Say what contacts do in each of k motions ``twists`` (k, 6J), with relative velocities (k, I, 3) at the nodes.

    Contacts slide, open, or both, as far as each is more than a SHARE of the two. Where they do neither although bodies
    move, a body with a round side rolls, and any other turns about its edge or corner. ``dual`` is as in ``parting``.
    """
    speeds = parting(nodes, velocities, dual=dual)
    slides, opens = speeds.sliding.max(1, initial=0.0), speeds.opening.max(1, initial=0.0)
    names: dict[tuple[bool, bool], Mode] = {(False, True): "topple", (True, False): "slip", (True, True): "mixed"}
    modes: list[Mode] = []
    rows = twists.reshape(len(twists), len(assembly.movable), 6)
    for each, slide, open_, least in zip(rows, slides, opens, speeds.least, strict=True):
        fastest = _speeds(each, assembly.size)
        top = float(fastest.max(initial=0.0))
        if slide + open_ > STILL * top:
            modes.append(names[bool(slide > least), bool(open_ > least)])
            continue
        moving = [body for body, fast in zip(assembly.movable, fastest, strict=True) if fast > AT_REST * top]
        if not moving or not velocities.shape[1]:
            modes.append("none")
        else:
            modes.append("roll" if any(body.surface_world.curved.any() for body in moving) else "topple")
    return modes


def without_slight(twists: Float, size: float) -> Float:
    """Return motions ``twists`` (k, 6J) without the bodies that only yield: those slower than SLIGHT of the fastest."""
    each = twists.reshape(len(twists), twists.shape[1] // 6, 6)
    speeds = _speeds(each, size)
    moves = speeds > SLIGHT * speeds.max(1, initial=0.0)[:, None]
    return np.where(moves[..., None], each, 0.0).reshape(twists.shape)


def _speeds(twists: Float, size: float) -> Float:
    """Return |velocity| + size |angular velocity| for twists (..., 6)."""
    squares = twists * twists
    return np.asarray(np.sqrt(squares[..., :3].sum(-1)) + size * np.sqrt(squares[..., 3:].sum(-1)))


def describe(kinematics: Kinematics, twists: Float, mode: Mode, *, dual: bool) -> Mechanism:
    """Return the mechanism of ``twists`` (K, 6), scaled to the fastest body. ``dual`` is as in ``Mechanism``."""
    return describe_all(kinematics, twists.reshape(1, -1), [mode], dual=dual)[0]


def describe_all(kinematics: Kinematics, twists: Float, modes: Sequence[Mode], *, dual: bool) -> list[Mechanism]:
    """Return the mechanisms of ``twists`` (n, 6K) with a mode each, as ``describe`` does."""
    twists = twists.reshape(len(twists), len(kinematics.names), 6)
    speeds = _speeds(twists, kinematics.size)
    top = speeds.max(1, initial=0.0)
    scaled = twists / np.where(top > 0, top, 1.0)[:, None, None]
    moves = speeds > AT_REST * top[:, None]
    names: dict[bytes, tuple[str, ...]] = {}  # of the bodies that move: the same in most motions of a map
    found = []
    for own, which, mode in zip(scaled, moves, modes, strict=True):
        key = which.tobytes()
        if key not in names:
            names[key] = tuple(kinematics.names[k] for k in np.flatnonzero(which).tolist())
        found.append(Mechanism(moving=names[key], own=own, mode=mode, dual=dual, kinematics=kinematics))
    return found


def _groups(motion: Mechanism) -> list[str]:
    """Describe in words the motion of each group of bodies that move as one rigid body."""
    com, size = motion.kinematics.com, motion.kinematics.size
    number = {name: k for k, name in enumerate(motion.kinematics.names)}
    groups: list[tuple[list[str], Float]] = []
    for name in motion.moving:
        k = number[name]
        at_origin = shift_twist(motion.own[k], com[k], np.zeros(3))
        for members, other in groups:
            if np.allclose(at_origin, other, atol=1e-4):
                members.append(name)
                break
        else:
            groups.append(([name], at_origin))
    parts = [f"{listed(members, NAMED)} {_motion(twist, size, len(members) > 1)}" for members, twist in groups[:6]]
    if len(groups) > 6:
        parts.append(f"and {len(groups) - 6} more groups move")
    return parts


def _contacts(motion: Mechanism) -> list[str]:
    """Name in words the contacts that slide, open or roll: those by which ``modes_of`` names the motion."""
    nodes, own = motion.kinematics.nodes, motion.own
    speeds = parting(nodes, motion.velocities(), dual=motion.dual)
    first = np.searchsorted(nodes.interface, np.arange(len(motion.kinematics.pairs) + 1))  # some may have no nodes
    said: dict[str, list[str]] = {"slides": [], "opens": [], "slides and opens": [], "rolls": []}
    apart = np.append(own, np.zeros((1, 6)), axis=0)  # the last one is that of fixed bodies
    for number, pair in enumerate(motion.kinematics.pairs):
        here = slice(first[number], first[number + 1])
        if first[number] == first[number + 1]:
            continue
        fastest = max(float(speeds.least), STILL)
        slides, opens = (bool(each[here].max() > fastest) for each in speeds)
        spin = apart[nodes.b[first[number]], 3:] - apart[nodes.a[first[number]], 3:]
        if slides or opens:
            said["slides and opens" if slides and opens else "slides" if slides else "opens"].append("-".join(pair))
        elif motion.mode == "roll" and np.linalg.norm(spin) * motion.kinematics.size > STILL:
            said["rolls"].append("-".join(pair))
    return [f"{word}: {listed(named, NAMED)}" for word, named in said.items() if named]


def _motion(twist: Float, size: float, plural: bool) -> str:
    """Describe in words a twist (6,) about the world origin; ``plural`` if it is that of several bodies."""
    s = "" if plural else "s"
    velocity, spin = twist[:3], twist[3:]
    rate = float(np.linalg.norm(spin))
    if rate * size < 0.01 * np.linalg.norm(velocity):  # the axis is a hundred sizes away
        return f"slide{s} along {_vector(velocity / np.linalg.norm(velocity))}"
    axis = spin / rate
    origin = cross(spin, velocity) / rate**2
    pitch = float(axis @ velocity) / rate
    words = f"turn{s} about the axis through {_vector(origin)} along {_vector(axis)}"
    return words + (f" and advance{s} {pitch:.3g} m/rad" if abs(pitch) > 1e-3 * size else "")


def _vector(values: Float) -> str:
    return "(" + ", ".join(f"{v + 0.0:.3g}" for v in np.where(np.abs(values) < 5e-4, 0.0, values)) + ")"
