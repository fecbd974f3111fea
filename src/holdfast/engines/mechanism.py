"""Mechanisms in words, and which contacts of a motion slide or open."""

from __future__ import annotations

from functools import partial

import numpy as np

from holdfast.assembly.assembly import Assembly
from holdfast.assembly.nodes import ContactNodes
from holdfast.base.arrays import Float
from holdfast.base.rigid import shift_twist
from holdfast.engines.contract import Mechanism, Mode

AT_REST = 1e-6  # velocities below this share of the largest count as rest


def relative_velocity(nodes: ContactNodes, com: Float, twists: Float) -> Float:
    """(I, 3) velocity (u_n, u_t1, u_t2) of body b against body a at every node: u = Gᵀ q."""
    velocity = np.zeros((len(nodes), 3))
    for body, sign in ((nodes.b, 1.0), (nodes.a, -1.0)):
        free = np.flatnonzero(body >= 0)
        twist = twists[body[free]]
        velocity[free] += sign * (twist[:, :3] + np.cross(twist[:, 3:], nodes.points[free] - com[body[free]]))
    return np.asarray(np.einsum("ikx,ix->ik", nodes.axes, velocity))


def modes_of(velocities: Float, mu: Float) -> list[Mode]:
    """Whether contacts slide, open or both, from relative velocities (k, I, 3) of k dual motions.

    There a contact that slides also rises, by u_n = μ |u_t|: only what opens faster than that opens in earnest.
    """
    sliding = np.sqrt((velocities[:, :, 1:] ** 2).sum(2))
    speed = np.sqrt(velocities[:, :, 0] ** 2 + sliding**2)
    moving = (speed > AT_REST * speed.max(1, initial=0)[:, None]) & (speed > 0)
    opens = velocities[:, :, 0] > 1.02 * mu * sliding + 0.01 * speed
    names: dict[tuple[bool, bool], Mode] = {
        (False, False): "none",
        (True, False): "topple",
        (False, True): "slip",
        (True, True): "mixed",
    }
    some_open, some_slide = (moving & opens).any(1), (moving & ~opens).any(1)
    return [names[bool(o), bool(s)] for o, s in zip(some_open, some_slide, strict=True)]


def describe(assembly: Assembly, nodes: ContactNodes, twists: Float, mode: Mode, *, dual: bool) -> Mechanism:
    """The mechanism of twists (J, 6), scaled to its fastest body; ``dual`` ones rise by μ where they slide."""
    speeds = np.sqrt((twists[:, :3] ** 2).sum(1)) + assembly.size * np.sqrt((twists[:, 3:] ** 2).sum(1))
    top = speeds.max(initial=0)
    scaled = twists / top if top > 0 else twists
    moving = [int(k) for k in np.flatnonzero(speeds > AT_REST * top)]
    names = [body.name for body in assembly.movable]
    return Mechanism(
        tuple(names[k] for k in moving), scaled, mode, partial(_told, assembly, nodes, scaled, moving, dual)
    )


def _told(assembly: Assembly, nodes: ContactNodes, scaled: Float, moving: list[int], dual: bool) -> str:
    """The motion of each group of bodies that move as one, then which contacts slide and which open."""
    groups: list[tuple[list[int], Float]] = []
    for k in moving:
        at_origin = shift_twist(scaled[k], assembly.com[k], np.zeros(3))
        for members, motion in groups:
            if np.allclose(at_origin, motion, atol=1e-4):
                members.append(k)
                break
        else:
            groups.append(([k], at_origin))
    names = [body.name for body in assembly.movable]
    parts = [
        f"{_listed([names[k] for k in members])} {_motion(motion, assembly.size, len(members) > 1)}"
        for members, motion in groups[:6]
    ]
    if len(groups) > 6:
        parts.append(f"and {len(groups) - 6} more groups move")
    return "; ".join(parts + _contacts(assembly, nodes, scaled, dual))


def _contacts(assembly: Assembly, nodes: ContactNodes, scaled: Float, dual: bool) -> list[str]:
    velocity = relative_velocity(nodes, assembly.com, scaled)
    fastest = max(float(np.abs(velocity).max(initial=0)), 0.01)  # all nodes may lie on the axis of the motion
    said: dict[Mode, list[str]] = {"slip": [], "topple": [], "mixed": []}
    for number, interface in enumerate(assembly.interfaces):
        here = slice(nodes.spans[number], nodes.spans[number + 1])
        if np.abs(velocity[here]).max(initial=0) > 1e-4 * fastest:
            rise = nodes.mu[here] if dual else np.zeros_like(nodes.mu[here])
            said.setdefault(modes_of(velocity[here][None], rise)[0], []).append("-".join(interface.bodies))
    words: tuple[tuple[Mode, str], ...] = (("slip", "slides"), ("topple", "opens"), ("mixed", "slides and opens"))
    return [f"{word}: {_listed(said[mode])}" for mode, word in words if said[mode]]


def _listed(names: list[str]) -> str:
    shown = ", ".join(names[:8])
    return shown + (f" and {len(names) - 8} more" if len(names) > 8 else "")


def _motion(twist: Float, size: float, plural: bool) -> str:
    """Words for a twist (6,) about the world origin."""
    s = "" if plural else "s"
    velocity, spin = twist[:3], twist[3:]
    rate = float(np.linalg.norm(spin))
    if rate * size < 1e-3 * np.linalg.norm(velocity):
        return f"slide{s} along {_vector(velocity / np.linalg.norm(velocity))}"
    axis = spin / rate
    origin = np.cross(spin, velocity) / rate**2
    pitch = float(axis @ velocity) / rate
    words = f"turn{s} about the axis through {_vector(origin)} along {_vector(axis)}"
    return words + (f" and advance{s} {pitch:.3g} m/rad" if abs(pitch) > 1e-3 * size else "")


def _vector(values: Float) -> str:
    return "(" + ", ".join(f"{v + 0.0:.3g}" for v in np.where(np.abs(values) < 5e-4, 0.0, values)) + ")"
