"""Many states of one MuJoCo model as the scenes of a batch: what does not move between them is prepared once."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from holdfast.assembly.assembly import Assembly, assemble
from holdfast.base.arrays import Float, checked_mapping
from holdfast.base.errors import HoldfastError, SceneError, located, message
from holdfast.base.files import checked_path, noting_files
from holdfast.base.rigid import pose_from
from holdfast.base.text import quoted
from holdfast.base.values import alike
from holdfast.batches.inputs import Input, Inputs, as_text
from holdfast.batches.job import Job, Touched, signature
from holdfast.batches.result import BatchTables
from holdfast.batches.state_files import StateRows, checked_rows, read_states, write_states
from holdfast.engines.verdict import Status
from holdfast.scene.body import Body
from holdfast.scene.formats.mjcf.reader import MJCF, CompiledModel, files_named
from holdfast.scene.formats.mjcf.state_layout import StateLayout, layout_of
from holdfast.scene.formats.registry import format_of
from holdfast.scene.formats.source import Source
from holdfast.scene.scene import Scene

OWN = ("key", "qpos", "on_floor")  # options of the reader that a state replaces, or that would move it

StatesGiven: TypeAlias = "str | os.PathLike[str] | ArrayLike"


@dataclass(frozen=True)
class ModelStates:
    """The states of a model, checked: positions begin at ``first`` in each row of ``rows.values``."""

    model: Path
    layout: StateLayout
    rows: StateRows
    first: int
    source: Path | None = None

    def inputs(self) -> Inputs:
        """Return each state as an input of a batch."""
        ends = self.first, self.first + self.layout.nq
        named = zip(self.rows.names, self.rows.values[:, slice(*ends)].tolist(), strict=True)
        found = [Input(as_text(name), str(self.model), state=tuple(state)) for name, state in named]
        return Inputs(iter(found), len(found))

    def check_target(self, path: Path) -> None:
        """Raise HoldfastError unless settled states can be written to this path; before anything is computed."""
        if self.source is None or path.suffix.lower() != self.source.suffix.lower():
            wanted = "states from a file" if self.source is None else f"a {self.source.suffix} file"
            raise HoldfastError(message(str(path), "cannot hold settled states", f"needs {wanted}"))

    def fix(self, tables: BatchTables, path: Path) -> tuple[list[str], list[str]]:
        """Write the file of states to ``path`` with the states that settle in place of those that do not stand.

        ``tables`` are those of a batch that asked for stability and settle. Returns the names of the states that were
        settled, and of those that are left as they are although they do not stand.
        """
        self.check_target(path)
        assert self.source is not None
        number = {as_text(name): k for k, name in enumerate(self.rows.names)}
        settled, left, changed = [], [], dict[str, Float]()
        bodies: dict[str, list[dict[str, Any]]] = {}
        for row in tables.rows("bodies"):
            bodies.setdefault(row["scene"], []).append(row)
        for scene in tables.rows("scenes"):
            if scene["status"] == Status.STABLE.value:
                continue
            if scene["settled"] != Status.STABLE.value:
                left.append(scene["scene"])
                continue
            k = number[scene["scene"]]
            state = np.array(self.rows.values[k])
            for body in bodies[scene["scene"]]:
                if body["moved"] is not None and (body["moved"] > 0 or body["turned_degrees"] > 0):
                    self.layout.moved(state, self.first, body["body"], pose_in(body), pose_in(body, "rest_"))
            changed[self.rows.names[k]] = state
            settled.append(scene["scene"])
        write_states(path, changed, self.source)
        return settled, left


def pose_in(row: Mapping[str, Any], prefix: str = "") -> Float:
    """Return the pose (4, 4) of a row of the table of bodies: where the body is or, with "rest_", comes to rest."""
    place, turn = ([row[f"{prefix}{name}"] for name in names] for names in (("x", "y", "z"), ("qw", "qx", "qy", "qz")))
    return np.asarray(pose_from(np.array(place), np.array(turn)))


def states_of(scenes: object, states: StatesGiven, load: Mapping[str, Any], *, every: bool = False) -> ModelStates:
    """Return the ``states`` (a file, or an array) of the only model that ``scenes`` names; all of them are checked.

    ``load`` are options of the reader, and ``every`` is that of ``read_states``. Raises HoldfastError if there are
    several scenes or if it is no MuJoCo model, and for states that do not fit it.
    """
    named = list(scenes) if isinstance(scenes, list | tuple) else [scenes]
    path = named[0][1] if len(named) == 1 and isinstance(named[0], tuple) and len(named[0]) == 2 else named[0]
    if len(named) != 1 or not isinstance(path, str | os.PathLike):
        raise HoldfastError(message("states", f"got {len(named)} scenes", "needs the path of one MuJoCo model"))
    model = checked_path(path, "model")
    for name in OWN:
        if name in checked_mapping(load, "options: load", '{"rigid": True}'):
            raise HoldfastError(message("states", f"load has {quoted(name)}", "leave it out: each state has its own"))
    with located(str(model)):
        source = Source(model)
        chosen = format_of(source)
        if chosen.name != MJCF.name:
            raise SceneError(message("states", f"it is {chosen.name}", "needs a MuJoCo model (MJCF)"))
        chosen.check_options(load)
        layout = layout_of(source, **load)
    if isinstance(states, str | os.PathLike):
        file = checked_path(states, "file of states")
        rows, where = read_states(file, every=every), str(file)
        return ModelStates(model, layout, rows, layout.first(rows.values, where), file)
    try:
        values = checked_rows(states, "states")
    except ValueError as cause:  # rows of several lengths
        raise HoldfastError(message("states", f"is no table: {cause}", "needs a row of numbers each")) from cause
    rows = StateRows(tuple(map(str, range(len(values)))), values)
    return ModelStates(model, layout, rows, layout.first(values, "states"))


class StateScenes:
    """The scenes of the states of one model and their assemblies, for one worker.

    The model is compiled once, and its bodies are prepared for the search of contacts once.
    """

    def __init__(self, job: Job) -> None:
        load = job.question.of("load")
        self.about = about(job)
        touched, within = Touched(), load.pop("within", None)
        with noting_files(touched.note), located(job.place):
            source = Source(Path(job.place))
            self._known = CompiledModel(source, files_named(source, within), **load)
        self.touched = touched
        self._first: Assembly | None = None

    def scene(self, job: Job) -> Scene:
        """Return the scene in the state of a job, as ``load_scene`` with this qpos does."""
        with located(job.place):
            return self._known.scene(qpos=job.state)

    def assembly(self, scene: Scene, options: Mapping[str, Any]) -> Assembly:
        """Return ``assemble(scene, **options)``, from what was prepared for the first scene."""
        first = self._first
        poses = None if first is None else other_poses(first.scene, scene)
        if first is not None and poses is not None:
            return first.at(poses, scene.notes, allow_large=bool(options.get("allow_large", False)))
        found = assemble(scene, **options)
        self._first = self._first or found
        return found

    @property
    def unchanged(self) -> bool:
        """Whether no file of the model has changed since it was read."""
        return all(signature(path) == before for path, before in self.touched.before.items())


def about(job: Job) -> tuple[str, str]:
    """Return what decides the scenes of a job but for its state: the model, and the options."""
    options = [job.question.of(name) for name in ("load", "assemble")]
    return job.place, json.dumps(options, sort_keys=True)


_latest: list[StateScenes] = []  # one at most: a batch has one model


def scenes_of(job: Job) -> StateScenes:
    """Return the scenes of the model of a job, the same ones while its files stay as they are."""
    if not _latest or _latest[0].about != about(job) or not _latest[0].unchanged:
        _latest[:] = [StateScenes(job)]
    return _latest[0]


def other_poses(first: Scene, scene: Scene) -> dict[str, Float] | None:
    """Return the poses of the bodies that are elsewhere in ``scene``; None if more differs or holds are there."""
    if first.holds or scene.holds or len(first.bodies) != len(scene.bodies):
        return None
    same = alike(first.friction, scene.friction) and alike(first.gravity, scene.gravity)
    if not same or first.excluded != scene.excluded or first.name != scene.name:
        return None
    if not all(_alike(old, new) for old, new in zip(first.bodies, scene.bodies, strict=True)):
        return None
    pairs = zip(first.bodies, scene.bodies, strict=True)
    return {old.name: new.pose for old, new in pairs if not np.array_equal(old.pose, new.pose)}


def _alike(old: Body, new: Body) -> bool:
    """Tell whether two bodies differ in their poses alone."""
    same_shape = old.shape is new.shape or alike(old.shape, new.shape)
    names = ("name", "fixed", "mass", "density", "material", "com", "inertia", "top_load", "pressure")
    return same_shape and all(alike(getattr(old, name, None), getattr(new, name, None)) for name in names)
