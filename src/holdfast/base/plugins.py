"""Plug-ins: engines and formats of other packages. None is loaded unless somebody names it, which no file can.

A package says that it has one by an entry point of the group ``holdfast.plugins``.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

from holdfast.base.errors import MOST_NAMES, HoldfastError, message
from holdfast.base.text import listed, quoted

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

GROUP = "holdfast.plugins"

LOADED: dict[str, str] = {}  # what ``load_plugin`` returned in this process, by name


def load_plugin(name: str) -> str:
    """Load the plug-in of an installed package, and return its module, its package and the version.

    ``name`` is that of an entry point of the group ``holdfast.plugins``. It stands for a module, which is imported, or
    for a function without arguments, which is called. A plug-in is loaded once. Raises HoldfastError if no package or
    more than one has it, or if it fails.
    """
    if name in LOADED:
        return LOADED[name]
    found = _installed()
    if name not in found:
        known = f"installed: {listed(sorted(found), MOST_NAMES)}" if found else "none is installed"
        problem = f"{quoted(name)} is not installed"
        raise HoldfastError(message("plug-in", problem, f"{known}; install the package that has it"))
    if len(found[name]) > 1:
        problem = f"several packages have it: {listed([_described(each) for each in found[name]])}"
        raise HoldfastError(message(f"plug-in {quoted(name)}", problem, "uninstall all but one"))
    point = found[name][0]
    try:
        home = import_module(point.module)
        if point.attr:
            getattr(home, point.attr)()
    except Exception as cause:  # whatever a plug-in may raise
        problem = f"{_described(point)}: {type(cause).__name__}: {cause}"
        raise HoldfastError(message(f"plug-in {quoted(name)}", problem, "update or repair that package")) from cause
    LOADED[name] = _described(point)
    return LOADED[name]


def plugin_notes() -> list[str]:
    """Return a note for each plug-in that is loaded."""
    return [f"plug-in {name} is loaded: {text}" for name, text in LOADED.items()]


def installed_plugins() -> dict[str, str]:
    """Return the module, the package and the version of each plug-in that could be loaded, by name."""
    return {name: listed([_described(each) for each in points]) for name, points in sorted(_installed().items())}


def _installed() -> dict[str, list[EntryPoint]]:
    """Return the entry points by name: one each, unless several packages have the same name."""
    from importlib.metadata import entry_points  # `import holdfast` costs next to nothing without it

    found: dict[str, list[EntryPoint]] = {}
    for point in entry_points(group=GROUP):
        found.setdefault(point.name, []).append(point)
    return found


def _described(point: EntryPoint) -> str:
    package = point.dist
    return f"{point.value} of package {package.name} {package.version}" if package else point.value
