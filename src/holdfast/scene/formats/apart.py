"""Reading in a process of its own, with limits of memory and time, where a library may ask for more than a file shows.

Workers of batches have such limits already, and read everything themselves.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from importlib import import_module
from pathlib import Path
from typing import Any

from holdfast.base.borders.outcomes import DONE
from holdfast.base.borders.supervisor import Limits, Supervisor
from holdfast.base.errors import HoldfastError, HoldfastWarning, SceneError, message, warn
from holdfast.scene.formats.source import Source
from holdfast.scene.scene import Scene

LIMITS = Limits(seconds=30.0, megabytes=2_000.0)


def read_apart(read: Callable[..., Scene], source: Source, options: Mapping[str, Any]) -> Scene:
    """Return ``read(source, **options)``, called in a process of its own; ``read`` is a function of a module.

    Raises what it raises, and SceneError if it needs more memory or time than LIMITS, or ends its process. A worker
    (``worker.is_limited``) must not call this.
    """
    with Supervisor("holdfast.scene.formats.apart:answered", limits=LIMITS) as reader:
        reply = reader.ask((read.__module__, read.__name__, source.path, source.given, dict(options)))
    if reply.outcome != DONE:
        problem = f"cannot be read with {LIMITS.megabytes:,.0f} MB and {LIMITS.seconds:g} s: {reply.problem}"
        raise SceneError(message(str(source.path), problem, "simplify the file"))
    found, told = reply.value
    for text in told:
        warn(text)
    if isinstance(found, HoldfastError):
        raise found
    scene: Scene = found
    return scene


def answered(
    item: tuple[str, str, Path, bytes | None, dict[str, Any]], _: Callable[[Any], None]
) -> tuple[Scene | HoldfastError, list[str]]:
    """Read a file in the worker; return the scene, or the error, and the texts of warnings."""
    module, name, path, given, options = item
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            found: Scene | HoldfastError = getattr(import_module(module), name)(Source(path, given), **options)
        except HoldfastError as error:
            found = type(error)(str(error))
    return found, [str(each.message) for each in caught if isinstance(each.message, HoldfastWarning)]
