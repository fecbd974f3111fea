"""A scene file that is being read, each part of it once; YAML and JSON as plain data, without code execution."""

from __future__ import annotations

import json
import re
from codecs import BOM_UTF8
from collections.abc import Hashable, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, NoReturn

import yaml

from holdfast.base.borders.foreign import JSON, MAX_DEPTH, YAML, foreign, spend
from holdfast.base.errors import SceneError, message
from holdfast.base.files import check_ordinary, read_ordinary
from holdfast.base.text import listed, quoted

SUFFIXES = (".yaml", ".yml", ".json")  # suffixes of files that hold JSON or YAML
MAX_YAML = 2_000_000  # largest number of characters of YAML; parsing takes up to 3 s for 1 MB

_INT, _FLOAT = "tag:yaml.org,2002:int", "tag:yaml.org,2002:float"
_WHOLE = re.compile(r"[-+]?(?:0|[1-9][0-9]*)$")
_DECIMAL = re.compile(
    r"[-+]?(?:(?:[0-9]+\.[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?|[0-9]+[eE][-+]?[0-9]+|\.inf|\.Inf|\.INF)$|\.(?:nan|NaN|NAN)$"
)
MAX_BYTES = 200_000_000  # size of the largest file that is read
MAX_JSON_BYTES = 32_000_000  # size of the largest JSON file; parsed data may take twenty times the memory
HEAD_BYTES = 4096  # length of the first part of a file, by which its format is recognised


class _Loader(getattr(yaml, "CSafeLoader", yaml.SafeLoader)):  # type: ignore[misc]
    """A safe YAML loader that refuses keys that are not texts, and repeated keys, whose value YAML would replace."""

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Hashable, Any]:
        seen: set[str] = set()
        for key_node, _ in node.value:
            key = self.construct_object(key_node, deep=True)
            if not isinstance(key, str):  # hashes of texts cannot be made to collide, unlike those of numbers
                raise _wrong_key(key, "is no text: put it in quotes", key_node)
            if key in seen:
                raise _wrong_key(key, "twice", key_node)
            seen.add(key)
        result: dict[Hashable, Any] = super().construct_mapping(node, deep)
        return result


def _read_numbers_as_json_does(loader: Any) -> None:  # noqa: ANN401 - a class of loaders
    """Make a YAML loader read 1e-3 as a number, and 1:30 and 010 (numbers in base 60 and 8 in YAML 1.1) as texts."""
    tags = {_INT: _WHOLE, _FLOAT: _DECIMAL}
    known = loader.yaml_implicit_resolvers.items()
    kept = {first: [pair for pair in pairs if pair[0] not in tags] for first, pairs in known}
    loader.yaml_implicit_resolvers = kept
    for tag, pattern in tags.items():
        loader.add_implicit_resolver(tag, pattern, list("-+.0123456789"))


_read_numbers_as_json_does(_Loader)


def _wrong_key(key: object, problem: str, node: yaml.Node) -> yaml.constructor.ConstructorError:
    return yaml.constructor.ConstructorError(None, None, f"key {quoted(key)} {problem}", node.start_mark)


