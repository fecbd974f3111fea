"""The directives of a .dmd.yaml file and of the files that it adds, as flat lists with full names."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, NoReturn

import numpy as np
from scipy.spatial.transform import Rotation

from holdfast.base.arrays import Float, checked, checked_number
from holdfast.base.borders.foreign import YAML, spend
from holdfast.base.errors import SceneError, message, nearest_of
from holdfast.base.files import check_ordinary
from holdfast.base.ranges import PLACE
from holdfast.base.text import quoted
from holdfast.scene.formats import plain_data
from holdfast.scene.formats.links import not_read, pose_of
from holdfast.scene.formats.references import References
from holdfast.scene.formats.source import Source

WORLD = "world"
MOST_FILES = 1_000  # largest number of files of directives that a scene may add
# the keys of each directive
KEYS = {
    "add_model": ("name", "file", "default_joint_positions", "default_free_body_pose"),
    "add_model_instance": ("name",),
    "add_frame": ("name", "X_PF"),
    "add_weld": ("parent", "child", "X_PC"),
    "add_collision_filter_group": (
        "name", "model_namespace", "members", "member_groups", "ignored_collision_filter_groups",
    ),
    "add_directives": ("file", "model_namespace"),
}  # fmt: skip
POSE_KEYS = ("base_frame", "translation", "rotation")


@dataclass(frozen=True)
class Directive:
    """One directive: its ``kind``, its keys and values, the namespace in which its names are, and its place."""

    kind: str
    values: Mapping[str, Any]
    namespace: str
    where: str
    references: References

    def fail(self, problem: str, remedy: str) -> NoReturn:
        """Raise SceneError about this directive."""
        raise SceneError(message(self.where, problem, remedy))

    def text(self, key: str) -> str:
        """Return a text; raises SceneError if it is missing."""
        value = self.values.get(key)
        return value if isinstance(value, str) and value else self.fail(f"{key} is {quoted(value)}", "needs a text")

    def names(self, key: str) -> list[str]:
        """Return a list of texts, by default empty."""
        value = self.values.get(key) or []
        if not isinstance(value, list) or not all(isinstance(each, str) for each in value):
            self.fail(f"{key} is {quoted(value, 60)}", "needs a list of names")
        return value

    def map(self, key: str) -> dict[str, Any]:
        """Return a mapping, by default empty."""
        value = self.values.get(key) or {}
        return value if isinstance(value, dict) else self.fail(f"{key} is {quoted(value, 60)}", "needs keys and values")

    def within(self, name: str) -> str:
        """Return the full name of something that this directive names."""
        return name if name == WORLD or not self.namespace else f"{self.namespace}::{name}"

    def transform(self, value: Any, key: str) -> tuple[str | None, Float]:  # noqa: ANN401 - plain data
        """Return the name of the base frame, if there is one, and the pose (4, 4) of a transform."""
        if not isinstance(value, dict):
            self.fail(f"{key} is {quoted(value, 60)}", "needs base_frame, translation, rotation")
        self.check(value, POSE_KEYS, key)
        base = value.get("base_frame")
        if base is not None and not isinstance(base, str):
            self.fail(f"{key}: base_frame is {quoted(base)}", "needs the name of a frame")
        where = f"{self.where}: {key}"
        given = self._plain(value.get("translation", [0, 0, 0]), f"{key}: translation")
        pose = np.eye(4)
        pose[:3, :3] = self._rotation(value.get("rotation") or {}, key)
        pose[:3, 3] = checked(given, (3,), f"{where}: translation", within=PLACE)
        return base, pose

    def _plain(self, value: Any, what: str) -> Any:  # noqa: ANN401 - plain data
        tag = next(iter(value), "") if isinstance(value, dict) else ""
        if tag.startswith("!"):
            self.fail(f"{what} is drawn at random ({tag})", "write the value out")
        return value

    def _rotation(self, value: Any, key: str) -> Float:  # noqa: ANN401 - plain data
        where = f"{self.where}: {key}: rotation"
        match value:
            case {"!Rpy": {"deg": deg, **rest}} if not rest:
                angles = checked(self._plain(deg, f"{key}: deg"), (3,), where)
                return pose_of((0, 0, 0), np.radians(angles).tolist())[:3, :3]
            case {"!AngleAxis": {"angle_deg": angle, "axis": axis, **rest}} if not rest:
                turn = checked_number(self._plain(angle, f"{key}: angle_deg"), where)
                along = checked(self._plain(axis, f"{key}: axis"), (3,), where)
                length = float(np.linalg.norm(along))
                if not length > 0:
                    self.fail(f"{key}: axis is zero", "needs a direction")
                return np.asarray(Rotation.from_rotvec(np.radians(turn) * along / length).as_matrix())
            case {} if value in ({}, {"!Identity": {}}):
                return np.eye(3)
        tag = next(iter(value), "") if isinstance(value, dict) else ""
        if tag == "!Uniform":
            self.fail(f"{key}: rotation is drawn at random (!Uniform)", "write the value out")
        return self.fail(
            f"{key}: rotation is {quoted(value, 60)}",
            "needs !Rpy {deg: [r, p, y]}, !AngleAxis {angle_deg: a, axis: [x, y, z]} or !Identity {}",
        )

    def check(self, values: Mapping[str, Any], known: Iterable[str], what: str) -> None:
        """Raise SceneError for a key that is not known, as Drake does."""
        for key in values:
            if key not in known:
                self.fail(f"unknown key {quoted(key)} in {what}", nearest_of(key, list(known)))


def directives_of(source: Source, references: References, notes: list[str]) -> list[Directive]:
    """Return all directives of a file and of those that it adds, in order."""
    return list(_Files(notes).read(source, references, "", ()))


class _Files:
    """Reads files of directives, and counts them."""

    def __init__(self, notes: list[str]) -> None:
        self.notes = notes
        self.count = 0

    def read(
        self, source: Source, references: References, namespace: str, above: tuple[str, ...]
    ) -> Iterator[Directive]:
        where, here = str(source.path), str(source.path.resolve())
        self.count += 1
        if self.count > MOST_FILES:
            raise SceneError(message(where, "is one file too many", f"the limit is {MOST_FILES:,}"))
        if here in above:
            raise SceneError(message(where, "adds itself", "break the circle"))
        data = plain_data.from_yaml(source.text, where, tags=True)
        found = data.get("directives") if isinstance(data, dict) else None
        if not isinstance(found, list):
            raise SceneError(message(where, "has no list of directives", "needs `directives:` with a list"))
        unread = [key for key in data if key != "directives"]
        self.notes += not_read(Counter(map(str, unread)))
        for each in found:  # before the first one is parsed
            added = each.get("add_directives") if isinstance(each, dict) else None
            if isinstance(added, dict) and isinstance(added.get("file"), str):
                spend(YAML, check_ordinary(references.file(added["file"], where), "file of directives"), where)
        for number, each in enumerate(found):
            one = Directive("", each if isinstance(each, dict) else {}, namespace, f"{where}: directives[{number}]",
                            references)  # fmt: skip
            kind = next(iter(one.values), "")
            if len(one.values) != 1 or kind not in KEYS:
                one.fail(f"is {quoted(each, 60)}", f"needs one of {', '.join(KEYS)}")
            values = each[kind]
            one = Directive(kind, values if isinstance(values, dict) else {}, namespace, f"{one.where}: {kind}",
                            references)  # fmt: skip
            if not isinstance(values, dict):
                one.fail(f"is {quoted(values, 60)}", f"needs {', '.join(KEYS[kind])}")
            one.check(values, KEYS[kind], kind)
            if kind != "add_directives":
                yield one
                continue
            path = references.file(one.text("file"), one.where)
            inner = one.values.get("model_namespace")
            below = one.within(one.text("model_namespace")) if inner is not None else namespace
            yield from self.read(Source(path), references.beside(path), below, (*above, here))
