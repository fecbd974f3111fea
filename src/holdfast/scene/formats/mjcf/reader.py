"""Read MJCF files, ``<mujoco>``, through MuJoCo's own compiler; models of single objects are put into a world."""

from __future__ import annotations

import os
import re
import warnings
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from holdfast.base.arrays import Float, checked, checked_items, checked_truth
from holdfast.base.borders.foreign import foreign
from holdfast.base.borders.worker import is_limited
from holdfast.base.errors import HoldfastWarning, SceneError, located, message, nearest_of, warn
from holdfast.base.files import checked_path, read_ordinary
from holdfast.base.rigid import quaternion_of
from holdfast.base.text import listed, one_line, quoted
from holdfast.scene.excluded import body_of
from holdfast.scene.formats.joints import Torques, check_within
from holdfast.scene.formats.links import FLOOR, copies_of
from holdfast.scene.formats.mjcf.live import from_mujoco
from holdfast.scene.formats.mjcf.mjcf_guard import MOST_BYTES, ROOT, UNUSED, files_of, parsed, read_apart
from holdfast.scene.formats.mjcf.rules import entries
from holdfast.scene.formats.mjcf.writer import write
from holdfast.scene.formats.registry import Format
from holdfast.scene.formats.source import Source
from holdfast.scene.hold import renamed_hold
from holdfast.scene.scene import Scene
from holdfast.scene.xml import root_name

# what MuJoCo makes of a few words; the guard bounds it by what it knows, and a process of its own by what it does
MAKES = re.compile(r"<(flexcomp|composite|plugin)\b|\bbuiltin\s*=\s*[\"'](?!none|gradient|checker|flat)")
UNNAMED = ("", "MuJoCo Model")  # names of models that MuJoCo gives to those without
UNSAVED = "Attaching a spec with an empty prefix"  # a warning about saving a model, which is never done here
ALL = 2**31 - 1  # contype and conaffinity of the floor: it touches whatever touches anything
LAST = -1_000  # priority of the floor, below all others: the friction of a contact is that of what lies on it


def sniff(source: Source) -> bool:
    """Tell whether the first element of the file is ``<mujoco>``."""
    return source.head.lstrip(b"\xef\xbb\xbf \t\r\n").startswith(b"<") and root_name(source.text) == ROOT


def read(
    source: Source,
    *,
    key: str | int | None = None,
    qpos: ArrayLike | None = None,
    rigid: bool = False,
    hold_torques: Torques = False,
    free: bool | Collection[str] = False,
    pose: ArrayLike | None = None,
    poses: Mapping[str, ArrayLike] | None = None,
    floor: bool = False,
    within: str | os.PathLike[str] | None = None,
) -> Scene:
    """Return the scene at the model's initial positions, at those of the keyframe ``key``, or at ``qpos`` (nq,).

    ``rigid`` and ``hold_torques`` are as in ``from_mujoco``. ``free`` gives a free joint to each body of the world that
    has no joint, or to those in which the named bodies are, as models of single objects need it; their keyframes are
    then dropped. ``pose`` (4, 4) is that of the whole model in the world; ``poses`` gives several copies of it instead,
    each with a name and a pose. ``floor`` adds the half space below z = 0, with the friction of whatever lies on it.

    The files to which the model refers must be in its own folder, or in the folder ``within``. Raises SceneError with
    MuJoCo's message for a model that MuJoCo refuses.
    """
    options = {name: value for name, value in locals().items() if name != "source"}
    model_options = {name: value for name, value in options.items() if name not in ("key", "qpos", "within")}
    files = files_named(source, within)
    if to_be_read_apart(source, files):
        return read_apart(read, source, options)
    return CompiledModel(source, files, **model_options).scene(key, qpos)


def files_named(source: Source, within: str | os.PathLike[str] | None) -> list[Path]:
    """Return the files that a model names; raise SceneError if one is missing, outside of ``within`` or hostile."""
    path = source.path
    folder = path.parent if within is None else checked_path(within, "within")
    if parsed(source.text, str(path)).tag != ROOT:
        raise SceneError(message(str(path), "its root is not <mujoco>", "needs an MJCF model"))
    return files_of(source.text, path, folder)


