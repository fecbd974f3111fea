"""The words of public parameters: one type, one unit and one meaning for each name, as ``vocabulary.csv`` has them.

    python tools/vocabulary.py check     # exit code 1 where a public call says something else
    python tools/vocabulary.py page      # the table as the site shows it

Public calls are the functions of ``holdfast``, the constructors of classes that
callers build, and all methods. Not among them are the constructors of answers, which only the library builds, and what
engines and the library itself ask of each other.
"""

from __future__ import annotations

import argparse
import csv
import inspect
import re
import sys
from collections.abc import Callable, Iterator
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any, NamedTuple

TABLE = Path(__file__).with_suffix(".csv")
HEAD = """# All parameters

One word means one thing in every public call, and has one unit ([conventions](/reference/conventions.md)).
"""
MOST = 8  # parameters of a public call
MODULES = ("holdfast", "holdfast.answers", "holdfast.sets", "holdfast.plugins", "holdfast.readers")
BUILT = {  # classes that callers build: all others are answers
    *("Approach", "Body", "Box", "Capsule", "Compliant", "Compound", "Cylinder", "Ellipsoid", "Friction", "Graph"),
    *("HalfSpace", "Imperfect", "Interface", "Limit", "Load", "Mesh", "Monitor", "Moves", "Part", "Patch", "Profile"),
    *("Resources", "Scene", "Search", "Sphere", "Strap", "Tool", "Uncertain", "Weights", "Where"),
}
MANY = {"Body", "Uncertain", "worst_case"}  # a body is what it is, and so is what is not known: these may take more
ASKED_WITHIN = {  # what the parts of the library ask of each other
    *("Compliant", "Graph", "Limit", "Patch", "Assembly", "LiveView"),
    *("Interface.canonical", "Friction.among", "Friction.between", "Friction.check_names", "Scene.checked_names"),
    *("Scene.touching", "Body.only", "Body.placed", "Part.placed", "Compound.only", "HalfSpace.over", "Strap.check"),
    *("Rating.facts", "Scene.mu", "Mechanism.within"),
}


class Word(NamedTuple):
    """A name of a parameter: its type, its unit ("" without one) and what it means, everywhere."""

    name: str
    type: str
    unit: str
    meaning: str


class Use(NamedTuple):
    """Where a parameter is: the call, the annotation there, and the unit that the docstring gives it, if any."""

    call: str
    name: str
    annotation: str
    unit: str


def words() -> dict[str, Word]:
    """The table, by name."""
    with TABLE.open(encoding="utf-8", newline="") as stream:
        return {row["name"]: Word(**row) for row in csv.DictReader(stream)}


def calls() -> Iterator[tuple[str, Callable[..., Any]]]:
    """All public calls by name."""
    seen = set()
    for module in (import_module(name) for name in MODULES if find_spec(name) is not None):
        for name in module.__all__:
            value = getattr(module, name)
            if not callable(value) or value in seen or (inspect.isclass(value) and issubclass(value, BaseException)):
                continue
            if module.__name__.endswith(".plugins") and not inspect.isfunction(value):
                continue  # what engines and readers are told and give
            seen.add(value)
            if not inspect.isclass(value):
                yield name, value
                continue
            if name in BUILT:
                yield name, value
            for method, function in inspect.getmembers(value, callable):
                own = str(getattr(function, "__module__", "")).startswith("holdfast")
                whole = f"{name}.{method}"
                if own and not method.startswith("_") and not {name, whole} & ASKED_WITHIN:
                    yield whole, function


def parameters(call: Callable[..., Any]) -> list[inspect.Parameter]:
    """The parameters that a caller may give, without self."""
    return [each for each in inspect.signature(call).parameters.values() if each.name not in ("self", "cls")]


def uses() -> Iterator[Use]:
    """All parameters of all public calls."""
    for name, call in calls():
        said = inspect.getdoc(call) or ""
        for each in parameters(call):
            found = re.search(rf"``{each.name}``(?: \([\w, ]+\))?(?: \[([^\]]+)\])", said)
            kind = re.sub(r" \| None$", "", str(each.annotation))
            yield Use(name, each.name, kind, found[1] if found else "")


def faults() -> list[str]:
    """What public calls say otherwise than the table, one sentence each."""
    known, found, kinds = words(), list[str](), dict[str, dict[str, str]]()
    everything = list(uses())
    for use in everything:
        word = known.get(use.name)
        if word is None:
            found.append(f"{use.call}: {use.name} is not in {TABLE.name}")
            continue
        if use.unit and use.unit not in word.unit.split("; "):
            found.append(f"{use.call}: {use.name} is in {use.unit}, but in {word.unit or 'no unit'} elsewhere")
        if use.annotation not in word.type.split("; "):
            found.append(f"{use.call}: {use.name} is a {use.annotation}, but a {word.type} elsewhere")
        kinds.setdefault(use.name, {})[use.annotation] = use.call
    found += [f"{name} is in {TABLE.name}, but no public call takes it" for name in known.keys() - kinds.keys()]
    for name, call in calls():
        count = len(parameters(call))
        if count > MOST and name not in MANY:
            found.append(f"{name} takes {count} parameters, more than {MOST}")
    return found


PLAIN = {  # annotations in words
    "float": "number",
    "int": "whole number",
    "bool": "True or False",
    "str": "text",
    "ArrayLike": "array",
    "Float": "array",
    "EngineChoice": "text or engine",
}


def page() -> str:
    """The table as Markdown, for the site."""
    rows = [
        f"| `{word.name}` | {_plain(word.type)} | {word.unit} | {word.meaning} |".replace("|  |", "| |")
        for word in sorted(words().values())
    ]
    return "\n".join([HEAD, "| parameter | type | unit | meaning |", "|---|---|---|---|", *rows, ""])


def _plain(kind: str) -> str:
    names = dict.fromkeys(PLAIN.get(each, f"`{each}`".replace("|", "\\|")) for each in kind.split("; "))
    return " or ".join(names)


def main() -> int:
    """Check all calls, or print the page; 1 where something is wrong."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("command", choices=["check", "page"])
    if parser.parse_args().command == "page":
        print(page(), end="")
        return 0
    found = faults()
    print("\n".join(found))
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
