"""The answers of today are those that were accepted, as far as processors agree (tools/golden.py compares bits).

Another processor, or another kernel of the same library, rounds sums in another order. Most answers then differ by much
less than CLOSE. The exceptions in ``rule`` were found with OPENBLAS_CORETYPE=Prescott and Haswell, and with noise of
4e-16 in all that the conic solver is given. With these kernels all answers of engine ``compliant`` are within CLOSE.
"""

from __future__ import annotations

import json
import math
import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import pytest
import record

CLOSE = 1e-6  # relative
FLOOR = 1e-7  # of the unit of a field: what an answer that should be zero may be off
DIGITS = re.compile(r"-?\b\d+(?:\.\d+)?(?:e-?\d+)?")
HUGE = 1e6  # of the unit of a field: larger bounds say "no end", not where it is
ERRORS = {"residual": 1e-7, "violation": 1e-6}  # what these may be: their digits are rounding alone


@dataclass(frozen=True)
class Rule:
    """How a field is compared: off by ``close`` (relative) at most, but for a share ``few``, off by ``far`` at most."""

    close: float = CLOSE
    few: float = 0.0
    far: float = math.inf


EXACT = Rule()
ANY = Rule(few=1.0)

UNITS = {
    **dict.fromkeys(["force", "lower", "upper", "contact_force", "nominal", "robustness", "weight", "d_mu"], "N"),
    **dict.fromkeys(["points", "centroid", "pose", "com", "coms"], "m"),
    **dict.fromkeys(["acceleration", "d_mass"], "m/s²"),
    **dict.fromkeys(["d_com", "d_point"], "N/m"),
    "area": "m²",
}  # of all that is compared; what is not named is a pure number


def rule(topic: str, engine: str, field: str, question: str) -> Rule:
    """How a field of an engine's answers is compared, and why not to CLOSE."""
    if field in ("facets", "cuts", "corners"):
        return ANY  # hulls in six dimensions are joggled: their facets are a matter of rounding
    if "wrenches" in question and field in ("usage", "accuracy", "solves"):
        return Rule(close=0.02, few=0.1, far=0.2)  # ... and where the next solve asks, with it
    if field == "accuracy":
        return Rule(close=1e-2, few=1.0, far=math.inf)  # of a polyhedron found exactly: rounding
    if field.startswith("d_"):
        return Rule(close=1e-3)  # a dual motion of the conic solver, accurate to about the root of its tolerance
    if engine == "graph":
        # paths of least resistance over contact forces that the conic solver knows to about 1e-6; ties among paths
        if field in ("force", "lower", "upper"):
            return Rule(close=1e-5, few=0.02, far=1e-3)
        if field in ("moving", "mode", "mechanism", "body"):
            return Rule(few=0.1)
    if engine != "compliant":
        return EXACT
    # Elastic contacts that slip: a path of many steps. ``lower`` is the last load on it that was found to hold, between
    # trial loads that depend on the steps. What moves, how, and about which axis is the same, whatever the digits.
    if field in ("lower", "speed"):
        return Rule(close=1e-2)
    if field in ("force", "acceleration", "nominal", "factor", "robustness"):
        return Rule(close=1e-3)
    return EXACT


def engine_of(path: tuple[Any, ...]) -> str:
    """The engine that a path of keys names; bounds and paths of speed are asked of the default one."""
    words = " ".join(key for key in path if isinstance(key, str))
    named = [engine for engine in record.ENGINES if engine in words]
    return named[0] if named else "compliant" if "bounded" in words or "along a path" in words else "limit"


def unit(topic: str, path: tuple[Any, ...], field: str) -> float:
    """The size of a field's unit in the scene that is asked about: named by the topic, or first in the question."""
    scene = topic.removeprefix("scene_") if topic.startswith("scene_") else path[0].split(":")[0].split()[0]
    assembly = record.assembled(scene)
    weight, size = assembly.weight, assembly.size
    sizes = {"N": weight, "m": size, "m²": size**2, "m/s²": 9.81, "N/m": weight / size, "": 1.0}
    return sizes[UNITS.get(field, "")]


def leaves(data: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[tuple[Any, ...], Any]]:
    """All (path, value); a list of names in a list is one value."""
    if isinstance(data, dict):
        for key, value in data.items():
            yield from leaves(value, (*path, key))
    elif isinstance(data, list) and not (isinstance(path[-1], int) and all(isinstance(v, str) for v in data)):
        yield (*path, "count"), len(data)
        for k, value in enumerate(data):
            yield from leaves(value, (*path, k))
    else:
        yield path, data


def field_of(path: tuple[Any, ...]) -> str:
    """The name of a value: its last key, or that of the table it stands in (derivatives by bodies)."""
    names = [key for key in path if isinstance(key, str)]
    known = [name for name in names if name in UNITS or name.startswith("d_")]
    return known[-1] if known else names[-1]


