"""Conversion of YAML and JSON text to plain data and back, without code execution, deep recursion or lost data."""

from __future__ import annotations

import json
import re
from collections.abc import Hashable
from typing import Any

import yaml

from holdfast.base.borders.foreign import MAX_DEPTH, foreign
from holdfast.base.errors import SceneError, message
from holdfast.base.text import quoted

SUFFIXES = (".yaml", ".yml", ".json")  # suffixes of files that hold JSON or YAML
MAX_YAML = 2_000_000  # largest number of characters of YAML; parsing takes up to 3 s for 1 MB

_INT, _FLOAT = "tag:yaml.org,2002:int", "tag:yaml.org,2002:float"
_WHOLE = re.compile(r"[-+]?(?:0|[1-9][0-9]*)$")
_DECIMAL = re.compile(
    r"[-+]?(?:(?:[0-9]+\.[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?|[0-9]+[eE][-+]?[0-9]+|\.inf|\.Inf|\.INF)$|\.(?:nan|NaN|NAN)$"
)


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
    if _is_deep(data):
        raise SceneError(message(where, "is nested too deeply", f"the limit is {MAX_DEPTH} levels"))
    return data


class _TaggedLoader(_Loader):
    """Such a loader that reads a mapping with a tag of its own, as ``!Rpy {deg: ...}``, as {"!Rpy": mapping}."""


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


def _is_deep(data: Any) -> bool:  # noqa: ANN401 - plain data
    """Tell whether lists and dicts are nested more than MAX_DEPTH deep, level by level."""
    level: list[Any] = [data] if isinstance(data, dict | list) else []
    for _ in range(MAX_DEPTH):
        parts = (part for item in level for part in (item.values() if isinstance(item, dict) else item))
        level = [part for part in parts if isinstance(part, dict | list)]
    return bool(level)


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
