"""Prepared engines that are kept with an assembly, so that the next question about a group costs the solve alone."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from functools import partial

from holdfast.assembly.assembly import Assembly
from holdfast.assembly.one_group import Part
from holdfast.base.arrays import Float
from holdfast.base.memory import Same
from holdfast.base.values import Value
from holdfast.engines.amendments import doubtful_contacts
from holdfast.engines.capabilities import fresh
from holdfast.engines.contract import Engine, State


def recalled(engine: Engine, whole: Assembly, part: Part, standing: Float | None, acceleration: Float | None) -> State:
    """Return an engine prepared for one part of the assembly ``whole``, from its memory or now.

    ``standing`` (6J,) are loads on all bodies of the whole; the other arguments are as in ``Engine.prepare``. Contacts
    of the part may be absent (doubtful_contacts.py). The state remembers no question that was asked before.
    """
    own = _own(part, standing)
    make = partial(doubtful_contacts.prepared, engine, part.assembly, own, acceleration)
    return _recalled(make, engine, whole, part.content, (own, acceleration), len(part.members))


def recalled_whole(engine: Engine, whole: Assembly, standing: Float | None, acceleration: Float | None) -> State:
    """Return an engine prepared for all of an assembly, with all contacts as detected, from its memory or now."""
    make = partial(engine.prepare, whole, standing, acceleration)
    return _recalled(make, engine, whole, Same(whole), (standing, acceleration), len(whole.movable))


def _recalled(
    make: Callable[[], State],
    engine: Engine,
    whole: Assembly,
    content: Same,
    loads: tuple[Float | None, Float | None],
    cost: int,
) -> State:
    """Return the engine's state for ``content`` under these loads; engines that are no values may change: not kept."""
    if not isinstance(engine, Value):
        return make()
    names = frozenset(whole.known_names)
    # the engine may name bodies and materials of the whole that are unknown in another one with the same part
    state, _ = whole.memory.recalled(
        key("state", engine, content, *loads), cost, lambda: (make(), names), valid=lambda known: known[1] <= names
    )
    return fresh(state)


def forget(engine: Engine, whole: Assembly, part: Part, standing: Float | None, acceleration: Float | None) -> None:
    """Drop what ``recalled`` would return."""
    if isinstance(engine, Value):
        whole.memory.forget(key("state", engine, part.content, _own(part, standing), acceleration))


def _own(part: Part, standing: Float | None) -> Float | None:
    """Return the loads on the bodies of the part, or None if there are none."""
    own = None if standing is None else standing[part.rows]
    return None if own is None or not own.any() else own


def key(what: str, engine: Value, content: Hashable, standing: Float | None, acceleration: Float | None) -> Hashable:
    """Return the key by which ``what`` an engine says of ``content`` under these loads is kept with an assembly."""
    loads = (None if load is None else load.tobytes() for load in (standing, acceleration))
    return (what, engine, content, *loads)
