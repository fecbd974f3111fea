"""Pictures of examples that save none: the bodies that they asked about, and what moves there."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, Final

import numpy as np

import holdfast as hf
from holdfast.drawing.render import thumbnail
from holdfast.report.map_picture import solids_of

SIZE: Final = (640, 480)  # [px]


def bodies_and_movers(values: Mapping[str, Any]) -> tuple[bytes, frozenset[str]] | None:
    """Draw the scene that an example made last, as a PNG, and tell which bodies move in the last answer about it.

    None for an example that made none, as one does whose optional package is missing.
    """
    scenes = [value for value in values.values() if isinstance(value, hf.answers.Assembly | hf.Scene)]
    if not scenes:
        return None
    made = scenes[-1]
    assembly = hf.assemble(made) if isinstance(made, hf.Scene) else made
    names = {body.name for body in assembly.movable}
    found = [movers(value) & names for value in values.values()]
    moving = next((each for each in reversed(found) if each), frozenset())
    return thumbnail(solids_of(assembly.bodies), assembly.scene.up, moving, SIZE), moving


def movers(answer: Any) -> frozenset[str]:  # noqa: ANN401 - any value of an example
    """Return the names of the bodies that move in an answer, of several rows in the weakest; none of other values."""
    if isinstance(answer, hf.answers.Stability):
        return frozenset(() if answer.mechanism is None else answer.mechanism.moving)
    moving: Iterable[Any] = getattr(answer, "moving", ())
    if isinstance(moving, np.ndarray):
        return frozenset(moving[int(answer.answers.ranking[0])]) if hasattr(answer, "answers") else frozenset()
    return frozenset(name for name in moving if isinstance(name, str))
