"""Scenes that are edited in tests, and comparisons to the last bit."""

from __future__ import annotations

import pickle
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import holdfast as hf
from bench.scenes import real_pallets
from holdfast.contacts.contact_search import search
from holdfast.contacts.interface import Interface

SHARED = Path(__file__).parents[3] / "shared" / "cases"
ENGINES = ("graph", "limit", "compliant")


def turned(pose: Any, degrees: float) -> NDArray[np.float64]:
    angle = np.radians(degrees)
    turn = np.eye(4)
    turn[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    return np.asarray(pose @ turn)


def pallet(place: int = 12) -> hf.Scene:
    """A loaded pallet of the shared cases, by its place in the order of their numbers of boxes."""
    return real_pallets.pallet(real_pallets.pallets()[place], 0.4)


def anew(assembly: hf.answers.Assembly) -> hf.answers.Assembly:
    """An assembly of the same scene that shares no object with it, its contacts detected at the same tolerances."""
    scene = pickle.loads(pickle.dumps(assembly.scene))
    found = search(scene, assembly.tolerances)
    return hf.answers.Assembly(
        scene, found.interfaces, assembly.tolerances, found.overlaps, found.occluded, absent=assembly.absent
    )


def bits(interface: Interface) -> tuple[Any, ...]:
    patches = [
        (p.polygon.tobytes(), p.normal.tobytes(), tuple(h.tobytes() for h in p.holes), p.separation, p.breadth, p.inset)
        for p in interface.patches
    ]
    return interface.bodies, interface.status, interface.flags, interface.certain, interface.mu, patches


def same_contacts(one: hf.answers.Assembly, other: hf.answers.Assembly) -> bool:
    return (
        one == other
        and [bits(i) for i in one.interfaces] == [bits(i) for i in other.interfaces]
        and one.occluded == other.occluded
    )


def answers(assembly: hf.answers.Assembly, engine: str, names: list[str]) -> list[Any]:
    """Bits of the verdict, and of pushes along two directions at corners of some bodies."""
    stands = hf.stability(assembly, engine=engine)
    told: list[Any] = [stands.status, stands.reason, stands.moving]
    for name in names:
        vertices = assembly.scene.body(name).surface_world.vertices
        points = np.array([vertices[0], vertices[len(vertices) // 2]])
        for direction in ([1.0, 0.2, 0.1], [0.0, -1.0, 0.0]):
            found = hf.robustness(assembly, name, points, direction, engine=engine)
            arrays = (found.answers.force, found.answers.lower, found.answers.upper)
            told.append(
                (name, *(a.tobytes() for a in arrays), found.answers.status.tolist(), found.answers.moving.tolist())
            )
    return told
