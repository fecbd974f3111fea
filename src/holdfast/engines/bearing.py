"""What bodies bear on top and under pressure, beside the limits that they are given: who is crushed first.

On top a body bears the total force along gravity on its upper faces, friction included: on a slope the whole weight of
what rests there. Pressure is the normal force on a face over its area.

Only the contact forces of a verdict tell. Where more than one set of forces balances, they are those of its engine:
elastic contacts of equal stiffness for ``compliant``, any equilibrium for ``limit``.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Literal

import numpy as np

from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import Float
from holdfast.base.public import Record, number
from holdfast.contacts.tolerances import DEFAULT_ANGLE
from holdfast.engines.forces import NO_FORCE
from holdfast.engines.verdict import ContactForces, GroupVerdict
from holdfast.scene.body import Body
from holdfast.scene.hold import held_names

UNITS = {"top_load": "N", "pressure": "Pa"}
SIDE = float(np.sin(np.radians(DEFAULT_ANGLE)))  # a face that looks up or down by no more is a side
CRUSHED = 1 + NO_FORCE  # share of a limit beyond which a body is crushed: NO_FORCE is for rounding
UNCHECKED = "who is crushed was not asked here: stability, robustness, load_factor, transport_limits and carry ask it"


class Bearing(Record, kw_only=True):
    """How much a body bears, beside what it may bear.

    ``limit`` is its "top_load" [N] or its "pressure" [Pa], whichever ``kind`` says, and ``load`` what it bears in the
    same unit. ``by`` names the bodies that press, those that press most first.
    """

    body: str
    kind: Literal["top_load", "pressure"]
    load: float
    limit: float
    by: tuple[str, ...]

    plain = "body kind load limit by share"

    @property
    def share(self) -> float:
        """The load over the limit: above 1 the body is crushed."""
        return 0.0 if self.load == 0 else self.load / self.limit if self.limit > 0 else np.inf

    @property
    def crushed(self) -> bool:
        """Whether the load is above the limit, by more than rounding."""
        return self.share > CRUSHED

    @property
    def text(self) -> str:
        """The load, the limit and the share in words."""
        unit, where = UNITS[self.kind], "on top" if self.kind == "top_load" else "of pressure"
        text = f"{self.body} bears {number(self.load, unit)} of {number(self.limit, unit)} {where} ({self.share:.0%})"
        return f"{text}, {number(self.load - self.limit, unit)} too much" if self.crushed else text


def limited(bodies: Iterable[Body]) -> tuple[str, ...]:
    """Name the bodies that have a limit of what they bear."""
    return tuple(body.name for body in bodies if body.top_load is not None or body.pressure is not None)


def unchecked_limits(bodies: Iterable[Body]) -> tuple[str, ...]:
    """Return a note for answers that do not look at what bodies bear; none if no body has a limit."""
    return (UNCHECKED,) if limited(bodies) else ()


def bearings(
    assembly: Assembly,
    groups: Sequence[GroupVerdict],
    pressed: Float | None = None,
    names: Sequence[str] | None = None,
) -> tuple[Bearing, ...]:
    """Return what bodies with a limit bear, the largest share of a limit first: all of them, or those in ``names``.

    ``groups`` are the verdicts on the groups of the assembly that concern them. ``pressed`` (B,) [N] is how much loads
    press each body down, which counts as load on its top. A body is left out if forces on it are not known, as where a
    group that it belongs to, or that rests on it, does not stand, or where something holds it.
    """
    names = limited(assembly.bodies) if names is None else names
    if not names:
        return ()
    concerned = [group for group in groups if any(concerns(assembly, group.bodies, name) for name in names)]
    unknown = [group.bodies for group in concerned if group.verdict.forces is None]
    forces = [group.verdict.forces for group in concerned if group.verdict.forces is not None]
    held = held_names(assembly.scene.holds)  # which exert forces that nobody tells
    known = [n for n in names if n not in held and not any(concerns(assembly, bodies, n) for bodies in unknown)]
    pressing = _pressing(assembly, forces)
    loads = {} if pressed is None else dict(zip((body.name for body in assembly.bodies), pressed.tolist(), strict=True))
    found = [one for n in known for one in _borne(assembly, *pressing, assembly.scene.body(n), loads.get(n, 0.0))]
    return tuple(sorted(found, key=lambda one: -one.share))


def concerns(assembly: Assembly, group: Sequence[str], name: str) -> bool:
    """Tell whether a body belongs to a group or is fixed and touched by it."""
    if assembly.index[name] >= 0:
        return name in group
    return any(name in i.bodies and not set(group).isdisjoint(i.bodies) for i in assembly.interfaces)


def _pressing(assembly: Assembly, forces: Sequence[ContactForces]) -> tuple[Float, tuple[Float, Float]]:
    """Return the normal force (P,) [N] of each interface, and those (P,) down on upper faces of its second and first.

    Friction counts on upper faces, but not on sides and from below.
    """
    count, up = len(assembly.interfaces), assembly.scene.up
    normal, on_second, on_first = np.zeros((3, count))
    for each in forces:
        np.add.at(normal, each.interface, (each.force * each.normal).sum(axis=1))
        rising, slope = each.force @ up, each.normal @ up
        np.add.at(on_second, each.interface, np.where(slope < -SIDE, -rising, 0.0))
        np.add.at(on_first, each.interface, np.where(slope > SIDE, rising, 0.0))
    return normal, (on_second, on_first)


def _borne(
    assembly: Assembly, normal: Float, down: tuple[Float, Float], body: Body, pressed: float
) -> Iterable[Bearing]:
    """Yield what one body bears of each limit that it has; ``normal`` and ``down`` are as of ``_pressing``."""
    touching = [k for k, interface in enumerate(assembly.interfaces) if body.name in interface.bodies]
    other = {k: next(name for name in assembly.interfaces[k].bodies if name != body.name) for k in touching}
    none = NO_FORCE * assembly.weight
    cases: list[tuple[Literal["top_load", "pressure"], float, float, float, dict[int, float]]] = []
    if body.top_load is not None:
        side = {k: int(assembly.interfaces[k].bodies[1] != body.name) for k in touching}
        on_top = {k: max(float(down[side[k]][k]), 0.0) for k in touching}
        cases.append(("top_load", sum(on_top.values()) + pressed, body.top_load, none, on_top))
    if body.pressure is not None:
        pressing = {k: float(normal[k]) for k in touching if normal[k] > none}
        areas = {k: assembly.interfaces[k].area for k in pressing}
        each = {k: force / areas[k] if areas[k] > 0 else np.inf for k, force in pressing.items()}
        cases.append(("pressure", max(each.values(), default=0.0), body.pressure, 0.0, each))
    for kind, load, limit, least, each in cases:
        by = dict.fromkeys(other[k] for k in sorted(each, key=lambda k: -each[k]) if each[k] > least)
        yield Bearing(body=body.name, kind=kind, load=load if load > least else 0.0, limit=limit, by=tuple(by))
