"""Results whose answers are changed by hand, so that all kinds of answers stand side by side."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

import holdfast as hf
from holdfast.scene.shipped.blocks import at

REASON = "orange: undecided: nothing is known of a ball"


def retold(result: Any, rows: Any, status: hf.Status, *, force: float = 0.0, notes: tuple[str, ...] = ()) -> Any:
    """The result with this status and force in the rows, and with further notes."""
    answers = result.answers
    columns = {name: getattr(answers, name).copy() for name in ("status", "force", "lower", "upper")}
    columns["status"][rows] = status
    columns["force"][rows] = force
    columns["lower"][rows] = np.minimum(columns["lower"][rows], force)
    columns["upper"][rows] = np.maximum(columns["upper"][rows], force)
    return replace(result, answers=replace(answers, **columns, notes=(*answers.notes, *notes)))


def unknown(result: Any) -> Any:
    """The result with nothing decided."""
    return retold(result, slice(None), hf.Status.UNDECIDED, notes=(REASON,))


def shelf(*more: hf.Body) -> hf.Scene:
    """The shelf of the README, with more bodies on it."""
    bodies = [
        hf.Body("shelf", hf.Box((0.6, 0.3, 0.02)), pose=at(0, 0, -0.01), material="oak", fixed=True),
        hf.Body("book", hf.Box((0.15, 0.21, 0.03)), mass=0.7, pose=at(-0.1, 0, 0.015)),
        hf.Body("vase", hf.Cylinder(0.03, 0.2), mass=0.4, pose=at(0.1, 0, 0.1), material="glass"),
        hf.Body("cup", hf.Cylinder(0.035, 0.09), mass=0.25, pose=at(-0.13, 0.05, 0.075)),
    ]
    friction = hf.Friction(default=0.5, pairs={("glass", "oak"): 0.3})
    return hf.Scene([*bodies, *more], friction, name="shelf")


def orange() -> hf.Body:
    """A ball that lies on the shelf."""
    return hf.Body("orange", hf.Sphere(0.04), mass=0.2, pose=at(0.22, 0.02, 0.04))
