"""Whether the bodies and contacts that a certificate lists are those of a scene."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

from holdfast.assembly.assembly import Assembly
from holdfast.base.text import listed, quoted
from holdfast.certificates.certificate import Provable
from holdfast.certificates.question import Question
from holdfast.certificates.verify_certificate import number

NONE = [0.0] * 6
Point = dict[str, Any]  # of contact: where, with which normal and which friction
SAME = 1e-9  # m, kg, m/s² or relative: numbers that a scene file may have rounded


def differences(certificate: dict[str, Any], assembly: Assembly) -> list[str]:
    """Return what a verified certificate says of the scene that does not hold for an assembly, in words.

    Contacts are found anew and compared point by point. What a certificate lists as standing has to be the pull of
    tension between faces, and nothing else: loads are not part of a scene, nor is the acceleration of the support.
    """
    names = [body["name"] for body in certificate["bodies"]]
    unknown = [name for name in names if assembly.index.get(name, -1) < 0]
    if unknown:
        return [f"{listed(unknown)} cannot move, or is not there"]
    state = assembly.without({body.name for body in assembly.movable} - set(names))
    return list(_differences(certificate, Provable(Question.of(state)).contents()))


def left_out(certificate: dict[str, Any], assembly: Assembly) -> tuple[list[str], bool]:
    """Return the movable bodies of an assembly that a certificate does not list, and whether some touch those it does.

    Directly, or through others that it does not list.
    """
    there = {body["name"] for body in certificate["bodies"]}
    missing = [body.name for body in assembly.movable if body.name not in there]
    own = {int(assembly.group_of[assembly.index[name]]) for name in there}
    return missing, any(int(assembly.group_of[assembly.index[name]]) in own for name in missing)


def _differences(mine: dict[str, Any], scene: dict[str, Any]) -> Iterator[str]:
    if not _same(_flat(mine["gravity"]), _flat(scene["gravity"])):
        yield f"gravity differs: {_beside(mine['gravity'], scene['gravity'])}"
    unfixed = sorted(set(mine["fixed"]) - set(scene["fixed"]))
    if unfixed:
        yield f"{listed(unfixed)} is not fixed"
    known = {body["name"]: body for body in scene["bodies"]}
    for body in mine["bodies"]:
        for key in ("mass", "centre"):
            if not _same(_flat(body[key]), _flat(known[body["name"]][key])):
                beside = _beside(body[key], known[body["name"]][key])
                yield f"the {key} of {quoted(body['name'])} differs: {beside}"
    loads, pulls = _loads(mine["standing"]), _loads(scene["standing"])
    for name in {**loads, **pulls}:
        if not _same(loads.get(name, NONE), pulls.get(name, NONE)):
            yield f"what stands on {quoted(name)} is not the pull of tension between its faces alone"
    points, wanted = _points(mine["contacts"]), _points(scene["contacts"])
    for pair in {**points, **wanted}:
        found = next(_between(points.get(pair, []), wanted.get(pair, [])), None)
        if found is not None:
            yield f"the contact between {quoted(pair[0])} and {quoted(pair[1])} differs: {found}"


def _between(mine: Sequence[Point], others: Sequence[Point]) -> Iterator[str]:
    """Yield how the points of contact of two bodies differ, in words."""
    if len(mine) != len(others):
        yield f"{len(mine)} points in the certificate, {len(others)} here"
        return
    for k, (point, other) in enumerate(zip(mine, others, strict=True), 1):
        for field in ("mu", "at", "normal"):
            if not _same(_flat(point[field]), _flat(other[field])):
                yield f"{field}{'' if field == 'mu' else f' of point {k}'} is {_beside(point[field], other[field])}"


def _loads(entries: Sequence[dict[str, Any]]) -> dict[str, list[float]]:
    return {entry["body"]: _flat([*entry["force"], *entry["torque"]]) for entry in entries}


def _points(contacts: Sequence[dict[str, Any]]) -> dict[tuple[str, str], list[Point]]:
    """Return place, normal and friction of the points of contact of each pair of bodies."""
    found: dict[tuple[str, str], list[Point]] = {}
    for contact in contacts:
        own = found.setdefault((contact["between"][0], contact["between"][1]), [])
        own += [{**point, "mu": contact["mu"]} for point in contact["points"]]
    return found


def _beside(mine: Any, other: Any) -> str:  # noqa: ANN401 - numbers, or lists of them
    """Say what the certificate and the scene have."""
    one, two = (", ".join(f"{value:.9g}" for value in _flat(values)) for values in (mine, other))
    return f"{one} in the certificate, {two} here"


def _flat(values: Any) -> list[float]:  # noqa: ANN401 - a number, or a list of them
    return [float(number(value)) for value in (values if isinstance(values, list) else [values])]


def _same(mine: Sequence[float], others: Sequence[float]) -> bool:
    return len(mine) == len(others) and all(
        math.isclose(x, y, rel_tol=SAME, abs_tol=SAME) for x, y in zip(mine, others, strict=True)
    )
