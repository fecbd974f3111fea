"""Static Coulomb friction, one coefficient for each pair of bodies."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field
from typing import Literal, get_args

from holdfast.base.archive import archived
from holdfast.base.arrays import checked_mapping, checked_name, checked_number, checked_word
from holdfast.base.errors import SceneError, message, nearest_of
from holdfast.base.ranges import FRICTION
from holdfast.base.text import quoted
from holdfast.base.values import Table, Value
from holdfast.scene.pairs import check_known, checked_pairs, number_between

Combine = Literal["max", "min", "product"]
EXAMPLES = {"pairs": '{("cup", "table"): 0.4}', "values": '{"cup": 0.4}'}

_COMBINE: Mapping[str, Callable[[float, float], float]] = {
    "max": max,
    "min": min,
    "product": lambda a, b: a * b,
}


@archived
@dataclass(frozen=True, eq=False, repr=False)
class Friction(Value):
    """The friction table: static Coulomb friction coefficients for pairs of bodies.

    The coefficient of a pair is looked up in this order:

    - ``pairs``: first under the names of both bodies, then under the name of one body and the material of the other,
      then under both materials;
    - ``values``, one for each body, combined by the rule ``combine``: "max", "min" or "product". File formats with one
      coefficient for each body disagree on the rule, so it has no default;
    - ``default``.

    Nothing is guessed: a touching pair without a coefficient raises SceneError. ``pairs`` and ``values`` are read-only
    copies; the two names of a pair are in alphabetical order.
    """

    default: float | None = None
    pairs: Mapping[tuple[str, str], float] = field(default_factory=dict)
    values: Mapping[str, float] = field(default_factory=dict)
    combine: Combine | None = None

    def __post_init__(self) -> None:
        for name in ("pairs", "values"):
            checked_mapping(getattr(self, name), f"friction: {name}", EXAMPLES[name])
        pairs = checked_pairs(self.pairs, "friction", "friction", minimum=0, within=FRICTION)
        values = {
            checked_name(name, "friction: values: name"): checked_number(
                value, f"friction of {quoted(name)}", minimum=0, within=FRICTION
            )
            for name, value in self.values.items()
        }
        if self.default is not None:
            default = checked_number(self.default, "friction: default", minimum=0, within=FRICTION)
            object.__setattr__(self, "default", default)
        if self.combine is not None:
            checked_word(self.combine, get_args(Combine), "friction: combine")
        if values and self.combine is None:
            problem = f"{len(values)} bodies have a value of their own but combine is not given"
            raise SceneError(message("friction", problem, "say how two values make a pair's: max, min or product"))
        object.__setattr__(self, "pairs", pairs)
        object.__setattr__(self, "values", Table(values))

    def between(self, a: str, b: str, materials: Mapping[str, str | None]) -> float:
        """Return the friction coefficient between bodies ``a`` and ``b``.

        ``materials`` maps the name of each body to its material, or None. Raises SceneError if the table has no
        coefficient for the pair.
        """
        found = number_between(self.pairs, a, b, materials)
        if found is not None:
            return found
        if self.combine is not None and a in self.values and b in self.values:
            return _COMBINE[self.combine](self.values[a], self.values[b])
        if self.default is None:
            raise SceneError(
                message(f"friction of ({quoted(a)}, {quoted(b)})", "is not given", "add the pair or a default")
            )
        return self.default

    def among(self, names: Collection[str]) -> Friction:
        """Return the part of the table that concerns these bodies and materials."""
        pairs = {key: mu for key, mu in self.pairs.items() if key[0] in names and key[1] in names}
        values = {name: mu for name, mu in self.values.items() if name in names}
        return Friction(self.default, pairs, values, self.combine)

    def check_names(self, bodies: Collection[str], materials: Collection[str]) -> None:
        """Raise SceneError if the table names something that is neither a body nor a material."""
        check_known(self.pairs, {*bodies, *materials}, "friction")
        for name in self.values:
            if name not in bodies:
                remedy = nearest_of(name, sorted(bodies))
                raise SceneError(message("friction", f"value for unknown body {quoted(name)}", remedy))


def joined_friction(first: Friction, second: Friction, names: Collection[str], others: Collection[str]) -> Friction:
    """Return a common table of two scenes in which all pairs within each scene have the same coefficients as before.

    ``names`` and ``others`` are the bodies and materials of the two scenes. Raises SceneError, which names the
    difference, if there is no such table.
    """
    where = "scene + scene: friction"
    for what in ("default", "combine"):
        one, two = getattr(first, what), getattr(second, what)
        if one is not None and two is not None and one != two:
            remedy = "needs one for both" if what == "combine" else "give both the same, and what differs as pairs"
            raise SceneError(message(where, f"{what} is {one} and {two}", remedy))
    for own, its, known in ((first, second, others), (second, first, names)):
        for pair, mu in own.pairs.items():
            if {*pair} <= set(known) and its.pairs.get(pair) != mu:
                problem = f"{quoted(pair)} is {mu:g} in one scene and {its.pairs.get(pair, its.default)} in the other"
                raise SceneError(message(where, problem, "give both the same, or other names of materials"))
    return Friction(
        first.default if second.default is None else second.default,
        {**first.pairs, **second.pairs},
        {**first.values, **second.values},
        first.combine if second.combine is None else second.combine,
    )
