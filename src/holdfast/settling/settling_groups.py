"""Groups of bodies that may touch while they come to rest; each is settled on its own."""

from __future__ import annotations

from collections.abc import Iterable

from holdfast.contacts.neighbours import neighbours
from holdfast.scene.scene import Scene


def groups_within(scene: Scene, gap: float) -> tuple[tuple[str, ...], ...]:
    """Return the names of the movable bodies in groups; bodies are connected if their boxes come within ``gap`` [m].

    Fixed bodies do not connect groups. Groups and names are in the order of the scene.
    """
    near = [(a.name, b.name) for a, b in neighbours(scene, gap) if not (a.fixed or b.fixed)]
    return joined([body.name for body in scene.movable], near)


def joined(names: Iterable[str], pairs: Iterable[tuple[str, str]]) -> tuple[tuple[str, ...], ...]:
    """Return the groups of ``names`` that ``pairs`` connect, in the order of the names."""
    group = {name: [name] for name in names}
    order = {name: k for k, name in enumerate(group)}
    for a, b in pairs:
        if group[a] is not group[b]:
            group[a] += group[b]
            for name in group[b]:
                group[name] = group[a]
    found = {id(g): tuple(sorted(g, key=order.__getitem__)) for g in group.values()}
    return tuple(sorted(found.values(), key=lambda g: order[g[0]]))


def alone(scene: Scene, group: Iterable[str]) -> Scene:
    """Return the scene with the bodies of one group and the fixed bodies only."""
    kept = set(group)
    return scene.without([body.name for body in scene.movable if body.name not in kept])