def differs(old: Any, new: Any, floor: float, rule: Rule) -> float:
    """0 where two values are the same by a rule, 1 where they are off, 2 where they are far off."""
    numbers = all(isinstance(v, int | float) and not isinstance(v, bool) for v in (old, new))
    if not numbers:
        return 0 if old == new or same_words(old, new) else 1
    off = max(abs(new - old) - floor, 0.0) / max(abs(old), abs(new), 1e-300)
    return 0 if off <= rule.close else 1 if off <= rule.far else 2


def same_words(old: Any, new: Any) -> bool:
    """Whether two texts differ by nothing but the last of the three digits in which they give places and axes."""
    if not (isinstance(old, str) and isinstance(new, str)) or DIGITS.sub("#", old) != DIGITS.sub("#", new):
        return False
    pairs = zip(DIGITS.findall(old), DIGITS.findall(new), strict=True)
    return all(math.isclose(float(a), float(b), rel_tol=1e-2, abs_tol=1e-3) for a, b in pairs)


def same_cells(old: Any, new: Any) -> None:
    """Take points out of both maps that are not the same: triangles of curved faces are clustered, and tie."""
    if not isinstance(old, dict):
        return
    if "hidden" not in old or not isinstance(new, dict) or len(old["force"]) != len(new.get("force", ())):
        for key in old:
            same_cells(old[key], new.get(key) if isinstance(new, dict) else None)
        return
    kept = [k for k, (p, q) in enumerate(zip(old["points"], new["points"], strict=True)) if math.dist(p, q) < 1e-9]
    if len(kept) >= 0.95 * len(old["points"]):
        for answers in (old, new):
            for name, column in answers.items():
                if isinstance(column, list) and len(column) == answers["count"] and name != "weakest":
                    answers[name] = [column[k] for k in kept]


def misfits(topic: str, old: Any, new: Any) -> list[str]:
    """What differs by more than the rules allow, in words."""
    same_cells(old, new)
    before, after = dict(leaves(old)), dict(leaves(new))
    found = [f"{path}: only {'before' if path in before else 'now'}" for path in before.keys() ^ after.keys()]
    asked: Counter[tuple[str, str, Rule]] = Counter()
    off: dict[tuple[str, str, Rule], list[str]] = {}
    for path in before.keys() & after.keys():
        a, b, field = before[path], after[path], field_of(path)
        text = f"{path}: {a!r} -> {b!r}"
        if field in ERRORS:
            if (a == "inf") != (b == "inf") or (b != "inf" and b > ERRORS[field]):
                found.append(text)
            continue
        scale, engine = unit(topic, path, field), engine_of(path)
        if field in ("lower", "upper") and all(v == "inf" or v > HUGE * scale for v in (a, b)):
            continue
        question = path[0] if isinstance(path[0], str) else ""
        allowed = rule(topic, engine, field, question)
        group = (engine, field, allowed)
        asked[group] += 1
        how = differs(a, b, FLOOR * scale, allowed)
        if how == 2:
            found.append(text)
        elif how:
            off.setdefault(group, []).append(text)
    for group, texts in off.items():
        if len(texts) > group[2].few * asked[group]:
            found += texts
    return sorted(found)


@pytest.mark.parametrize("topic", record.TOPICS)
def test_answers_are_the_accepted_ones(topic: str) -> None:
    new = json.loads(json.dumps(record.TOPICS[topic]()))
    found = misfits(topic, record.recorded(topic), new)
    assert not found, f"{len(found)} answers differ:\n" + "\n".join(found[:40])


def test_changes_have_their_reasons() -> None:
    """The newest line of the log is about the answers as they are."""
    *_, newest = record.LOG.read_text(encoding="utf-8").splitlines()
    assert re.fullmatch(rf"- {record.mark()}: \w.{{20,}}", newest), "accept answers by tools/golden.py, with a reason"


def plain_map(**fields: Any) -> dict[str, Any]:
    return {"compliant": {"pushes": [{"status": "stable", "lower": 9.0, "force": 10.0, "mode": "slides", **fields}]}}


@pytest.mark.parametrize(("field", "value", "same"), [
    ("lower", 9.08, True), ("lower", 9.1, False), ("lower", 8.9, False), ("lower", 4.5, False),
    ("force", 10.009, True), ("force", 10.02, False), ("force", 9.98, False),
    ("status", "undecided", False), ("mode", "tips", False), ("lower", "inf", False),
])  # fmt: skip
def test_a_changed_answer_is_found(field: str, value: Any, same: bool) -> None:
    found = misfits("scene_cube", plain_map(), plain_map(**{field: value}))
    assert (not found) == same, found


def test_axes_are_the_same_but_for_their_last_digit() -> None:
    said = "cube turns about the axis through (0, 0.05, -0.1) along (-1, 0, 0); opens: floor-cube"
    for now, same in (
        (said, True),
        (said.replace("0.05", "0.0505"), True),
        (said.replace("0.05", "0.06"), False),
        (said.replace("(-1", "(1"), False),
        (said.replace("opens", "slides"), False),
    ):
        assert (not misfits("scene_cube", plain_map(mechanism=[said]), plain_map(mechanism=[now]))) == same, now
