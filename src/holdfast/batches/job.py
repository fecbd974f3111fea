"""A scene and the question about it, as they are sent to a worker, without importing the rest of the library."""

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
    """A push at ``point`` [m] of ``body`` along ``direction``, world frame; ``scene`` is "" if it is for all scenes."""

    scene: str
    body: str
    point: tuple[float, float, float]
    direction: tuple[float, float, float]


@dataclass(frozen=True)
class Question:
    """The question of a batch.

    ``verbs`` are some of "stability", "map", "transport" and "push". ``options`` maps "load", "assemble" and verbs to
    keyword arguments of the functions that they call. ``pushes`` are the pushes for the verb "push".
    """

    verbs: tuple[str, ...]
    options: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    pushes: tuple[Push, ...] = ()

    def of(self, verb: str) -> dict[str, Any]:
        """Return the keyword arguments of a verb, of "load" or of "assemble"."""
        return dict(self.options.get(verb, {}))

    @cached_property
    def text(self) -> str:
        """The question as text, without the pushes; it is the same for equal questions."""
        return json.dumps({"ask": self.verbs, "options": self.options}, sort_keys=True, allow_nan=False)

    @cached_property
    def _pushes_by_scene(self) -> dict[str, tuple[Push, ...]]:
        found: dict[str, list[Push]] = {}
        for push in self.pushes:
            found.setdefault(push.scene, []).append(push)
        return {name: tuple(pushes) for name, pushes in found.items()}

    def pushes_on(self, name: str) -> tuple[Push, ...]:
        """Return the pushes for the scene with this name: those for all scenes, and its own."""
        return tuple(push for key in dict.fromkeys(("", name)) for push in self._pushes_by_scene.get(key, ()))


@dataclass(frozen=True)
class Job:
    """One scene of a batch: its ``number`` and ``name``, the question, and the scene as a file or a value.

    ``path`` is the path as it was given, ``place`` the absolute path. The ``key`` of a value is known beforehand, that
    of a file once it has been read.
    """

    number: int
    name: str
    question: Question
    pushes: tuple[Push, ...] = ()
    path: str | None = None
    place: str = ""
    scene: Scene | None = None
    key: str = ""
