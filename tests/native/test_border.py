"""Whatever is handed to the compiled core: what does not fit is a TypeError or a ValueError, never a crash.

Each entry point that takes arrays is called with what fits, and then with one array or number changed at a time.
`make test-sanitized` runs all of it where reading or writing outside an array ends the process.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import suppress
from fnmatch import fnmatchcase
from functools import cache
from operator import attrgetter
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import holdfast as hf
from holdfast.contacts.search_mesh import SearchMesh
from holdfast.elastic.system import QUICK, EliminationFronts, PathResult, System
from holdfast.engines.compliant.elastic_model import Springs
from holdfast.engines.compliant.grid import Grid
from holdfast.engines.trees.forest import Bed
from holdfast.native import core
from holdfast.scene.shipped.blocks import wall

Arguments = dict[str, Any]

ONES3, EYES = np.ones((4, 3)), np.stack([np.eye(3)] * 4)
SQUARE = np.array([[0.0, 0.0], [1, 0], [1, 1], [0, 1]])
TRIANGLES = np.array([[[0.0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 0, 1], [1, 0, 1], [0, 1, 1]]])
FACES = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])
POINTS = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
LOADS = np.vstack([np.eye(6), -np.eye(6)])
LIMITS = (0.1, 0.1, 0.1, 0.1, 1e-9, 1e-6)
BED = Bed(
    np.hstack([SQUARE - 0.5, np.roll(SQUARE, -1, 0) - 0.5, np.full((4, 1), 0.5)]),
    np.array([[0.5, 1.0, 0.0], [0.5, -1, 0], [0.5, 0, 1], [0.5, 0, -1]]),
    np.array([0.8, 0.5]),
)
FACE = (SQUARE, np.array([0, 4]), np.vstack([np.eye(2), np.zeros(2), np.ones(2)]), SQUARE)
REST = np.array([1.0, 0, 0, 0, 0, 0])
PIECES = np.vstack([SQUARE, SQUARE + 0.5])
RINGS = (np.hstack([PIECES, np.zeros((8, 1))]), np.array([0, 4, 8]), np.arange(3))  # of two faces, one ring each
UP = np.array([[0.0, 0, 1]] * 2)


@cache
def mesh() -> SearchMesh:
    return SearchMesh.of(hf.Body("box", hf.Box((1, 1, 1)), mass=1.0))


@cache
def bricks() -> System:
    assembly = hf.assemble(wall(3, 3, 0.25, "wall"))
    return System.by_fronts(Grid.of(assembly, assembly.weight_wrench(), Springs(7)).system.model)


def elastic(**more: Any) -> Arguments:
    """A model with memory for its fronts, and what else a call needs."""
    model, fronts = bricks().model, bricks().fronts
    own = {"model": model, "work": core.Work(model, fronts), "fronts": fronts}
    return own | more


def bare(**more: Any) -> Arguments:
    return {"model": bricks().model} | more


def n() -> int:
    return len(bricks().model.wrench)


def q() -> np.ndarray:
    return np.zeros(n())


def push() -> np.ndarray:
    return np.tile([0.0, 1, 0, 0, 0, 0], n() // 6)


def stepper() -> core.Stepper:
    return core.Stepper(q(), QUICK)


def stiffness() -> np.ndarray:
    return np.zeros_like(bricks().model.bonded)


def sheets() -> int:
    return len(bricks().model.a)


def front() -> np.ndarray:
    return np.hstack([2 * np.eye(4) + 0.1, np.ones((4, 2))])


def boxes(low: np.ndarray = POINTS) -> tuple[np.ndarray, np.ndarray]:
    return low, low + 1.0


def swept() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    return TRIANGLES, TRIANGLES.min(1), TRIANGLES.max(1)


def covering() -> Arguments:
    """Two patches, the second one with a hole."""
    hole = 0.25 + SQUARE[::-1] / 2
    flat = np.vstack([SQUARE, SQUARE + 0.5, hole + 0.5])
    frames = np.tile([[1.0, 0, 0], [0, 1, 0]], (2, 1, 1))
    return {"corners": np.hstack([flat, np.zeros((12, 1))]), "stops": np.array([4, 8, 12]), "rings": np.array([1, 3]),
            "normals": UP, "tangents": frames, "gap": 0.1}  # fmt: skip


def paths() -> Arguments:
    loads = np.stack([push(), -push()])
    return elastic(stepper=stepper(), start=q(), loads=loads, into=PathResult.lost(2, n()), rows=np.arange(2),
                   most=np.full(2, 1e-3))  # fmt: skip


PAIRS = np.array([[0, 0], [1, 1]])
CALLS: dict[str, Callable[[], Arguments]] = {
    "Work": lambda: {"model": bricks().model, "fronts": bricks().fronts},
    "Stepper": lambda: {"stuck": q(), "pace": QUICK},
    "cut": lambda: {"first": np.array([0, 2, 4]), "x": np.ones(4), "y": np.ones(4), "apart": np.ones(4)},
    "bond": lambda: bare(bonded=stiffness(), still=q()),
    "set_units": lambda: bare(unit=q()),
    "sheet_twist": lambda: bare(p=0, q=q(), v=np.zeros(6)),
    "add_wrenches": lambda: bare(wrenches=np.zeros((sheets(), 6)), r=q()),
    "nearest": lambda: {"runs": bricks().model.runs, "run": 0, "v": np.ones(6), "weight": 1.0},
    "evaluate": lambda: bare(weight=1.0, q=q(), r=q(), K=stiffness()),
    "node_forces": lambda: bare(q=q(), f=np.zeros((len(bricks().model.k), 3))),
    "next_change": lambda: bare(q=q(), t=push()),
    "concentrated": lambda: bare(
        first=bricks().model.first, a=bricks().model.a, b=bricks().model.b, most=np.ones(sheets()),
        q=np.zeros((2, n())), found=np.zeros((2, sheets()), np.uint8),
    ),
    "write_entries": lambda: bare(
        K=stiffness(), rows=np.zeros(144 * sheets(), int), columns=np.zeros(144 * sheets(), int),
        values=np.ones(144 * sheets()),
    ),
    "eliminate": lambda: {"F": front(), "P": np.zeros((2, 4)), "columns": np.arange(4), "full": 2, "least": 0.0},
    "finish": lambda: {"F": front(), "P": np.ones((2, 4)), "X": np.zeros((1, 5)), "full": 2},
    "apply_pivots": lambda: {"F": front(), "P": np.ones((2, 4)), "X": np.ones((1, 5))},
    "passes_on": lambda: {"fronts": bricks().fronts, "k": 0},
    "solve": lambda: elastic(drag=1.0, corner=1.0),
    "add_drag": lambda: bare(work=core.Work(bricks().model, None), drag=1.0, q=q(), anchor=q()),
    "unbalance": lambda: bare(work=core.Work(bricks().model, None), balance=(1.0, 1.0, 1.0, q()), q=q(), s=0.0),
    "newton": lambda: elastic(
        balance=(1.0, 1.0, 1.0, q()), q=q(), s=0.0, level=0.0, tolerance=1e-7, most=5, least=0.0
    ),
    "lessen_drag": lambda: elastic(weight=1.0, q=q(), drift=q(), exact=1e-7, most=20),
    "move": lambda: elastic(weight=1.0, q=q(), drift=q(), exact=1e-7, most=20),
    "bond_all": lambda: elastic(load=push(), q=q()),
    "rests_near": lambda: elastic(q=q()),
    "begin": lambda: elastic(stepper=stepper(), start=q(), load=push()),
    "advance": lambda: elastic(stepper=stepper()),
    "cross_change": lambda: elastic(stepper=stepper()),
    "set_out": lambda: elastic(stepper=stepper()),
    "land": lambda: bare(work=core.Work(bricks().model, None), stepper=stepper(), s=0.0, sign=1.0),
    "turn": lambda: {"work": core.Work(bricks().model, None), "sign": 1.0, "orientation": 1.0, "tangent": q()},
    "torn": lambda: {
        "work": core.Work(bricks().model, None), "sign": 1.0, "orientation": 1.0, "q": q(), "tangent": push(),
        "trial": push(), "step": 1.0, "most": 0.5,
    },
    "fell_from_crest": lambda: elastic(stepper=stepper()),
    "follow_each": paths,
    "loads_nearby": lambda: elastic(
        loads=np.stack([push()] * 2), s=np.zeros(2), q=np.zeros((2, n())), plane=np.ones((2, n())), into=np.zeros(2),
        rows=np.arange(2),
    ),
    "first_exits": lambda: {"bed": BED, "rest": REST, "loads": LOADS, "until": np.ones(12)},
    "share_at_rest": lambda: {"bed": BED, "rest": REST},
    "sliding_under": lambda: {"bed": BED, "carried": REST},
    "pressed_parts": lambda: {"bed": BED, "pressure": np.ones(3)},
    "find_pressure": lambda: {"bed": BED, "carried": REST[:3].copy()},
    "share_used": lambda: {"bed": BED, "carried": REST},
    "most_between": lambda: {"bed": BED, "rest": REST, "load": LOADS[1], "low": 0.0, "at": 0.1, "squares": 1.0},
    "arc_capacities": lambda: {
        "forces": ONES3, "axes": EYES, "mu": np.ones(4), "owner": np.array([0, 0, 1, 1]), "count": 2,
        "direction": np.ones(3),
    },
    "max_flow": lambda: {
        "tails": np.array([0, 1]), "heads": np.array([1, 2]), "capacity": np.ones((2, 2)), "source": 0, "sink": 2,
        "count": 3, "side": np.zeros(3, bool),
    },
    "slip_many": lambda: {
        "forces": ONES3, "axes": EYES, "mu": np.ones(4), "owner": np.array([0, 0, 1, 1]), "tails": np.array([0, 1]),
        "heads": np.array([1, 2]), "count": 3, "sources": np.array([0, 1]), "directions": np.ones((2, 3)),
        "side": np.zeros((2, 3), bool),
    },
    "first_of_line": lambda: {
        "start": POINTS, "direction": ONES3, "tolerance": 1e-9, "fresh": np.zeros(4, bool)
    },
    "axis_torques": lambda: {
        "origins": POINTS[:2], "axes": ONES3[:2], "flat": np.zeros(2, bool), "points": POINTS, "frames": EYES,
        "forces": ONES3, "mu": np.ones(4), "moving_is_a": np.ones(4, bool), "size": 1.0,
    },
    "combined": lambda: {
        "points": LOADS, "known": LOADS, "near": np.arange(24).reshape(12, 2) % 12, "values": np.ones(12),
        "axes": np.ones((2, 6)), "rounding": 1e-14,
    },
    "peel": lambda: {
        "inward": ONES3, "mu": np.ones(4), "node": np.arange(4), "other": np.array([-1, 1, 0, -1]),
        "first": np.array([0, 2, 4]), "left": np.ones(4, bool),
    },
    "sheets_begin": lambda: {"points": POINTS, "axes": EYES, "interface": np.array([0, 0, 1, 1]), "flat": 1e-9},
    "place_sheets": lambda: {
        "points": POINTS, "axes": EYES, "first": np.array([0, 2, 4]), "a": np.array([-1, 0]), "b": np.array([0, 1]),
        "com": ONES3[:2], "own": np.eye(3), "size": 1.0, "x": np.zeros(4), "y": np.zeros(4),
        "turned": np.zeros((2, 3, 3)), "arm_a": np.zeros((2, 3)), "arm_b": np.zeros((2, 3)),
    },
    "rectangle_axes": lambda: {"hull": SQUARE},
    "corner_numbers": lambda: {"points": SQUARE, "order": np.arange(4)},
    "mark_hits": lambda: {
        "points": POINTS, "normals": ONES3, "triangles": TRIANGLES, "length": 1.0, "result": np.zeros(4, bool)
    },
    "cut_by_grid": lambda: {
        "triangles": np.ascontiguousarray(TRIANGLES[:, :, :2]), "step": np.full(2, 0.5), "columns": 2,
        "first": np.zeros((2, 2), int), "last": np.full((2, 2), 2),
    },
    "winding_numbers": lambda: {"points": POINTS, "vertices": POINTS, "faces": FACES},
    "nearest_of_pairs": lambda: {"points": POINTS, "triangles": TRIANGLES, "pairs": PAIRS},
    "squared_distances": lambda: {"points": POINTS, "triangles": TRIANGLES},
    "hull_gauge": lambda: {"known": LOADS, "price": np.ones(12), "points": LOADS, "rounding": 1e-14},
    "add_moments": lambda: {"ring": SQUARE, "total": np.zeros(6)},
    "shared_parts": lambda: {"ours": swept(), "theirs": swept(), "least": 0.0},
    "placed": lambda: {"points": POINTS, "faces": FACES, "pose": np.eye(4)},
    "near_boxes": lambda: dict(zip(("low_a", "high_a", "low_b", "high_b"), boxes() * 2, strict=True))
    | {"axis": 0, "gap": 0.1},
    "near_faces": lambda: {"a": mesh(), "b": mesh(), "gap": 0.1, "facet_a": -1, "facet_b": -1, "but_facets": False},
    "clip_faces": lambda: {
        "a": mesh(), "b": mesh(), "pairs": PAIRS, "gap": 9.0, "depth": 9.0, "flat_cosine": -1.0, "curved_cosine": -1.0
    },
    "touching_features": lambda: {"a": mesh(), "b": mesh(), "pairs": PAIRS, "limits": LIMITS},
    "cuboid_contacts": lambda: {
        "bodies": np.stack([np.vstack([np.full(3, 2.0 * k), np.eye(3), np.ones(3)]) for k in range(2)]), "pairs": PAIRS,
        "limits": np.tile([0.1, 1.0, 1e-6], (2, 1)), "rounding": 1e-9, "wide": 1e-6,
    },
    "facing_corners": lambda: {
        "triangles_a": TRIANGLES, "normals_a": ONES3[:2], "triangles_b": TRIANGLES, "normals_b": -ONES3[:2],
        "pairs": PAIRS, "margin": 9.0, "depth": 9.0, "cos_angle": 0.0,
    },
    "facing_near": lambda: {"pairs": PAIRS}
    | dict(zip(("low_a", "high_a", "normals_a", "low_b", "high_b", "normals_b"), (*boxes(), ONES3) * 2, strict=True))
    | {"margin": 0.1},
    "mark_unexplained": lambda: {"rows": np.ones((4, 7)), "alike": 0.5, "good": np.zeros(4, bool)},
    "spread_points": lambda: {"rows": np.ones((4, 7)), "size": 1.0, "same": 0.1},
    "fill_triangles": lambda: {
        "pixels": 4 * POINTS, "triangles": FACES, "behind": np.zeros(4), "depth": np.full((5, 6), np.inf),
        "seen": np.full((5, 6), -1),
    },
    "draw_lines": lambda: {
        "seen": np.arange(30).reshape(5, 6) % 5 - 1, "depth": np.ones((5, 6)), "normals": ONES3,
        "body": np.array([0, 0, 1, 1]), "scale": 1.0, "crease_cosine": 0.5, "step_pixels": 1.0,
        "line": np.zeros((5, 6), np.uint8),
    },
    "edges_of": lambda: {"faces": FACES, "count": 4},
    "topology_of": lambda: {"vertices": POINTS, "faces": FACES, "normals": ONES3},
    "regions_of": lambda: {
        "beside": np.array([[0, 1], [1, -1]]), "bend": np.array([0.1, np.inf]), "angle": 0.5, "count": 2
    },
    "median_length": lambda: {"vertices": POINTS, "ends": np.array([[0, 1], [2, 3]])},
    "median_scatter": lambda: {
        "vertices": mesh().vertices, "faces": mesh().faces, "areas": np.ones(len(mesh().faces)),
        "normals": mesh().normals, "starts": mesh().starts, "neighbours": mesh().neighbours, "samples": 8,
        "least_samples": 4,
    },
    "nodes_on": lambda: {"face": FACE, "across": 4, "along": 3, "most": 4, "margin": 1e-9},
    "cells_on": lambda: {"face": FACE, "along": 4, "across": 3},
    "nearest_of": lambda: {"points": SQUARE, "places": SQUARE},
    "farthest_of": lambda: {"candidates": SQUARE, "chosen": SQUARE[:1], "count": 3},
    "corrected": lambda: {
        "given": np.ones(4), "basis": np.ones((1, 4)), "wanted": np.full(1, 4.0), "matched": np.array([1])
    },
    "matched_weights": lambda: {
        "nodes": SQUARE, "shares": np.ones(4), "moments": np.array([1, 0.5, 0.5, 1 / 3, 0.25, 1 / 3]), "arm": 0.4,
        "scale": 1.0,
    },
    "without_touching": lambda: bare(q=q(), rounding=1e-7),
    "Cover": covering,
    "Cover.covered": lambda: {
        "self": core.Cover(**covering()), "ends": np.stack([POINTS[:2], POINTS[[0, 2]]], 1), "normals": UP,
        "alike": np.full(2, 0.9),
    },
    "Cover.left": lambda: {
        "self": core.Cover(**covering()), "ends": POINTS[:2], "normal": UP[0], "alike": 0.9, "slack": 0.0
    },
    "area_vectors": lambda: {"vertices": POINTS, "faces": FACES},
    "areas_of": lambda: {"vertices": POINTS, "faces": FACES},
    "normals_of": lambda: {"vertices": POINTS, "faces": FACES},
    "may_lose_corners": lambda: {
        "vertices": mesh().vertices, "faces": mesh().faces, "ends": mesh().edges, "beside": mesh().sides,
        "of_face": mesh().of_face, "tolerance": 1e-9,
    },
    "prepared": lambda: {
        "vertices": mesh().vertices, "faces": mesh().faces, "normals": mesh().normals, "ends": mesh().edges,
        "bend": mesh().bend,
    },
    "outward_of": lambda: {"vertices": mesh().vertices, "faces": mesh().faces, "normals": mesh().normals},
    "near_bodies": lambda: {
        "boxes": np.stack(boxes(), 1), "fixed": np.zeros(4, bool), "asked": np.ones(4, bool), "gap": 0.1
    },
    "canonical": lambda: {
        "patches": (*RINGS, UP, np.array([False, True])), "origin": np.zeros(3), "axes": np.eye(3)
    },
    "grids_over": lambda: {"corners": RINGS[0], "first": RINGS[1], "normal": UP, "count": np.array([4, 9])},
    "convex_hull": lambda: {"points": SQUARE, "tolerance": 1e-9},
    "groups_apart": lambda: {"corners": SQUARE, "ends": np.array([2, 4]), "apart": 0.1},
    "outlines_of": lambda: {"corners": PIECES, "ends": np.array([4, 8]), "near": 1e-9},
    "measures_of": lambda: {"rings": PIECES.reshape(2, 4, 2)},
    "cuts_of": lambda: {"count": 3, "ends": np.array([[-1, 0], [0, 1], [1, 2]])},
    "beds_of": lambda: {"faces": (*RINGS, UP, np.ones(2), np.array([1.0, -1.0]), np.arange(3))},
    "carried_by": lambda: {
        "beds": (
            np.array([0, 4]), np.array([0, 4]), BED.edges, BED.hull, BED.size[None], EYES[:1], np.zeros((1, 3)),
            np.array([0, 2]), np.arange(2),
        ),
        "com": POINTS[:2], "wrenches": LOADS[:2],
    },
    "node_wrenches": lambda: {
        "points": POINTS, "axes": EYES, "a": np.array([-1, 0, 1, 1]), "b": np.array([0, 1, -1, 0]), "com": POINTS[:2],
        "forces": ONES3,
    },
    "order_fronts": lambda: {
        "count": 3, "a": np.array([-1, 0, 1]), "b": np.array([0, 1, 2]), "ranks": np.array([[0, 1, 2], [2, 0, 1]])
    },
}  # fmt: skip

# What is written to, by its name or the names that lead to it
WRITTEN = {
    "bond": {"bonded", "still"}, "set_units": {"unit"}, "sheet_twist": {"v"}, "add_wrenches": {"r"},
    "evaluate": {"r", "K"}, "node_forces": {"f"}, "concentrated": {"found"},
    "write_entries": {"rows", "columns", "values"}, "eliminate": {"F", "P", "columns"}, "finish": {"F", "X"},
    "apply_pivots": {"F"}, "newton": {"q"}, "lessen_drag": {"q", "drift"}, "move": {"q", "drift"},
    "bond_all": {"q"}, "rests_near": {"q"}, "turn": {"tangent"},
    "follow_each": {f"into.{name}" for name in PathResult._fields}, "loads_nearby": {"into"},
    "max_flow": {"side"}, "slip_many": {"side"}, "first_of_line": {"fresh"}, "peel": {"left"},
    "place_sheets": {"x", "y", "turned", "arm_a", "arm_b"}, "mark_hits": {"result"}, "add_moments": {"total"},
    "mark_unexplained": {"good"}, "fill_triangles": {"depth", "seen"}, "draw_lines": {"line"},
}  # fmt: skip

# Arrays of any number of rows, and those of which there may be more than others need
FREE = {
    "Stepper": {"stuck"}, "nearest": {"runs.*"}, "passes_on": {"fronts.*"}, "apply_pivots": {"P", "X"},
    "follow_each": {"rows"}, "loads_nearby": {"rows"}, "rectangle_axes": {"hull"}, "corner_numbers": {"order"},
    "mark_hits": {"triangles"}, "winding_numbers": {"points", "faces"},
    "nearest_of_pairs": {"points", "pairs"}, "squared_distances": {"*"}, "hull_gauge": {"points"},
    "add_moments": {"ring"}, "placed": {"faces"}, "near_faces": {"?.neighbours"},
    "clip_faces": {"?.neighbours", "pairs"},
    "touching_features": {"pairs"}, "facing_corners": {"pairs"}, "facing_near": {"pairs"}, "spread_points": {"rows"},
    "edges_of": {"faces"}, "median_length": {"ends"}, "nodes_on": {"face.3"}, "cells_on": {"face.3"},
    "nearest_of": {"*"}, "farthest_of": {"*"}, "corrected": {"matched"},
    "area_vectors": {"faces"}, "areas_of": {"faces"}, "normals_of": {"faces"}, "convex_hull": {"points"},
    "groups_apart": {"ends"}, "outlines_of": {"ends"}, "measures_of": {"rings"}, "cuts_of": {"ends"},
    "order_fronts": {"ranks"},
} | {name: {"bed.edges", "bed.hull"} for name in CALLS if "bed" in CALLS[name]()}  # fmt: skip
LONGER = {
    "cut": {"first"}, "write_entries": {"rows", "columns", "values"}, "peel": {"first", "left"},
    "place_sheets": {"com"}, "corner_numbers": {"points"}, "winding_numbers": {"vertices"},
    "nearest_of_pairs": {"triangles"}, "placed": {"points"}, "touching_features": {"?.neighbours"},
    "cuboid_contacts": {"bodies"}, "fill_triangles": {"pixels"}, "topology_of": {"vertices"},
    "median_length": {"vertices"}, "nodes_on": {"face.1"}, "cells_on": {"face.1"}, "area_vectors": {"vertices"},
    "areas_of": {"vertices"}, "normals_of": {"vertices"}, "may_lose_corners": {"vertices"}, "prepared": {"vertices"},
    "outward_of": {"vertices"}, "groups_apart": {"corners"}, "outlines_of": {"corners"}, "node_wrenches": {"com"},
}  # fmt: skip
WIDER = {"eliminate": {"F"}, "finish": {"F"}, "apply_pivots": {"F", "X"}, "combined": {"near"}}
# Whole numbers that are compared with each other alone, or that a call does not look at
UNREAD = {
    "nearest": {"runs.*"}, "passes_on": {"fronts.*"}, "sheets_begin": {"interface"}, "near_faces": {"*"},
    "clip_faces": {"[ab].*"}, "touching_features": {"?.facet"}, "draw_lines": {"body"}, "order_fronts": {"ranks"},
}  # fmt: skip


def copied(value: Any) -> Any:
    """The same in memory of its own, arrays in tuples, too."""
    if isinstance(value, np.ndarray):
        return value.copy()
    if isinstance(value, tuple):
        parts = [copied(part) for part in value]
        return type(value)(*parts) if hasattr(value, "_fields") else tuple(parts)
    return value


def leaves(value: Any, name: str) -> Iterator[tuple[str, Any]]:
    """All arrays and numbers in an argument, by the names that lead to them."""
    if isinstance(value, tuple):
        names = getattr(value, "_fields", range(len(value)))
        for key, part in zip(names, value, strict=True):
            yield from leaves(part, f"{name}.{key}")
    else:
        yield name, value


def put(value: Any, path: list[str], new: Any) -> Any:
    """The same value with another one where the path leads."""
    if not path:
        return new
    names = [str(key) for key in getattr(value, "_fields", range(len(value)))]
    parts = [put(part, path[1:], new) if key == path[0] else part for key, part in zip(names, value, strict=True)]
    return type(value)(*parts) if hasattr(value, "_fields") else tuple(parts)


def call(name: str, arguments: Arguments) -> object:
    return attrgetter(name)(core)(**arguments)


def changed(name: str, leaf: str, new: Any) -> object:
    """Call with what fits but for one array or number."""
    arguments = {key: copied(value) for key, value in CALLS[name]().items()}
    first, *path = leaf.split(".")
    return call(name, arguments | {first: put(arguments[first], path, new)})


def arrays(name: str) -> Iterator[tuple[str, np.ndarray]]:
    for key, value in CALLS[name]().items():
        yield from ((leaf, part) for leaf, part in leaves(value, key) if isinstance(part, np.ndarray))


def among(names: dict[str, set[str]], name: str, leaf: str) -> bool:
    return any(fnmatchcase(leaf, pattern) for pattern in names.get(name, ()))


def harmless(name: str, leaf: str, new: Any) -> None:
    """Whatever comes of it but a crash, and an error of another kind."""
    with suppress(ValueError):
        changed(name, leaf, new)


OTHER = {"float64": "float32", "int64": "int32", "bool": "int64", "uint8": "float64"}


def refused(kind: type[Exception], name: str, leaf: str, new: Any, what: str) -> None:
    try:
        changed(name, leaf, new)
    except kind:
        return
    pytest.fail(f"{name} takes {leaf} {what}")


def test_all_that_takes_arrays_is_asked() -> None:
    stub = Path(core.__file__).with_name("core.pyi")
    if not stub.exists():
        pytest.skip("the stub of the core is not made")
    taking, owner = set(), ""
    for line in stub.read_text().splitlines():
        name = line.strip().removeprefix("def ").partition("(")[0]
        if line.startswith("class "):
            owner = line.removeprefix("class ").rstrip(":")
        elif line.startswith("def ") and "NDArray" in line:
            taking.add(name)
        elif line.startswith("    def ") and "NDArray" in line.partition(" -> ")[0]:
            taking.add(owner if name == "__init__" else f"{owner}.{name}")
    assert not taking - CALLS.keys()


@pytest.mark.parametrize("name", CALLS)
def test_what_fits_is_taken(name: str) -> None:
    call(name, {key: copied(value) for key, value in CALLS[name]().items()})


@pytest.mark.parametrize("name", CALLS)
def test_arrays_of_another_kind_are_type_errors(name: str) -> None:
    for leaf, array in arrays(name):
        refused(TypeError, name, leaf, array.astype(OTHER[array.dtype.name]), "of another type")
        refused(TypeError, name, leaf, array[None], "with one more axis")
        refused(TypeError, name, leaf, array.tolist(), "as a list")
        refused(TypeError, name, leaf, None, "as nothing")
        if array.shape[-1] > 1 and array.size:
            refused(TypeError, name, leaf, np.repeat(array, 2, -1)[..., ::2], "with numbers that lie apart")


@pytest.mark.parametrize("name", CALLS)
def test_arrays_that_are_read_only_are_type_errors_where_they_are_written(name: str) -> None:
    for leaf, array in arrays(name):
        sealed = array.copy()
        sealed.setflags(write=False)
        if leaf in WRITTEN.get(name, ()):
            refused(TypeError, name, leaf, sealed, "read-only")
        else:
            changed(name, leaf, sealed)


@pytest.mark.parametrize("name", CALLS)
def test_arrays_of_other_sizes_are_value_errors(name: str) -> None:
    for leaf, array in arrays(name):
        longer, shorter = np.concatenate([array, array[-1:]]), array[:-1]
        if among(FREE, name, leaf):
            harmless(name, leaf, longer)
            harmless(name, leaf, shorter)
        else:
            refused(ValueError, name, leaf, shorter, "one row shorter")
            if among(LONGER, name, leaf):
                harmless(name, leaf, longer)
            else:
                refused(ValueError, name, leaf, longer, "one row longer")
        harmless(name, leaf, array[:0])
        if array.ndim > 1:
            wider = np.concatenate([array, array[..., -1:]], -1)
            narrower = np.ascontiguousarray(array[..., :-1])
            for other in (wider, narrower):
                if among(WIDER, name, leaf):
                    harmless(name, leaf, other)
                else:
                    refused(ValueError, name, leaf, other, f"of shape {other.shape}")


@pytest.mark.parametrize("name", CALLS)
def test_indices_of_nothing_are_value_errors(name: str) -> None:
    for leaf, array in arrays(name):
        if array.dtype != np.int64 or leaf in WRITTEN.get(name, ()):
            continue
        for index in (-2, 2**32, 2**62):
            last = array.copy()
            last.flat[-1] = index
            every = np.full_like(array, index)
            if among(UNREAD, name, leaf):
                harmless(name, leaf, last)
                harmless(name, leaf, every)
                continue
            refused(ValueError, name, leaf, every, f"full of {index}")
            if leaf != "fronts.onward":  # of which the last one is read if it stands for what is left of a child
                refused(ValueError, name, leaf, last, f"with {index}")


@pytest.mark.parametrize("name", CALLS)
def test_what_is_no_number_harms_nothing(name: str) -> None:
    for leaf, array in arrays(name):
        if array.dtype == np.float64:
            for number in (np.nan, np.inf, -1e300):
                last = array.copy()
                last.flat[-1] = number
                harmless(name, leaf, last)
                harmless(name, leaf, np.full_like(array, number))
    for argument, value in CALLS[name]().items():
        for leaf, part in leaves(value, argument):
            if type(part) is float:
                for number in (np.nan, np.inf, -np.inf):
                    harmless(name, leaf, number)
            elif type(part) is int:
                for number in (-1, -(2**62), 10**6):
                    harmless(name, leaf, number)


def test_a_front_is_taken_once_and_where_it_is_kept() -> None:
    first = np.array([0, 1, 2, 2])  # bodies of three fronts: what is left of the first goes to the second
    known = bricks().model
    one = {
        "first": first, "body": np.arange(2), "owned": np.array([1, 1, 0]), "onward": np.zeros(2, int),
        "begin": np.array([0, 0, 1, 3]), "child": np.array([0, 0, 1]), "since": np.zeros(4, int),
        "sheet": np.zeros(0, int), "at_a": np.zeros(0, int), "at_b": np.zeros(0, int),
    }  # fmt: skip
    fits = EliminationFronts(**one | {"begin": np.array([0, 0, 1, 2]), "child": np.array([0, 1])})
    core.Work(known, fits)
    with pytest.raises(ValueError, match="where it was kept"):
        core.Work(known, EliminationFronts(**one))


def test_panels_of_more_rows_than_the_front_are_refused() -> None:
    with pytest.raises(ValueError, match="a panel for the front"):
        core.finish(np.ones((1, 10)), np.ones((5, 1)), np.ones((5, 5)), 5)


@pytest.mark.skipif("asan" in os.environ.get("LD_PRELOAD", ""), reason="the sanitizer ends the process instead")
@pytest.mark.parametrize("count", [2**45, 2**62])
def test_more_memory_than_there_is(count: int) -> None:
    nothing = np.zeros(0)
    asked = [
        lambda: core.regions_of(np.zeros((0, 2), int), nothing, 0.1, count),
        lambda: core.arc_capacities(
            np.zeros((0, 3)), np.zeros((0, 3, 3)), nothing, np.zeros(0, int), count, np.ones(3)
        ),
    ]
    for one in asked:
        with pytest.raises(MemoryError if count == 2**45 else (MemoryError, ValueError)):
            one()