def from_json(text: str, where: str) -> Any:  # noqa: ANN401 - plain data
    """Parse JSON into dicts, lists and scalars; raises SceneError with ``where`` and the line."""

    def no_repeats(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        result: dict[str, Any] = {}
        for name, value in pairs:
            if name in result:
                raise SceneError(message(where, f"key {quoted(name)} stands twice", "keep one"))
            result[name] = value
        return result

    with foreign(where, "is not JSON", "check the file"):
        data = json.loads(text, object_pairs_hook=no_repeats)
    level: list[Any] = [data] if isinstance(data, dict | list) else []
    for _ in range(MAX_DEPTH):
        parts = (part for item in level for part in (item.values() if isinstance(item, dict) else item))
        level = [part for part in parts if isinstance(part, dict | list)]
    if level:
        raise SceneError(message(where, "is nested too deeply", f"the limit is {MAX_DEPTH} levels"))
    return data


class _TaggedLoader(_Loader):
    """A loader that reads a mapping with a tag of its own, as ``!Rpy {deg: ...}``, as {"!Rpy": mapping}."""


def _tagged(loader: Any, name: str, node: yaml.Node) -> dict[str, Any]:  # noqa: ANN401 - a loader
    if isinstance(node, yaml.MappingNode):
        return {f"!{name}": loader.construct_mapping(node, deep=True)}
    if isinstance(node, yaml.ScalarNode) and not node.value:
        return {f"!{name}": {}}
    raise yaml.constructor.ConstructorError(None, None, f"!{name} needs keys and values", node.start_mark)


_TaggedLoader.add_multi_constructor("!", _tagged)


def from_yaml(text: str, where: str, *, tags: bool = False) -> Any:  # noqa: ANN401 - plain data
    """Parse YAML into dicts, lists and scalars; raises SceneError with ``where`` and the line.

    With ``tags``, a mapping with a tag of its own is a dict with the tag as its only key; otherwise tags are refused.
    """
    if len(text) > MAX_YAML:
        remedy = f"the limit is {MAX_YAML:,}: keep meshes in files of their own"
        raise SceneError(message(where, f"is {len(text):,} characters of YAML", remedy))
    with foreign(where, "is not a YAML scene", "check the file"):
        _refuse_aliases_and_depth(text, where)
        return yaml.load(text, Loader=_TaggedLoader if tags else _Loader)


def _refuse_aliases_and_depth(text: str, where: str) -> None:
    """Raise SceneError for aliases and for deep nesting, neither of which a scene needs.

    Aliases can make a small file huge or endless, and deep nesting can exhaust the stack.
    """
    depth = 0
    for event in yaml.parse(text, Loader=getattr(yaml, "CSafeLoader", yaml.SafeLoader)):
        line = f"{where}:{event.start_mark.line + 1}" if event.start_mark else where
        if isinstance(event, yaml.AliasEvent):
            raise SceneError(message(line, f"uses the alias *{event.anchor}", "write the value out"))
        if isinstance(event, yaml.CollectionStartEvent):
            depth += 1
        elif isinstance(event, yaml.CollectionEndEvent):
            depth -= 1
        if depth > MAX_DEPTH:
            raise SceneError(message(line, "is nested too deeply", f"the limit is {MAX_DEPTH} levels"))


def as_json(data: Any) -> str:  # noqa: ANN401 - plain data
    """Return JSON text, indented by level; raises ValueError for a number that is not finite."""
    return json.dumps(data, indent=1, allow_nan=False) + "\n"


def as_yaml(data: Any) -> str:  # noqa: ANN401 - plain data
    """Return YAML text that keeps the order of the keys and puts each row of numbers on one line."""
    return yaml.dump(data, Dumper=_Dumper, sort_keys=False, allow_unicode=True, width=120)


class _Dumper(getattr(yaml, "CSafeDumper", yaml.SafeDumper)):  # type: ignore[misc]
    """A safe YAML dumper that puts each row of numbers on one line."""

    def represent_list(self, data: list[Any]) -> yaml.SequenceNode:
        flat = all(not isinstance(item, dict) for item in data)
        node: yaml.SequenceNode = self.represent_sequence("tag:yaml.org,2002:seq", data, flow_style=flat)
        return node


_Dumper.add_representer(list, _Dumper.represent_list)
_Dumper.add_multi_representer(str, lambda dumper, text: dumper.represent_str(str(text)))  # of NumPy, for example
_Dumper.add_implicit_resolver(_FLOAT, _DECIMAL, list("-+.0123456789"))  # so that a name such as 1e3 gets quotes


class PlainMap:
    """A map in a file: its keys and values, and its place for messages."""

    values: Mapping[str, Any]
    where: str

    def fail(self, problem: str, remedy: str) -> NoReturn:
        """Raise SceneError about this map."""
        raise SceneError(message(self.where, problem, remedy))

    def text(self, key: str) -> str:
        """Return a text; raises SceneError if it is missing."""
        value = self.values.get(key)
        return value if isinstance(value, str) and value else self.fail(f"{key} is {quoted(value)}", "needs a text")


@dataclass(frozen=True, eq=False)
class Source:
    """The file at ``path`` as the formats see it: its first bytes and, on demand, its content, text and data.

    A part that does not exist raises SceneError: a binary file has no text, and a text that is neither JSON nor YAML
    has no data. If ``given`` holds the content, no file is read, and ``path`` is its name: paths in it are relative to
    the folder of that name.
    """

    path: Path
    given: bytes | None = None

    def __post_init__(self) -> None:
        if self.given is None:
            check_ordinary(self.path, "scene file")

    @cached_property
    def suffix(self) -> str:
        """The suffix of the file in lower case, with its dot; empty if there is none."""
        return self.path.suffix.lower()

    @cached_property
    def head(self) -> bytes:
        """The first 4,096 bytes of the file, or all bytes of a shorter one."""
        if self.given is not None:
            return self.given[:HEAD_BYTES]
        try:
            with self.path.open("rb") as stream:
                return stream.read(HEAD_BYTES)
        except OSError as cause:
            problem = f"cannot be read: {cause.strerror or cause}"
            raise SceneError(message(str(self.path), problem, "needs a file that may be read")) from cause

    @cached_property
    def content(self) -> bytes:
        """All bytes of the file."""
        return read_ordinary(self.path, "scene file", most=MAX_BYTES) if self.given is None else self.given

    @cached_property
    def text(self) -> str:
        """The content decoded as UTF-8, without a byte-order mark."""
        remedy = "needs a readable UTF-8 text file"
        if b"\0" in self.head:  # checked before a large file is read
            raise SceneError(message(str(self.path), "cannot be read: has zero bytes, which no text has", remedy))
        with foreign(str(self.path), remedy=remedy):
            return self.content.decode("utf-8-sig")

    @property
    def data(self) -> Any:  # noqa: ANN401 - plain data
        """The text parsed as JSON or YAML: dicts, lists and scalars.

        All formats share this object and must not change it.
        """
        data, error = self._parsed
        if error is not None:
            raise error
        return data

    @cached_property
    def _parsed(self) -> tuple[Any, SceneError | None]:
        """The data, or the error if there is none; errors are cached, too, so that parsing is tried only once."""
        try:
            limit = MAX_JSON_BYTES if self._is_json else MAX_YAML
            size = check_ordinary(self.path, "scene file") if self.given is None else len(self.given)
            if size > limit:
                remedy = f"the limit is {limit:,}: keep meshes in files of their own"
                raise SceneError(message(str(self.path), f"is {size:,} bytes", remedy))
            spend(JSON if self._is_json else YAML, size, str(self.path))
            if self._is_json:
                return from_json(self.text, str(self.path)), None
            return from_yaml(self.text, str(self.path)), None
        except SceneError as error:
            return None, error

    @property
    def _is_json(self) -> bool:
        """Whether the file is parsed as JSON, by its suffix or, if that is inconclusive, its first character."""
        if self.suffix in SUFFIXES:
            return self.suffix == ".json"
        return self.head.removeprefix(BOM_UTF8).lstrip()[:1] in (b"{", b"[")

    def described(self) -> str:
        """Describe the content in a few words, for the error message if no format recognises it."""
        if not self.head:
            return "empty"
        data, error = self._parsed
        if error is not None or isinstance(data, str):
            return f"first bytes {self.head[:16]!r}"
        if not isinstance(data, dict) or not data:
            return f"only {quoted(data, 40)}"
        if "format" in data:
            return f"`format` is {quoted(data['format'], 40)}"
        return f"no `format` among its keys {listed([quoted(key, 40) for key in data], 3)}"