def to_be_read_apart(source: Source, files: Sequence[Path]) -> bool:
    """Tell whether a model needs a process of its own, as MuJoCo makes much of a few words; a worker is one."""
    models = [source, *(Source(each) for each in files if each.suffix.lower() == ".xml")]
    return not is_limited() and any(MAKES.search(each.text) for each in models)


class CompiledModel:
    """A model that MuJoCo has compiled, whose scene in any state is made without reading its files again.

    ``files`` are those that it names. Its options are those of ``read``, without key and qpos, and ``within``, which
    ``files_named`` takes. ``model`` is the mujoco.MjModel, ``data`` the mujoco.MjData of the last scene.
    """

    def __init__(
        self,
        source: Source,
        files: list[Path],
        *,
        rigid: bool = False,
        hold_torques: Torques = False,
        free: bool | Collection[str] = False,
        pose: ArrayLike | None = None,
        poses: Mapping[str, ArrayLike] | None = None,
        floor: bool = False,
    ) -> None:
        self.path = source.path
        self._options: dict[str, Any] = {"rigid": rigid, "hold_torques": hold_torques}
        self._mujoco = mujoco = import_module("mujoco")
        where = str(self.path)
        with _warnings(mujoco) as self._heard, foreign(where, "MuJoCo refuses it", "correct the model"):
            spec = _spec_of(mujoco, source, files)
            with located(where):
                unseen = _weighing_unseen(spec)
                spec, notes, self.renamed = placed(mujoco, spec, free, pose, poses, floor)
            self.model = spec.compile()
            self.data = mujoco.MjData(self.model)
        self._notes = (*notes, *unseen)

    def scene(self, key: str | int | None = None, qpos: ArrayLike | None = None) -> Scene:
        """Return the scene at the model's initial positions, at those of the keyframe ``key``, or at ``qpos`` (nq,)."""
        mujoco, model, data, where = self._mujoco, self.model, self.data, str(self.path)
        with _warnings(mujoco) as heard:
            with foreign(where, "MuJoCo refuses it", "correct the model"):
                mujoco.mj_resetData(model, data)
                with located(where):
                    _pose(mujoco, model, data, key, qpos)
                mujoco.mj_forward(model, data)
            with located(where):
                name = bytes(model.names).split(b"\0", 1)[0].decode(errors="replace")
                name = self.path.stem if name in UNNAMED else name
                scene = renamed(from_mujoco(model, data, name=name, **self._options), self.renamed)
        warned = (f"MuJoCo warns: {text}" for text in dict.fromkeys((*self._heard, *heard)))
        return replace(scene, notes=(*self._notes, *scene.notes, *warned))


@contextmanager
def _warnings(mujoco: Any) -> Iterator[list[str]]:  # noqa: ANN401 - MuJoCo has no types
    """Collect the warnings that MuJoCo would write to a file in the current folder, and those of its compiler."""
    heard: list[str] = []
    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(lambda text: heard.append(one_line(text)))
    try:
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            yield heard
            heard += [one_line(str(each.message)) for each in caught if not isinstance(each.message, HoldfastWarning)]
            heard[:] = [text for text in heard if UNSAVED not in text]
    finally:
        mujoco.set_mju_user_warning(before)
    for each in caught:
        if isinstance(each.message, HoldfastWarning):
            warn(str(each.message))


