"""What hovers or sinks in a scene, and where its bodies come to rest, as columns of the tables."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from holdfast.applications.settled import settle
from holdfast.assembly.assembly import FIXED, Assembly
from holdfast.base.arrays import Float
from holdfast.base.errors import SceneError
from holdfast.batches.tables import Row, Tables
from holdfast.contacts.neighbours import components
from holdfast.geometry.sweep import Swept, hit_distance
from holdfast.queries.request import quiet
from holdfast.scene.hold import hold_ends
from holdfast.scene.scene import Scene


def pose_row(pose: Float, prefix: str = "") -> Row:
    """Return a pose (4, 4) as columns: position, and quaternion with qw >= 0."""
    turn = Rotation.from_matrix(pose[:3, :3]).as_quat(canonical=True)
    values = {**dict(zip("xyz", pose[:3, 3], strict=True)), **dict(zip(("qx", "qy", "qz", "qw"), turn, strict=True))}
    return {f"{prefix}{name}": float(value) for name, value in values.items()}


def add_faults(assembly: Assembly, rows: list[Row]) -> None:
    """Write into the rows of bodies what hovers, how high and above what, and what sinks, how deep and into what."""
    row_of = {row["body"]: row for row in rows}
    for overlap in assembly.overlaps:
        for name, other in (overlap.bodies, overlap.bodies[::-1]):
            row = row_of[name]
            if not row["fixed"] and overlap.depth > (row.get("sinks") or 0.0):
                row |= {"sinks": float(overlap.depth), "into": other}
    for group in hanging(assembly):
        height, below = drop(assembly, group)
        for name in group:
            row_of[name] |= {"hovers": height, "above": below}


def hanging(assembly: Assembly) -> list[tuple[str, ...]]:
    """Return the groups of movable bodies that no contact, overlap or hold connects with a fixed body."""
    index, movable = assembly.index, assembly.movable
    ends = [*assembly.ends, *hold_ends(assembly.scene.holds, index, FIXED)]
    ends += [(index[a], index[b]) for a, b in (overlap.bodies for overlap in assembly.overlaps)]
    carried = {end for pair in ends if FIXED in pair for end in pair}
    groups = components(len(movable), [(a, b) for a, b in ends if FIXED not in (a, b)])
    return [tuple(movable[k].name for k in group) for group in groups if carried.isdisjoint(group)]


def drop(assembly: Assembly, group: tuple[str, ...]) -> tuple[float, str | None]:
    """Return how far a group falls straight down [m] before it touches another body, and which; else inf and None."""
    if not np.any(assembly.scene.gravity):
        return float("inf"), None
    down = -assembly.scene.up
    falling = [Swept(assembly.scene.body(name).reduced_world, down) for name in group]
    nearest, below = float("inf"), None
    for body in assembly.bodies:
        if body.name not in group:
            still = Swept(body.reduced_world, down)
            fall = min(hit_distance(one, still) for one in falling)
            if fall < nearest:
                nearest, below = float(fall), body.name
    return nearest, below


def add_rest(scene: Scene, options: Mapping[str, Any], tables: Tables) -> None:
    """Write where the bodies of a scene come to rest into its row and theirs; a scene with holds cannot settle."""
    row = tables["scenes"][0]
    try:
        with quiet():
            found = settle(scene, **options)
    except SceneError as error:
        row["settled_reason"] = str(error)
        return
    row |= {"settled": found.status.value, "settled_reason": found.reason}
    row["moved"] = float(found.moved.max(initial=0.0))
    place = {name: k for k, name in enumerate(found.names)}
    for body in tables["bodies"]:
        k = place.get(body["body"])
        if k is not None:
            body |= {"moved": float(found.moved[k]), "turned_degrees": float(found.turned_degrees[k])}
            body |= {"settled_reason": found.reasons[k]}
            body |= pose_row(found.scene.body(body["body"]).pose, "rest_")
