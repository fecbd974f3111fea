"""Models of single objects, put into a world: free joints, copies at poses, and a floor."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from holdfast.base.arrays import Float, checked_items, checked_truth
from holdfast.base.errors import SceneError, message, nearest_of
from holdfast.base.text import listed, quoted
from holdfast.scene.excluded import body_of
from holdfast.scene.formats.floor import FLOOR
from holdfast.scene.formats.rigid_parts import copies_of
from holdfast.scene.hold import renamed_hold
from holdfast.scene.scene import Scene

ALL = 2**31 - 1  # contype and conaffinity of the floor: it touches whatever touches anything
LAST = -1_000  # priority of the floor, below all others: the friction of a contact is that of what lies on it


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
        x, y, z, w = Rotation.from_matrix(pose[:3, :3]).as_quat()
        frame = whole.worldbody.add_frame(pos=pose[:3, 3], quat=np.array([w, x, y, z]))
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
