"""Check and build the parts of a query: the assembly, the engine, the loads and their load columns."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable, Sequence
from typing import Any, TypeAlias, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from holdfast.assembly.assembly import FIXED, Assembly, assemble
from holdfast.assembly.on_surface import check_on_surface, pointing_out
from holdfast.assembly.strengths import check_strengths
from holdfast.base.arrays import Float, checked, checked_items, checked_name, checked_pushes, checked_truth
from holdfast.base.errors import HoldfastError, HoldfastWarning, SceneError, message
from holdfast.base.names import Registry
from holdfast.base.public import Record
from holdfast.base.ranges import FORCE, PLACE
from holdfast.base.rigid import wrench_at
from holdfast.base.text import quoted
from holdfast.engines.compliant.engine import Compliant
from holdfast.engines.contract import Engine
from holdfast.engines.graph.engine import Graph
from holdfast.engines.limit_engine import Limit
from holdfast.scene.hold import refuse_holds
from holdfast.scene.scene import Scene

ENGINES: Registry[Callable[[], Engine]] = Registry("engine", {"graph": Graph, "limit": Limit, "compliant": Compliant})

DEFAULT_ENGINE = "compliant"  # the engine of every query that does not name another
CERTAIN_ENGINE = "limit"  # the engine that proves above which load no equilibrium exists

EngineChoice: TypeAlias = str | Engine
T = TypeVar("T")


class Load(Record):
    """A load on a body: ``force`` (3,) [N] acts at ``point`` (3,) [m], together with ``moment`` (3,) [N m].

    All three are in the world frame. Raises SceneError if there is neither a force nor a moment, or if a force has no
    point.
    """

    body: str
    point: Float
    force: Float
    moment: Float

    def __init__(
        self,
        body: str,
        point: ArrayLike | None = None,
        force: ArrayLike | None = None,
        moment: ArrayLike | None = None,
    ) -> None:
        where = f"load on {quoted(body)}"
        if force is None and moment is None:
            raise SceneError(message(where, "has neither force nor moment", "give one"))
        if force is not None and point is None:
            raise SceneError(message(where, "has a force but no point", "say where it acts"))
        object.__setattr__(self, "body", checked_name(body, "load: body"))
        for name, value, within in (("point", point, PLACE), ("force", force, FORCE), ("moment", moment, FORCE)):
            given = (0.0, 0.0, 0.0) if value is None else value
            object.__setattr__(self, name, checked(given, (3,), f"{where}: {name}", within=within))


def checked_assembly(value: object) -> Assembly:
    """Return ``value`` if it is an assembly; if it is a scene, assemble it with the default tolerances.

    Raises HoldfastError for anything else, and SceneError for strengths of faces that no engine takes.
    """
    found = assemble(value) if isinstance(value, Scene) else value
    if not isinstance(found, Assembly):
        remedy = "needs an Assembly: hf.assemble(hf.load_scene(path)) makes one"
        raise HoldfastError(message("assembly", f"got a {type(found).__name__}", remedy))
    check_strengths(found)
    return found


def quiet() -> warnings.catch_warnings[None]:
    """Return a context in which overlaps are not warned of: the answers name or count them."""
    return warnings.catch_warnings(action="ignore", category=HoldfastWarning)


def checked_options(value: T | None, kind: type[T], where: str, home: str = "holdfast.sets") -> T:
    """Return ``value``, or ``kind()`` if it is None; raise SceneError if it is not a ``kind``, which is in ``home``."""
    if value is None:
        return kind()
    if not isinstance(value, kind):
        raise SceneError(message(where, f"is {quoted(value)}", f"needs {home}.{kind.__name__}(...)"))
    return value


def register_engine(name: str, make: Callable[[], Engine]) -> Callable[[], None]:
    """Register an engine, so that ``engine=name`` uses the engine that ``make()`` returns in every query.

    Returns a function that removes the registration. Raises HoldfastError if the name is taken or is not a text.
    """
    return ENGINES.add(name, make)


def engine_of(choice: EngineChoice) -> Engine:
    """Return the engine with the name ``choice``, or ``choice`` itself if it is an engine.

    Raises HoldfastError for an unknown name and for anything that is not an engine.
    """
    if isinstance(choice, str):
        if choice not in ENGINES:
            raise HoldfastError(message("engine", f"{quoted(choice)} is unknown", f"known: {', '.join(ENGINES)}"))
        return ENGINES[choice]()
    if isinstance(choice, type) or not hasattr(choice, "prepare"):
        raise HoldfastError(
            message("engine", f"got {quoted(choice)}", f"needs a name ({', '.join(ENGINES)}) or an engine")
        )
    return choice


def engine_for(assembly: Assembly, where: str, *, exists: bool) -> Engine:
    """Return the engine that proves where an equilibrium ``exists``, or else that which says what holds.

    Raises SceneError, with ``where`` in its message, for holds that the latter does not take.
    """
    if not checked_truth(exists, f"{where}: exists"):
        refuse_holds(assembly.scene.holds, where, "ask where an equilibrium exists, with exists=True")
    return engine_of(CERTAIN_ENGINE if exists else DEFAULT_ENGINE)


def total_wrench(assembly: Assembly, loads: Iterable[Load]) -> Float:
    """Return the sum of ``loads`` as wrenches (6J,) about the centres of mass, along the world axes.

    Loads on fixed bodies have no effect. Raises SceneError if ``loads`` is not a list of loads.
    """
    total = np.zeros(6 * len(assembly.movable))
    for load in checked_loads(loads):
        k = body_number(assembly, load.body)
        if k == FIXED:
            continue  # a fixed body supports any load
        wrench = wrench_at(load.force, load.point, assembly.com[k])
        wrench[3:] += load.moment
        total[6 * k : 6 * k + 6] += wrench
    return total


def pressed_by(assembly: Assembly, loads: Iterable[Load]) -> Float:
    """Return how much ``loads`` press each of the B bodies down (B,) [N]; what others pull up is not taken off it."""
    total = {body.name: 0.0 for body in assembly.bodies}
    for load in checked_loads(loads):
        assembly.scene.body(load.body)
        total[load.body] += float(_downward(assembly, load.force))
    return np.array(list(total.values()))


def pressed_by_pushes(assembly: Assembly, bodies: Sequence[str], directions: Float) -> Float:
    """Return how much pushes of 1 N along ``directions`` (n, 3) press each of the B bodies down (B, n).

    ``bodies`` (n,) are those that are pushed, or (1,) if it is always the same.
    """
    pushed = np.array([[body.name == name for name in bodies] for body in assembly.bodies], dtype=bool)
    return np.where(pushed, _downward(assembly, directions), 0.0)


def _downward(assembly: Assembly, forces: Float) -> Float:
    """Return the downward parts (...,) [N] of forces (..., 3), none of those that pull up."""
    return np.maximum(-(forces @ assembly.scene.up), 0.0)


def checked_loads(loads: Iterable[Load]) -> list[Load]:
    """Return loads as a list, so that they can be iterated twice; raise SceneError unless all are loads."""
    if isinstance(loads, Load) or not isinstance(loads, Iterable):
        raise SceneError(message("loads", f"got a single {type(loads).__name__}", "needs a list of loads"))
    found = checked_items(loads, "loads", "loads")
    for load in found:
        if not isinstance(load, Load):
            raise SceneError(message("loads", f"hold a {type(load).__name__}", "needs holdfast.Load objects"))
    return found


def body_number(assembly: Assembly, name: str) -> int:
    """Return the number of a body in the assembly: 0..J-1, or FIXED. Raises SceneError if the body is unknown."""
    assembly.scene.body(name)
    return assembly.index[name]


def body_numbers(assembly: Assembly, names: Sequence[str], where: str) -> dict[str, int]:
    """Return the numbers of the bodies with these names, 0..J-1 or FIXED, by name.

    Raises SceneError, with ``where`` in its message, if ``names`` is a text, is empty or holds an unknown name.
    """
    if isinstance(names, str):
        raise SceneError(message(where, f"bodies is the text {quoted(names)}", "needs a list of names"))
    given = checked_items(names, f"{where}: bodies", "names")
    if not given:
        raise SceneError(message(where, "bodies is empty", "name bodies, or free one"))
    return {name: body_number(assembly, name) for name in given}


def push_columns(assembly: Assembly, number: int, points: Float, directions: Float) -> Float:
    """Return the load columns W (6J, n) of unit pushes along ``directions`` (n, 3) at ``points`` (n, 3) [m] of a body.

    ``number`` is the body's number. The columns of pushes on a fixed body are zero.
    """
    W = np.zeros((6 * len(assembly.movable), len(points)))
    if number != FIXED:
        W[6 * number : 6 * number + 6] = wrench_at(directions, points, assembly.com[number]).T
    return W


def pushes(
    assembly: Assembly,
    body: str,
    points: Any,  # noqa: ANN401 - (n, 3) or (3,) numbers, checked
    directions: Any,  # noqa: ANN401 - (n, 3) or (3,) numbers, checked
    where: str,
) -> tuple[Float, Float, Float]:
    """Check the pushes that a caller gave, and return their points, unit directions and load columns.

    The shapes are (n, 3) [m], (n, 3) and (6J, n), in the world frame. A single point is used with all directions, and a
    single direction with all points. Raises SceneError, with ``where`` in its message, if there is no point or if a
    point does not lie on the surface of the body.
    """
    p, e = checked_pushes(points, directions, where)
    if not len(p):
        raise SceneError(message(where, "got no points", "needs at least one"))
    number = body_number(assembly, body)
    check_on_surface(assembly, body, p, where)
    return p, e, push_columns(assembly, number, p, e)


def pulls(assembly: Assembly, name: str, points: Float, directions: Float) -> tuple[str, ...]:
    """Return a note on the pushes at ``points`` (n, 3) [m] of a body that pull, because they point out of the body."""
    rows = pointing_out(assembly.scene.body(name), points, directions)
    if not len(rows):
        return ()
    if len(points) == 1:
        return (f"the push points away from the surface of {name}: it pulls",)
    return (f"{len(rows):,} of {len(points):,} pushes, the first number {rows[0]}, pull: they point away from {name}",)