def _spec_of(mujoco: Any, source: Source, files: list[Path]) -> Any:  # noqa: ANN401 - MuJoCo has no types
    """Return the model as MuJoCo parses it; if it is not a file, MuJoCo gets the content of the files that it names.

    What only looks or measures is taken out, so that its files need not be there. The memory that a file requests does
    not count, because MuJoCo finds contacts here and solves nothing.
    """
    if source.given is None:
        spec = mujoco.MjSpec.from_file(str(source.path))
    else:
        named = {place.name: read_ordinary(place, "file of a model", most=MOST_BYTES) for place in files}
        spec = mujoco.MjSpec.from_string(source.text, named, named)
    if spec.modelname in UNNAMED:
        spec.modelname = source.path.stem
    for room in UNUSED:
        try:
            setattr(spec, room, -1)
        except TypeError:  # unsigned in older versions
            setattr(spec, room, 2**64 - 1)
    spec.memory = MOST_BYTES  # whatever the file says: enough for thousands of geoms, and none of it is used in advance
    for coloured in (*spec.geoms, *spec.sites, *spec.tendons, *spec.flexes):
        coloured.material = ""
    for each in (*spec.tuples, *spec.sensors, *spec.skins, *spec.materials, *spec.textures):
        spec.delete(each)
    return spec


def _weighing_unseen(spec: Any) -> list[str]:  # noqa: ANN401
    """Return a note on geoms that touch nothing and give their body mass, as twins that only look do by mistake."""
    low, high = spec.compiler.inertiagrouprange
    pairs = {name for pair in spec.pairs for name in (pair.geomname1, pair.geomname2)}
    found = [
        geom
        for geom in spec.geoms
        if not (geom.contype or geom.conaffinity or geom.name in pairs or geom.parent.explicitinertial)
        and low <= geom.group <= high
        and (geom.density > 0 if np.isnan(geom.mass) else geom.mass > 0)
    ]
    bodies = dict.fromkeys(geom.parent.name or "a body without name" for geom in found if geom.parent.name != "world")
    if not bodies:
        return []
    return [f"geoms that touch nothing give mass to {listed(bodies)}, as in MuJoCo: mass 0 if they only look"]


def _pose(mujoco: Any, model: Any, data: Any, key: str | int | None, qpos: ArrayLike | None) -> None:  # noqa: ANN401
    """Set the requested positions."""
    if key is not None and qpos is not None:
        raise SceneError(message("key and qpos", "are both given", "give one of them"))
    if key is not None:
        mujoco.mj_resetDataKeyframe(model, data, _number(model, key))
    if qpos is not None:
        data.qpos[:] = checked(np.asarray(qpos, dtype=object).tolist(), (int(model.nq),), "qpos")
        names = entries(model, "jnt", int(model.njnt))
        turning, sliding = int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_SLIDE)
        for j in range(int(model.njnt)):
            if model.jnt_limited[j] and model.jnt_type[j] in (turning, sliding):
                low, high = (float(end) for end in model.jnt_range[j])
                where, position = f"qpos: joint {quoted(names[j] or j)}", float(data.qpos[model.jnt_qposadr[j]])
                check_within(where, position, low, high, turning=model.jnt_type[j] == turning)


def _number(model: Any, key: str | int) -> int:  # noqa: ANN401
    """Return the number of a keyframe that is given by its name or its number."""
    known: Sequence[str] = entries(model, "key", int(model.nkey))
    if isinstance(key, str):
        if key not in known:
            remedy = nearest_of(key, filter(None, known)) if any(known) else "the model has no keyframe with a name"
            raise SceneError(message(f"keyframe {quoted(key)}", "is unknown", remedy))
        return known.index(key)
    if isinstance(key, bool) or not isinstance(key, int) or not 0 <= key < len(known):
        problem = f"the model has {len(known)} keyframes"
        raise SceneError(message(f"keyframe {quoted(key)}", problem, "needs a name, or a number from 0"))
    return key


MJCF = Format("MJCF", (".xml",), sniff, read, write, mark="`<mujoco>`", extra="mujoco")


