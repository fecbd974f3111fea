"""The data about bodies in a glTF file that holdfast wrote, as far as they still match the file."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from holdfast.base.text import listed
from holdfast.scene.compound import Compound
from holdfast.scene.excluded import Excluded, excluded_among
from holdfast.scene.formats.friction_entries import friction_of
from holdfast.scene.formats.gltf.extras import BodyWords, SceneWords, body_words, checksum, known_of, scene_words
from holdfast.scene.formats.named_meshes import Known, Weight, split
from holdfast.scene.friction import STRENGTHS, Friction
from holdfast.scene.meshes.by_trimesh import Node
from holdfast.scene.scene import Scene


@dataclass(frozen=True)
class Inside:
    """The data of the scene and of each node about its body; empty if another program wrote the file."""

    scene: SceneWords | None
    bodies: Mapping[str, BodyWords]

    @classmethod
    def of(cls, nodes: Sequence[Node], extras: Any, path: Path) -> Inside:  # noqa: ANN401 - plain data
        """Return the data in the file at ``path``; raise SceneError if they are malformed."""
        found = {node.name: body_words(node, path) for node in nodes}
        return cls(scene_words(extras, path), {name: words for name, words in found.items() if words is not None})

    def weight(self, name: str) -> Weight:
        """Return the mass [kg] and the density [kg/m³] of a body, None if not given."""
        words = self.bodies.get(name)
        return (None, None) if words is None else (words.mass, words.density)

    @cached_property
    def fixed(self) -> frozenset[str]:
        """The names of the bodies that are fixed."""
        return frozenset(name for name, words in self.bodies.items() if words.fixed)

    @property
    def materials(self) -> dict[str, str]:
        """The materials of bodies that have one."""
        return {name: words.material for name, words in self.bodies.items() if words.material is not None}

    def known(self, nodes: Sequence[Node], weights: Mapping[str, Weight], notes: list[str]) -> dict[str, Known]:
        """Return the shapes, centres of mass and inertias of bodies whose meshes are unchanged.

        The inertia belongs to the written mass, so it is left out for a body with another mass in ``weights``.
        """
        found, edited = {}, []
        for node in nodes:
            words = self.bodies.get(node.name)
            if words is None:
                continue
            if not _as_written(node, words):
                edited.append(node.name)
                continue
            known = known_of(words, node.name)
            same = weights[node.name] == self.weight(node.name)
            found[node.name] = known if same else known._replace(inertia=None)
        if edited:
            about = "their shapes, centres of mass and inertias are those of their meshes"
            notes.append(f"meshes are not those that holdfast wrote, so {about}: {listed(edited)}")
        return found

    def friction(self, names: Collection[str], notes: list[str]) -> Friction | None:
        """Return the friction table without pairs of bodies and materials that do not exist any more."""
        if self.scene is None:
            return None
        whole = friction_of(self.scene.friction)
        table = whole.among(names)
        lost = sum(len(getattr(whole, name)) - len(getattr(table, name)) for name in ("pairs", "values", *STRENGTHS))
        if lost:
            notes.append(f"{lost} entries of the friction table are left out: they name what is not in the file")
        return table

    def limited(self, scene: Scene) -> Scene:
        """Return the scene with what its bodies may bear."""
        if all((words.top_load, words.pressure) == (None, None) for words in self.bodies.values()):
            return scene
        bodies = []
        for body in scene.bodies:
            words = self.bodies.get(body.name)
            bodies.append(body if words is None else replace(body, top_load=words.top_load, pressure=words.pressure))
        return replace(scene, bodies=tuple(bodies))

    def excluded(self, names: Collection[str], known: Mapping[str, Known], notes: list[str]) -> list[Excluded]:
        """Return the excluded pairs of which both bodies, or parts of compounds, still exist."""
        pairs = [] if self.scene is None else self.scene.excluded
        compounds = {name for name, each in known.items() if isinstance(each.shape, Compound)}
        kept = [
            pair
            for pair in excluded_among(pairs, names)
            if all(isinstance(end, str) or end[0] in compounds for end in pair)
        ]
        if len(kept) < len(pairs):
            notes.append(f"{len(pairs) - len(kept)} excluded pairs are left out: they name what is not in the file")
        return kept


def materials_of_parts(known: Mapping[str, Known]) -> set[str]:
    """Return the materials of parts of compounds."""
    shapes = [each.shape for each in known.values()]
    parts = [part for shape in shapes if isinstance(shape, Compound) for part in shape.parts]
    return {part.material for part in parts if part.material is not None}


def _as_written(node: Node, words: BodyWords) -> bool:
    """Tell whether a node has the mesh that was written, without a scale."""
    _, stretch = split(node.matrix, f"node {node.name}")
    return np.array_equal(stretch, np.eye(3)) and checksum(node.vertices, node.faces) == words.surface
