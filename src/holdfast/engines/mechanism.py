"""Mechanisms in words, and which contacts of a motion slide or open."""

from __future__ import annotations

import numpy as np

from holdfast.arrays import Float
from holdfast.assembly.assembly import Assembly
from holdfast.assembly.nodes import ContactNodes
from holdfast.engines.contract import Mechanism, Mode
from holdfast.rigid import shift_twist

AT_REST = 1e-6  # velocities below this share of the largest count as rest


def relative_velocity(nodes: ContactNodes, com: Float, twists: Float) -> Float:
    """(I, 3) velocity (u_n, u_t1, u_t2) of body b against body a at every node: u = Gᵀ q."""
    velocity = np.zeros((len(nodes), 3))
    for body, sign in ((nodes.b, 1.0), (nodes.a, -1.0)):
        free = np.flatnonzero(body >= 0)
        twist = twists[body[free]]
        velocity[free] += sign * (twist[:, :3] + np.cross(twist[:, 3:], nodes.points[free] - com[body[free]]))
    return np.asarray(np.einsum("ikx,ix->ik", nodes.axes, velocity))


def mode_of(velocity: Float, mu: Float) -> Mode:
    """Whether contacts slide, open or both, from relative velocities (I, 3) of a dual motion.

    There a contact that slides also rises, by u_n = μ |u_t|: only what opens faster than that opens in earnest.
    """
    speed = np.linalg.norm(velocity, axis=1)
    moving = (speed > AT_REST * speed.max(initial=0)) & (speed > 0)
    if not moving.any():
        return "none"
    rise = mu[moving] * np.linalg.norm(velocity[moving, 1:], axis=1)
    opens = velocity[moving, 0] > 1.02 * rise + 0.01 * speed[moving]
    slides = ~opens
    if opens.any() and slides.any():
        return "mixed"
    return "topple" if opens.any() else "slip"


def describe(assembly: Assembly, twists: Float, mode: Mode) -> Mechanism:
    """The mechanism of twists (J, 6), scaled to its fastest body, with the motion of each group in words."""
    size = assembly.size
    speeds = np.linalg.norm(twists[:, :3], axis=1) + size * np.linalg.norm(twists[:, 3:], axis=1)
    top = speeds.max(initial=0)
    scaled = twists / top if top > 0 else twists
    moving = [k for k in range(len(speeds)) if speeds[k] > AT_REST * top]
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
        f"{_listed([names[k] for k in members])} {_motion(motion, size, len(members) > 1)}"
        for members, motion in groups[:6]
    ]
    if len(groups) > 6:
        parts.append(f"and {len(groups) - 6} more groups move")
    return Mechanism(tuple(names[k] for k in moving), scaled, mode, "; ".join(parts))


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
