"""What holds the surfaces of each pair of bodies: static Coulomb friction, and the strength of what joins them."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import field
from typing import Any, Literal, NamedTuple, get_args

from holdfast.base.arrays import checked_mapping, checked_name, checked_number, checked_word
from holdfast.base.errors import SceneError, message, nearest_of
from holdfast.base.public import Record
from holdfast.base.ranges import FRICTION, PRESSURE, Range
from holdfast.base.text import quoted
from holdfast.base.values import Table

Pair = tuple[str, str]
Combine = Literal["max", "min", "product"]
STRENGTHS = ("tension", "cohesion")
EXAMPLES = {
    "pairs": '{("cup", "table"): 0.4}',
    "values": '{"cup": 0.4}',
    "tension": '{("brick", "brick"): 9000.0}',
    "cohesion": '{("brick", "brick"): 9000.0}',
}

_COMBINE: Mapping[str, Callable[[float, float], float]] = {
    "max": max,
    "min": min,
    "product": lambda a, b: a * b,
}


def checked_pairs(
    given: Mapping[Any, Any],
    where: str,
    what: str,
    *,
    minimum: float | None = None,
    above: float | None = None,
    within: Range | None = None,
) -> Table[Pair, float]:
    """Return a table of numbers for pairs of names, which are in alphabetical order.

    ``where`` is the owner of the table and ``what`` the meaning of its numbers in error messages. Raises SceneError if
    a key is not a pair of names, a pair occurs twice, or a number is below ``minimum``, not greater than ``above``, or
    out of the range ``within``.
    """
    pairs: dict[Pair, float] = {}
    for key, value in given.items():
        a, b = sorted(checked_pair(key, where))
        if (a, b) in pairs:
            raise SceneError(message(where, f"pair {quoted(key)} stands twice", "give each pair once"))
        pairs[a, b] = checked_number(value, f"{what} of {quoted(key)}", minimum=minimum, above=above, within=within)
    return Table(pairs)


def checked_pair(key: Any, where: str) -> Pair:  # noqa: ANN401 - anything a caller may pass
    """Return a pair of names; raise SceneError for anything else."""
    if not isinstance(key, tuple) or len(key) != 2 or not all(isinstance(part, str) for part in key):
        raise SceneError(message(where, f"pair {quoted(key)}", "needs two body or material names"))
    return key


def number_between(pairs: Mapping[Pair, float], a: str, b: str, materials: Mapping[str, str | None]) -> float | None:
    """Return the number of bodies ``a`` and ``b`` in a table from ``checked_pairs``, or None if it has none.

    It is looked up as ``names_between`` says. If both mixed pairs are given, the smaller number counts, whichever body
    comes first.
    """
    for named in names_between(a, b, materials) if pairs else ():
        found = [pairs[pair] for pair in named if pair in pairs]
        if found:
            return min(found)
    return None


def names_between(a: str, b: str, materials: Mapping[str, str | None]) -> list[list[Pair]]:
    """Return the pairs of names, each in alphabetical order, under which a table may have a number for two bodies.

    First come the names of both bodies, then the name of one body and the material of the other, then both materials.
    ``materials`` maps the name of each body to its material, or None.
    """
    like_a, like_b = materials.get(a), materials.get(b)
    ways = (((a, b),), ((a, like_b), (like_a, b)), ((like_a, like_b),))
    return [[(min(x, y), max(x, y)) for x, y in way if x is not None and y is not None] for way in ways]


def check_known(pairs: Collection[Pair], known: Collection[str], what: str) -> None:
    """Raise SceneError, with the most similar name, if a pair has a name that is not among the ``known`` ones."""
    for key in pairs:
        for name in key:
            if name not in known:
                remedy = nearest_of(name, sorted(known))
                raise SceneError(message(f"{what} of {quoted(key)}", f"unknown name {quoted(name)}", remedy))


class Strength(NamedTuple):
    """What faces hold per area [Pa] beyond friction: the cone of forces is moved by ``tension`` along its axis.

    Friction is then |f_t| <= μ (f_n + tension) + ``shear``, and f_n >= -tension. Both are 0 where nothing joins them.
    """

    tension: float
    shear: float


NOTHING = Strength(0.0, 0.0)


class Friction(Record):
    """The friction table: static Coulomb friction coefficients for pairs of bodies, and what joins their faces.

    The coefficient of a pair is looked up in this order:

    - ``pairs``: first under the names of both bodies, then under the name of one body and the material of the other,
      then under both materials;
    - ``values``, one for each body, combined by the rule ``combine``: "max", "min" or "product". File formats with one
      coefficient for each body disagree on the rule, so it has no default;
    - ``default``.

    Nothing is guessed: a touching pair without a coefficient raises SceneError.

    ``tension`` [Pa] says for some pairs, looked up like ``pairs``, how strongly their faces resist being pulled apart
    (studs, glue, tape), and ``cohesion`` [Pa] how strongly they resist sliding where nothing presses them. On an area w
    the normal force is at least -tension w, and friction is at most μ f_n + cohesion w. A pair with a tension alone has
    the cohesion μ tension: its cone of forces is moved along its axis. A cohesion of less than that closes the cone
    earlier, at the tension cohesion / μ. Both strengths are ductile: a face keeps its strength while it gives way.
    Lines and points have no area, and no strength.

    All tables are read-only copies; the two names of a pair are in alphabetical order.
    """

    default: float | None = None
    pairs: Mapping[tuple[str, str], float] = field(default_factory=dict)
    values: Mapping[str, float] = field(default_factory=dict)
    combine: Combine | None = None
    tension: Mapping[tuple[str, str], float] = field(default_factory=dict)
    cohesion: Mapping[tuple[str, str], float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name in ("pairs", "values", *STRENGTHS):
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
        for name in STRENGTHS:
            strengths = checked_pairs(getattr(self, name), f"friction: {name}", name, minimum=0, within=PRESSURE)
            object.__setattr__(self, name, strengths)

    def between(self, a: str, b: str, materials: Mapping[str, str | None]) -> float:
        """Return the friction coefficient between bodies ``a`` and ``b``.

        ``materials`` maps the name of each body to its material, or None. Raises SceneError if the table has no
        coefficient for the pair.
        """
        found = number_between(self.pairs, a, b, materials) if self.pairs else None
        if found is not None:
            return found
        if self.combine is not None and a in self.values and b in self.values:
            return _COMBINE[self.combine](self.values[a], self.values[b])
        if self.default is None:
            raise SceneError(
                message(f"friction of ({quoted(a)}, {quoted(b)})", "is not given", "add the pair or a default")
            )
        return self.default

    @property
    def joins(self) -> bool:
        """Whether some pair has a strength."""
        return any(value > 0 for name in STRENGTHS for value in getattr(self, name).values())

    def among(self, names: Collection[str]) -> Friction:
        """Return the part of the table that concerns these bodies and materials."""
        values = {name: mu for name, mu in self.values.items() if name in names}
        return Friction(
            self.default,
            _among(self.pairs, names),
            values,
            self.combine,
            _among(self.tension, names),
            _among(self.cohesion, names),
        )

    def check_names(self, bodies: Collection[str], materials: Collection[str]) -> None:
        """Raise SceneError if the table names something that is neither a body nor a material."""
        for name, what in (("pairs", "friction"), *zip(STRENGTHS, STRENGTHS, strict=True)):
            check_known(getattr(self, name), {*bodies, *materials}, what)
        for name in self.values:
            if name not in bodies:
                remedy = nearest_of(name, sorted(bodies))
                raise SceneError(message("friction", f"value for unknown body {quoted(name)}", remedy))


def strength_between(table: Friction, a: str, b: str, materials: Mapping[str, str | None], mu: float) -> Strength:
    """Return what joins bodies ``a`` and ``b``, which have the friction coefficient ``mu``.

    ``materials`` is as in ``Friction.between``.
    """
    tension = number_between(table.tension, a, b, materials) or 0.0
    cohesion = number_between(table.cohesion, a, b, materials)
    if cohesion is None:
        return Strength(tension, 0.0)
    if mu * tension > cohesion:
        tension = cohesion / mu
    return Strength(tension, max(cohesion - mu * tension, 0.0))


def refuse_strengths(table: Friction, where: str, remedy: str) -> None:
    """Raise SceneError, with ``where`` and ``remedy`` in its message, if some pair has a strength."""
    if table.joins:
        first = next(pair for name in STRENGTHS for pair, value in getattr(table, name).items() if value > 0)
        problem = f"does not take glue, and {quoted(first)} has a tension or a cohesion"
        raise SceneError(message(where, problem, remedy))


def _among(pairs: Mapping[tuple[str, str], float], names: Collection[str]) -> dict[tuple[str, str], float]:
    return {pair: value for pair, value in pairs.items() if pair[0] in names and pair[1] in names}


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
        for table, rest in (("pairs", its.default), *((name, 0.0) for name in STRENGTHS)):
            ours, theirs = getattr(own, table), getattr(its, table)
            for pair, value in ours.items():
                if {*pair} <= set(known) and theirs.get(pair) != value:
                    what = "" if table == "pairs" else f"the {table} of "
                    problem = (
                        f"{what}{quoted(pair)} is {value:g} in one scene and {theirs.get(pair, rest)} in the other"
                    )
                    raise SceneError(message(where, problem, "give both the same, or other names of materials"))
    return Friction(
        first.default if second.default is None else second.default,
        {**first.pairs, **second.pairs},
        {**first.values, **second.values},
        first.combine if second.combine is None else second.combine,
        {**first.tension, **second.tension},
        {**first.cohesion, **second.cohesion},
    )
