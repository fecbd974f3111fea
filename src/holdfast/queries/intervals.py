"""Check the uncertain friction, masses and centres of mass that a caller gives as intervals and boxes."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, TypeAlias

import numpy as np

from holdfast.assembly.assembly import FIXED, Assembly
from holdfast.base.arrays import Float, checked, checked_number
from holdfast.base.errors import SceneError, message
from holdfast.base.ranges import PLACE
from holdfast.base.text import listed, quoted
from holdfast.queries.request import body_number
from holdfast.scene.friction import checked_pair, names_between

NAMED = 3  # the most coefficients that a note names

Pair: TypeAlias = tuple[str, str]
MuRange: TypeAlias = float | tuple[float, float] | Mapping[Pair, tuple[float, float]]
MassRange: TypeAlias = float | Mapping[str, tuple[float, float]]
ComRange: TypeAlias = float | Mapping[str, Any]


def friction_intervals(assembly: Assembly, mu: MuRange | None, where: str) -> dict[Pair, tuple[float, float]]:
    """Return the interval (low, high) of the friction coefficient for every pair of touching bodies.

    ``mu`` is a relative width for all pairs (0.2 means ± 20 %), one interval (low, high) for all pairs, or a dict of
    intervals for pairs of names. A name is that of a body or of a material. As in the friction table, a pair of two
    bodies takes precedence over a body and a material, and that over two materials. The interval of a pair that is not
    named has the known coefficient at both ends. Raises SceneError if a named pair does not touch, or if an interval is
    not 0 <= low <= high.
    """
    pairs: dict[Pair, float] = {}
    for i, m in zip(assembly.interfaces, assembly.mu, strict=True):  # the parts of two bodies may have several
        pairs[i.bodies] = min(m, pairs.get(i.bodies, m))
    if mu is None:
        return {p: (m, m) for p, m in pairs.items()}
    if isinstance(mu, Mapping):
        named = {checked_pair(pair, f"{where}: mu_range"): interval for pair, interval in mu.items()}
        given = {
            (min(pair), max(pair)): _interval(interval, f"{where}: mu_range of {quoted(pair)}")
            for pair, interval in named.items()
        }
        ways = {p: names_between(*p, assembly.scene.materials) for p in pairs}
        touching = {key for way in ways.values() for keys in way for key in keys}
        unknown = [pair for pair in named if (min(pair), max(pair)) not in touching]
        if unknown:
            problem = f"no contact between {quoted(unknown[0])}"
            raise SceneError(message(f"{where}: mu_range", problem, "name touching bodies, or their materials"))
        return {p: _widest([given[key] for key in _first(ways[p], given)] or [(m, m)]) for p, m in pairs.items()}
    if isinstance(mu, tuple | list):
        return dict.fromkeys(pairs, _interval(mu, f"{where}: mu_range"))
    width = _width(mu, f"{where}: mu_range")
    return {p: (m * (1 - width), m * (1 + width)) for p, m in pairs.items()}


def width_notes(assembly: Assembly, mu: MuRange | None) -> tuple[str, ...]:
    """Return a note on what a relative width means for the coefficients that there are; none for intervals."""
    if mu is None or isinstance(mu, Mapping | tuple | list):
        return ()
    each = [f"{m * (1 - mu):.4g} to {m * (1 + mu):.4g} of {m:.4g}" for m in sorted(set(assembly.mu))]
    return (f"mu_range {mu:g} is relative: friction {listed(each, NAMED)}",)


def _first(ways: list[list[Pair]], given: Mapping[Pair, tuple[float, float]]) -> list[Pair]:
    """Return the names that ``given`` holds in the first of ``ways`` that has any; each way names the same bodies."""
    return next((found for way in ways if (found := [key for key in way if key in given])), [])


def _widest(intervals: list[tuple[float, float]]) -> tuple[float, float]:
    """Return the smallest interval that contains all ``intervals``."""
    return min(low for low, _ in intervals), max(high for _, high in intervals)


def mass_intervals(assembly: Assembly, mass: MassRange | None, where: str) -> dict[str, tuple[float, float]]:
    """Return the interval (low, high) [kg] of the mass for each uncertain body, by name.

    ``mass`` is a relative width for all movable bodies, or a dict of intervals by body name. Raises SceneError if a
    named body is fixed, or if an interval is not 0 <= low <= high.
    """
    if mass is None:
        return {}
    if not isinstance(mass, Mapping):
        width = _width(mass, f"{where}: mass_range")
        return {
            b.name: (m * (1 - width), m * (1 + width)) for b, m in zip(assembly.movable, assembly.mass, strict=True)
        }
    _check_movable(assembly, mass, f"{where}: mass_range")
    return {name: _interval(interval, f"{where}: mass_range of {quoted(name)}") for name, interval in mass.items()}


def com_boxes(assembly: Assembly, com: ComRange | None, where: str) -> dict[str, Float]:
    """Return the half widths (3,) [m] of the box around the centre of mass for each uncertain body, by name.

    The boxes lie along the world axes. ``com`` is one half width for all movable bodies, or a dict of half widths (3,)
    by body name. Raises SceneError if a named body is fixed, or if a half width is negative.
    """
    if com is None:
        return {}
    if not isinstance(com, Mapping):
        width = checked_number(com, f"{where}: com_range", minimum=0, within=PLACE)
        return {b.name: np.full(3, width) for b in assembly.movable}
    _check_movable(assembly, com, f"{where}: com_range")
    boxes = {
        name: checked(half, (3,), f"{where}: com_range of {quoted(name)}", within=PLACE) for name, half in com.items()
    }
    for name, half in boxes.items():
        if (half < 0).any():
            raise SceneError(
                message(f"{where}: com_range of {quoted(name)}", f"is {half.tolist()}", "needs half widths >= 0")
            )
    return boxes


def _check_movable(assembly: Assembly, names: Iterable[str], where: str) -> None:
    for name in names:
        if body_number(assembly, name) == FIXED:
            raise SceneError(message(where, f"{quoted(name)} is fixed", "name movable bodies"))


def _interval(value: Any, where: str) -> tuple[float, float]:  # noqa: ANN401
    low, high = (float(v) for v in checked(value, (2,), where))
    if not 0 <= low <= high:
        raise SceneError(message(where, f"is ({low:g}, {high:g})", "needs 0 <= low <= high"))
    return low, high


def _width(value: Any, where: str) -> float:  # noqa: ANN401
    width = checked_number(value, where, minimum=0)
    if width >= 1:
        raise SceneError(message(where, f"relative width {width:g}", "needs less than 1; give (low, high) instead"))
    return width
