"""The scenes that come with holdfast, by name; examples and tests use them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType

from holdfast.base.errors import SceneError, message, nearest_of
from holdfast.base.text import quoted
from holdfast.scene.formats.registry import load_scene
from holdfast.scene.scene import Scene
from holdfast.scene.shipped import blocks


def tabletop() -> Scene:
    """A scene with meshes from files: a tray with a mug and a bottle, and two books, one of which carries a bottle.

    The upper book overhangs the lower one, and its bottle stands on the overhang.
    """
    return load_scene(Path(__file__).parent / "tabletop" / "tabletop.yaml")


_BUILDERS: Mapping[str, Callable[[], Scene]] = MappingProxyType(
    {
        builder.__name__: builder
        for builder in (
            blocks.cube,
            blocks.stack,
            blocks.table,
            blocks.tall_table,
            blocks.wall2x2,
            blocks.bonded_wall,
            blocks.slope,
            blocks.slope_two,
            blocks.cantilever,
            blocks.arch,
            blocks.v_groove,
            blocks.wedged,
            blocks.wedged_floor,
            tabletop,
        )
    }
)


def shipped_scenes() -> tuple[str, ...]:
    """Return the names of the scenes that come with holdfast.

    ``cube``, ``stack`` and ``table`` (a slab on two legs) are those of the paper, and so are ``slope`` and
    ``slope_two``, a movable wedge with one or two cubes on it, and ``cantilever``, a plank across a column with a load
    and a counterweight. ``tall_table`` has longer legs; ``wall2x2`` and ``bonded_wall`` are bricks in quarter bond, 4
    and 50 of them; ``arch`` has five voussoirs. In ``v_groove`` a cube stands on its edge; in ``wedged`` and
    ``wedged_floor`` one is between two walls. ``tabletop`` is made of meshes: books, bottles, a tray, a mug.
    """
    return tuple(_BUILDERS)


def shipped_scene(name: str) -> Scene:
    """Return the shipped scene with this name; raises SceneError, with the most similar name, if there is none."""
    if not isinstance(name, str) or name not in _BUILDERS:
        raise SceneError(message("shipped scene", f"{quoted(name)} is unknown", nearest_of(name, _BUILDERS)))
    return _BUILDERS[name]()
