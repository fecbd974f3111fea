"""A scene and what is asked of it, as they travel to a worker: no module of the library is imported for them."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from holdfast.scene.scene import Scene


@dataclass(frozen=True)
class Push:
    """A push: at ``point`` [m] of ``body`` along ``direction``, in the world. ``scene`` is empty if it is for all."""

    scene: str
    body: str
    point: tuple[float, float, float]
    direction: tuple[float, float, float]


@dataclass(frozen=True)
class Question:
    """What is asked of every scene.

    ``verbs`` are those of "stability", "map", "transport" and "push" that are asked. ``options`` maps "load",
    "assemble" and verbs to the keyword arguments of the functions behind them. ``pushes`` are those of a file.
    """

    verbs: tuple[str, ...]
    options: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    pushes: tuple[Push, ...] = ()

    def of(self, verb: str) -> dict[str, Any]:
        """Return the keyword arguments of a verb, of "load" or of "assemble"."""
        return dict(self.options.get(verb, {}))

    @cached_property
    def text(self) -> str:
        """The question as a text, which is the same for equal questions; without the pushes."""
        return json.dumps({"ask": self.verbs, "options": self.options}, sort_keys=True, allow_nan=False)

    @cached_property
    def _pushes_by_scene(self) -> dict[str, tuple[Push, ...]]:
        found: dict[str, list[Push]] = {}
        for push in self.pushes:
            found.setdefault(push.scene, []).append(push)
        return {name: tuple(pushes) for name, pushes in found.items()}

    def pushes_on(self, name: str) -> tuple[Push, ...]:
        """Return the pushes that the scene with this name is asked: those for all, and its own."""
        return tuple(push for key in dict.fromkeys(("", name)) for push in self._pushes_by_scene.get(key, ()))


@dataclass(frozen=True)
class Job:
    """One scene to ask: its ``number`` and ``name``, and where it is: a file or a value.

    ``path`` is as it was given; ``place`` is the absolute path. The ``key`` of a value is known beforehand, that of a
    file when it has been read.
    """

    number: int
    name: str
    question: Question
    pushes: tuple[Push, ...] = ()
    path: str | None = None
    place: str = ""
    scene: Scene | None = None
    key: str = ""
