"""Convert YAML and JSON text to plain data and back, without code execution, deep recursion or silent loss."""

from __future__ import annotations

import json
from collections.abc import Hashable
from typing import Any

import yaml

from holdfast.base.errors import SceneError, message

SUFFIXES = (".yaml", ".yml", ".json")  # suffixes of files that hold JSON or YAML
MAX_DEPTH = 40  # the deepest nesting that is accepted


class _Loader(getattr(yaml, "CSafeLoader", yaml.SafeLoader)):  # type: ignore[misc]
    """A safe YAML loader that rejects a key that occurs twice, instead of silently replacing its value."""

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Hashable, Any]:
        seen: set[Any] = set()
        for key_node, _ in node.value:
            key = self.construct_object(key_node, deep=True)
            if not isinstance(key, Hashable):
                raise yaml.constructor.ConstructorError(None, None, f"key {key!r} is no text", key_node.start_mark)
            if key in seen:
                raise yaml.constructor.ConstructorError(None, None, f"key {key!r} twice", key_node.start_mark)
            seen.add(key)
        result: dict[Hashable, Any] = super().construct_mapping(node, deep)
        return result


def from_json(text: str, where: str) -> Any:  # noqa: ANN401 - plain data
    """Parse JSON into dicts, lists and scalars; raises SceneError with ``where`` and the line."""

    def no_repeats(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        result: dict[str, Any] = {}
        for name, value in pairs:
            if name in result:
                raise SceneError(message(where, f"key {name!r} stands twice", "keep one"))
            result[name] = value
        return result

    try:
        return json.loads(text, object_pairs_hook=no_repeats)
    except json.JSONDecodeError as cause:
        raise SceneError(message(f"{where}:{cause.lineno}", f"is not JSON: {cause.msg}", "check the file")) from cause
    except RecursionError as cause:
        raise SceneError(message(where, "is nested too deeply", f"the limit is {MAX_DEPTH} levels")) from cause
    except ValueError as cause:
        raise SceneError(message(where, f"is not JSON: {cause}", "check the file")) from cause


def from_yaml(text: str, where: str) -> Any:  # noqa: ANN401 - plain data
    """Parse YAML into dicts, lists and scalars; raises SceneError with ``where`` and the line."""
    try:
        _refuse_aliases_and_depth(text, where)
        return yaml.load(text, Loader=_Loader)
    except yaml.YAMLError as cause:
        mark = getattr(cause, "problem_mark", None)
        line = f"{where}:{mark.line + 1}" if mark is not None else where
        problem = getattr(cause, "problem", None) or str(cause).splitlines()[0]
        raise SceneError(message(line, f"is not a YAML scene: {problem}", "check the file")) from cause
    except (ValueError, RecursionError) as cause:
        raise SceneError(message(where, f"is not a YAML scene: {cause}", "check the file")) from cause


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