def placed(
    mujoco: Any,  # noqa: ANN401 - MuJoCo has no types
    spec: Any,  # noqa: ANN401
    free: bool | Collection[str],
    pose: ArrayLike | None,
    poses: Mapping[str, ArrayLike] | None,
    floor: bool,
) -> tuple[Any, list[str], dict[str, str]]:
    """Return the model with what the options ``free``, ``pose``, ``poses`` and ``floor`` of the reader ask for.

    Also returns notes, and the new name of each body that stands for a whole copy.
    """
    notes = _freed(spec, free)
    single: dict[str, str] = {}
    if pose is not None or poses is not None:
        copies = copies_of("", pose, poses)
        top = list(spec.worldbody.bodies)
        if len(top) == 1 and not list(spec.worldbody.geoms):
            single = {f"{copy}/{top[0].name}": copy for copy, _ in copies if copy}
        spec = _copied(mujoco, spec, copies)
    if checked_truth(floor, "floor"):
        if any(geom.name == FLOOR for geom in spec.geoms):
            raise SceneError(message("floor", "the model has a geom of this name", "leave floor= out"))
        plane = mujoco.mjtGeom.mjGEOM_PLANE
        numbers = {"contype": ALL, "conaffinity": ALL, "priority": LAST, "condim": 1}
        spec.worldbody.add_geom(name=FLOOR, type=plane, size=[1, 1, 1], friction=[0, 0, 0], **numbers)
    return spec, notes, single


def _freed(spec: Any, free: bool | Collection[str]) -> list[str]:  # noqa: ANN401
    """Give free joints to bodies of the world; return a note on them."""
    top = list(spec.worldbody.bodies)
    if isinstance(free, bool):
        chosen = [body for body in top if not list(body.joints)] if free else []
    else:
        chosen = [_on_world(spec, name) for name in checked_items(free, "free", 'names, as ["mug"]')]
    if not chosen:
        return []
    names = {body.name for body in spec.bodies}
    done = []
    for number, body in enumerate(chosen, 1):
        if not body.name:
            usual = spec.modelname if len(top) == 1 and spec.modelname not in names else ""
            body.name = usual or f"body {number}"
        kinds = [joint.type for joint in body.joints]
        if not kinds:
            body.add_freejoint()
            done.append(body.name)
        elif not any(kind.name == "mjJNT_FREE" for kind in kinds):
            problem = f"body {quoted(body.name)} has joints of its own"
            raise SceneError(message("free", problem, "name bodies without joints"))
    if done:
        for key in list(spec.keys):  # positions of the model as it was
            spec.delete(key)
    return [f"free, as free= says: {listed(done)}"] if done else []


def _on_world(spec: Any, name: Any) -> Any:  # noqa: ANN401
    """Return the body of the world in which the body with this name is."""
    body = spec.body(name) if isinstance(name, str) else None
    if body is None or body is spec.worldbody or name == "world":
        known = [each.name for each in spec.bodies if each.name not in ("", "world")]
        raise SceneError(message("free", f"no body is named {quoted(name)}", nearest_of(str(name), known)))
    while body.parent.name != "world":
        body = body.parent
    return body


def _copied(mujoco: Any, spec: Any, copies: list[tuple[str, Float]]) -> Any:  # noqa: ANN401
    """Return a world with copies of a model, whose names begin with that of the copy."""
    whole = mujoco.MjSpec()
    whole.modelname = spec.modelname
    for option in (each for each in dir(spec.option) if not each.startswith("_")):
        setattr(whole.option, option, getattr(spec.option, option))
    for copy, pose in copies:
        frame = whole.worldbody.add_frame(pos=pose[:3, 3], quat=quaternion_of(pose[:3, :3]))
        whole.attach(spec.copy(), prefix=f"{copy}/" if copy else "", frame=frame)
    return whole


def renamed(scene: Scene, names: Mapping[str, str]) -> Scene:
    """Return the scene with other names for some of its bodies."""
    if not names:
        return scene

    def end_of(end: Any) -> Any:  # noqa: ANN401 - a body, or a body and the number of a part
        name = names.get(body_of(end), body_of(end))
        return name if isinstance(end, str) else (name, end[1])

    bodies = tuple(replace(body, name=names.get(body.name, body.name)) for body in scene.bodies)
    holds = tuple(renamed_hold(hold, names) for hold in scene.holds)
    pairs = tuple((end_of(a), end_of(b)) for a, b in scene.excluded)
    return replace(scene, bodies=bodies, excluded=pairs, holds=holds)
