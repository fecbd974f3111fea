"""Array types, and the checks of arrays that come from users. Inside holdfast arrays are read-only and trusted."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray

from holdfast.base.errors import HoldfastError, SceneError, message

Array = TypeVar("Array", bound=NDArray[Any])
Float: TypeAlias = NDArray[np.float64]
Int: TypeAlias = NDArray[np.int64]
Bool: TypeAlias = NDArray[np.bool_]
Objects: TypeAlias = NDArray[np.object_]


def frozen(array: Array) -> Array:
    """Make an array read-only, in place, and return it."""
    array.setflags(write=False)
    return array


def kept(array: Array) -> Array:
    """Return the same array if it is read-only, else a read-only copy, because its owner may write to it later."""
    return frozen(array.copy()) if array.flags.writeable else array


def checked(
    value: Any,  # noqa: ANN401 - anything a caller may pass
    shape: Sequence[int | None],
    where: str,
    *,
    error: type[HoldfastError] = SceneError,
) -> Float:
    """Return a read-only float64 copy of ``value`` after checking that it has the given shape and is finite.

    None in ``shape`` allows any length. Raises ``error`` if the check fails; ``where`` names the argument.
    """
    wanted = str(tuple(s if s is not None else "n" for s in shape)).replace("'", "")
    try:
        array = np.array(value, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        raise error(message(where, f"got {value!r:.80}", f"needs numbers of shape {wanted}")) from None
    fits = array.ndim == len(shape) and all(s is None or s == n for s, n in zip(shape, array.shape, strict=True))
    if not fits:
        raise error(message(where, f"has shape {array.shape}", f"needs shape {wanted}"))
    if not np.isfinite(array).all():
        raise error(message(where, f"contains {_first_not_finite(array)}", "needs finite numbers"))
    frozen(array)
    return array


def checked_pushes(
    points: Any,  # noqa: ANN401 - anything a caller may pass
    directions: Any,  # noqa: ANN401 - anything a caller may pass
    where: str,
) -> tuple[Float, Float]:
    """Return the points (n, 3) and unit directions (n, 3) of pushes.

    Both arguments have the shape (n, 3) or (3,). A single point or direction is repeated to match the other. Raises
    SceneError if the numbers differ, a direction is zero, or something is not a finite number.
    """
    p, e = _rows(points, f"{where}: points"), _rows(directions, f"{where}: directions")
    count = max(len(p), len(e))
    if len(p) not in (1, count) or len(e) not in (1, count):
        problem = f"{len(p)} points and {len(e)} directions"
        raise SceneError(message(where, problem, "needs equally many, or one of either"))
    p, e = np.broadcast_to(p, (count, 3)), np.broadcast_to(e, (count, 3))
    if not (np.linalg.norm(e, axis=1) > 0).all():
        raise SceneError(message(where, "a direction is zero", "needs vectors with a length"))
    return p, unit(e)


def checked_number(
    value: Any,  # noqa: ANN401 - anything a caller may pass
    where: str,
    *,
    minimum: float | None = None,
    above: float | None = None,
    error: type[HoldfastError] = SceneError,
) -> float:
    """Return ``value`` as a finite float, after checking that it is at least ``minimum`` and greater than ``above``.

    None means no such limit. Raises ``error`` if the check fails; ``where`` names the argument.
    """
    bound = f" >= {minimum:g}" if minimum is not None else f" > {above:g}" if above is not None else ""
    remedy = f"needs a finite number{bound}"
    try:
        number = float(str(value) if isinstance(value, bool) else value)
    except (TypeError, ValueError, OverflowError):
        raise error(message(where, f"got {value!r:.80}", remedy)) from None
    if not np.isfinite(number) or (minimum is not None and number < minimum) or (above is not None and number <= above):
        raise error(message(where, f"is {number:g}", remedy))
    return number


def objects(values: Sequence[Any]) -> Objects:
    """Return a read-only array (n,) of any objects, so that rows of answers can be selected and compared together."""
    array = np.empty(len(values), dtype=object)
    for k, value in enumerate(values):
        array[k] = value
    return frozen(array)


def unit(vector: Float) -> Float:
    """Return ``vector`` (..., 3) divided by its length along the last axis."""
    return np.asarray(vector / np.linalg.norm(vector, axis=-1, keepdims=True), dtype=np.float64)


def _rows(value: Any, where: str) -> Float:  # noqa: ANN401
    array = np.asarray(value, dtype=object)
    return checked(value, (3,), where)[None] if array.ndim == 1 else checked(value, (None, 3), where)


def _first_not_finite(array: Float) -> str:
    index = tuple(int(i) for i in np.argwhere(~np.isfinite(array))[0])
    return f"{array[index]} at index {index}"
