"""The friction table of a scene with new objects, which the scene's own table may not name."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import checked_number
from holdfast.base.errors import SceneError, message
from holdfast.base.ranges import FRICTION
from holdfast.base.text import quoted
from holdfast.scene.body import Body
from holdfast.scene.friction import Friction, number_between, refuse_strengths


def friction_with(
    assembly: Assembly, objects: Sequence[Body], given: Friction | float | None, supports: Sequence[str]
) -> Friction:
    """Return the friction table of the scene with ``objects``.

    If ``given`` is a table, it is returned; otherwise the scene's own table is. If ``given`` is a number, it holds
    between each object and every body with which the table does not pair it, in place of the table's default. Raises
    SceneError if there is no coefficient between an object and one of the ``supports``.
    """
    table = given if isinstance(given, Friction) else assembly.scene.friction
    refuse_strengths(table, "plan_placement", "leave out tension and cohesion")
    bodies = [*assembly.bodies, *objects]
    if given is not None and not isinstance(given, Friction):
        table = with_own(table, bodies, objects, given)
    materials = {body.name: body.material for body in bodies}
    for one in objects:
        for name in supports:
            try:
                table.between(one.name, name, materials)
            except SceneError as error:
                problem = f"the scene has no friction of {quoted(one.name)} with {quoted(name)}"
                remedy = "say --object-friction MU (in Python friction=MU), or add the pair or a default to the scene"
                raise SceneError(message("plan_placement", problem, remedy)) from error
    return table


def with_own(table: Friction, bodies: Sequence[Body], objects: Sequence[Body], mu: float) -> Friction:
    """Return the table in which ``mu`` holds between ``objects`` and all ``bodies`` that it does not pair them with."""
    coefficient = checked_number(mu, "plan_placement: friction", minimum=0, within=FRICTION)
    materials = {body.name: body.material for body in bodies}
    own = {
        (one.name, other.name): coefficient
        for one in objects
        for other in bodies
        if other is not one and number_between(table.pairs, one.name, other.name, materials) is None
    }
    return replace(table, pairs={**own, **table.pairs})
