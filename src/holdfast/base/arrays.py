"""Array types, and the checks of arrays that come from users. Inside holdfast arrays are read-only and trusted."""

from __future__ import annotations

import math
import operator
from collections.abc import Collection, Mapping, Sequence
from typing import Any, TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray

from holdfast.base.errors import HoldfastError, SceneError, message
from holdfast.base.ranges import PLACE, Range
from holdfast.base.text import is_text, quoted

Array = TypeVar("Array", bound=NDArray[Any])
Float: TypeAlias = NDArray[np.float64]
Int: TypeAlias = NDArray[np.int64]
Bool: TypeAlias = NDArray[np.bool_]
Objects: TypeAlias = NDArray[np.object_]

SAFE = 1e100  # the squares of lengths between 1 / SAFE and SAFE neither overflow nor underflow
LONGEST_NAME = 500  # largest number of characters of the name of a body, a material or a scene
# Types that NumPy would convert to numbers, but that are refused
NO_NUMBERS = (str, bytes, bool, complex, np.bool_, np.datetime64, np.timedelta64, type(None))


def frozen(array: Array) -> Array:
    """Make an array read-only, in place, and return it."""
    array.setflags(write=False)
    return array


def read_only(array: Array) -> Array:
    """Return ``array`` itself if it is read-only, otherwise a read-only copy, as its owner may still write to it."""
    return frozen(array.copy()) if array.flags.writeable else array


def checked(
    value: Any,  # noqa: ANN401 - anything a caller may pass
    shape: Sequence[int | None],
    where: str,
    *,
    within: Range | None = None,
    error: type[HoldfastError] = SceneError,
) -> Float:
    """Return a read-only float64 copy of ``value`` after checking that it has the given shape and is finite.

    None in ``shape`` allows any length. No number may be larger, with either sign, than the upper end of the range
    ``within``. Raises ``error`` if the check fails; ``where`` names the argument.
    """
    wanted = str(tuple(s if s is not None else "n" for s in shape)).replace("'", "")
    try:
        array = _numbers(value)
    except (TypeError, ValueError, OverflowError, RecursionError):
        raise error(message(where, f"got {quoted(value, 80)}", f"needs numbers of shape {wanted}")) from None
    fits = array.ndim == len(shape) and all(s is None or s == n for s, n in zip(shape, array.shape, strict=True))
    if not fits:
        raise error(message(where, f"has shape {array.shape}", f"needs shape {wanted}"))
    if not np.isfinite(array).all():
        raise error(message(where, f"contains {_first(array, ~np.isfinite(array))}", "needs finite numbers"))
    if within is not None and (np.abs(array) > within.largest).any():
        problem = f"contains {_first(array, np.abs(array) > within.largest)}"
        raise error(message(where, problem, f"needs numbers {within.most()}"))
    frozen(array)
    return array


def checked_sizes(
    value: Any,  # noqa: ANN401 - anything a caller may pass
    shape: Sequence[int | None],
    where: str,
    within: Range,
    error: type[HoldfastError] = SceneError,
) -> Float:
    """Return the array that ``checked`` accepts, after checking that all numbers are positive and in ``within``."""
    array = checked(value, shape, where, error=error)
    wrong = (array < within.least) | (array > within.largest)
    if wrong.any():
        raise error(message(where, f"is {array.tolist()}", f"needs numbers > 0, {within}"))
    return array


def checked_rows(
    value: Any,  # noqa: ANN401 - anything a caller may pass
    size: int,
    where: str,
    *,
    within: Range | None = None,
) -> tuple[Float, bool]:
    """Check numbers of shape (size,) or (n, size); return them as rows (n, size), and whether it was a single row."""
    try:
        single = np.ndim(value) == 1
    except ValueError:  # not an array: ``checked`` raises the error
        single = False
    return checked(value, (size,) if single else (None, size), where, within=within).reshape(-1, size), single


def checked_pushes(
    points: Any,  # noqa: ANN401 - anything a caller may pass
    directions: Any,  # noqa: ANN401 - anything a caller may pass
    where: str,
) -> tuple[Float, Float]:
    """Return the points (n, 3) and unit directions (n, 3) of pushes.

    Both arguments have the shape (n, 3) or (3,). A single point or direction is repeated to match the other. Raises
    SceneError if the numbers differ, a direction is zero, or something is not a finite number.
    """
    p = checked_rows(points, 3, f"{where}: points", within=PLACE)[0]
    e = checked_directions(directions, f"{where}: directions")
    count = max(len(p), len(e))
    if len(p) not in (1, count) or len(e) not in (1, count):
        problem = f"{len(p)} points and {len(e)} directions"
        raise SceneError(message(where, problem, "needs equally many, or one of either"))
    return np.broadcast_to(p, (count, 3)), np.broadcast_to(e, (count, 3))


def checked_directions(value: Any, where: str) -> Float:  # noqa: ANN401 - anything a caller may pass
    """Return directions (n, 3) or (3,) as read-only unit vectors (n, 3).

    Their lengths do not matter, however large or small. Raises SceneError if one of them is zero.
    """
    rows = checked_rows(value, 3, where)[0]
    if not rows.any(1).all():
        raise SceneError(message(where, "a direction is zero", "needs vectors with a length"))
    return frozen(unit(rows))


def checked_direction(value: Any, where: str) -> Float:  # noqa: ANN401 - anything a caller may pass
    """Return one direction (3,), not zero, as a read-only unit vector."""
    vector = checked(value, (3,), where)
    if not vector.any():
        raise SceneError(message(where, "is zero", "needs a vector with a length, such as (0, 0, 1)"))
    return frozen(unit(vector))


def checked_number(
    value: Any,  # noqa: ANN401 - anything a caller may pass
    where: str,
    *,
    minimum: float | None = None,
    above: float | None = None,
    below: float | None = None,
    within: Range | None = None,
    error: type[HoldfastError] = SceneError,
) -> float:
    """Return ``value`` as a finite float after checking its limits.

    It must be at least ``minimum``, greater than ``above`` and less than ``below``; None means no such limit. If
    ``within`` is given, its magnitude must not exceed the upper end of that range and, if ``above`` is given too, the
    number must not be below the lower end. Raises ``error`` if the check fails; a text is never a number, even if it
    looks like one. ``where`` names the argument.
    """
    limits = ((">=", minimum), (">", above), ("<", below))
    bounds = " and ".join(f"{sign} {end:g}" for sign, end in limits if end is not None)
    remedy = f"needs a finite number {bounds}".rstrip()
    try:
        number = _numbers(value).item() if np.ndim(value) == 0 else None
    except (TypeError, ValueError, OverflowError, RecursionError):
        number = None
    if number is None:
        raise error(message(where, f"got {quoted(value, 80)}", remedy))
    ends = (
        minimum is None or number >= minimum,
        above is None or number > above,
        below is None or number < below,
    )
    if not np.isfinite(number) or not all(ends):
        raise error(message(where, f"is {number:g}", remedy))
    if within is not None and (abs(number) > within.largest or (above is not None and number < within.least)):
        allowed = str(within) if above is not None else within.most()
        raise error(message(where, f"is {number:g}", f"needs a number {allowed}: are its units right?"))
    return number


def checked_whole(
    value: Any,  # noqa: ANN401 - anything a caller may pass
    where: str,
    least: int,
    most: int,
    error: type[HoldfastError] = SceneError,
) -> int:
    """Return ``value`` as an int after checking that it is a whole number from ``least`` to ``most``."""
    try:
        number = least - 1 if isinstance(value, bool | np.bool_) else operator.index(value)
    except TypeError:
        number = least - 1
    if not least <= number <= most:
        limit = f"at most {most:,}" if number > most else f"at least {least:,}"
        raise error(message(where, f"is {quoted(value)}", f"needs a whole number of {limit}"))
    return number


def checked_truth(value: Any, where: str, error: type[HoldfastError] = SceneError) -> bool:  # noqa: ANN401
    """Return ``value`` as a bool after checking that it is True or False; Python would take the text "no" as true."""
    if not isinstance(value, bool | np.bool_):
        raise error(message(where, f"is {quoted(value)}", "needs True or False"))
    return bool(value)


def checked_word(
    value: Any,  # noqa: ANN401 - anything a caller may pass
    known: Collection[str],
    where: str,
    error: type[HoldfastError] = SceneError,
) -> str:
    """Return ``value`` after checking that it is one of the ``known`` words."""
    if not isinstance(value, str) or value not in known:
        raise error(message(where, f"is {quoted(value)}", f"needs one of {', '.join(known)}"))
    return value


def checked_mapping(
    value: Any,  # noqa: ANN401 - anything a caller may pass
    where: str,
    example: str,
    error: type[HoldfastError] = SceneError,
) -> Mapping[Any, Any]:
    """Return ``value`` after checking that it is a dict or another mapping; ``example`` shows one."""
    if not isinstance(value, Mapping):
        raise error(message(where, f"is {quoted(value)}", f"needs a dict, as {example}"))
    return value


def checked_items(
    value: Any,  # noqa: ANN401 - anything a caller may pass
    where: str,
    what: str,
    error: type[HoldfastError] = SceneError,
) -> list[Any]:
    """Return the items of a list, a tuple or any other iterable except a text; ``what`` says what it should hold."""
    try:
        if isinstance(value, str | bytes):
            raise TypeError
        return list(value)
    except TypeError:
        raise error(message(where, f"is {quoted(value)}", f"needs a list of {what}")) from None


def checked_name(value: Any, where: str) -> str:  # noqa: ANN401 - anything a caller may pass
    """Return a name after checking that it is a text with at most LONGEST_NAME characters, and not blank.

    Lone surrogates are refused, because no file can hold them. All other characters are accepted; ``base/text.py``
    makes them printable where they are shown.
    """
    if not isinstance(value, str) or not value.strip():
        raise SceneError(message(where, f"is {quoted(value)}", "needs a non-empty text"))
    if len(value) > LONGEST_NAME:
        raise SceneError(message(where, f"has {len(value):,} characters", f"needs at most {LONGEST_NAME}"))
    if not is_text(value):
        raise SceneError(
            message(where, f"is {quoted(value)}", "needs a text without lone surrogates: check its encoding")
        )
    return str(value)  # a text of NumPy is a plain one here, and in files


def objects(values: Sequence[Any]) -> Objects:
    """Return a read-only object array (n,) of ``values``, so that NumPy can select and compare rows of answers."""
    array = np.empty(len(values), dtype=object)
    for k, value in enumerate(values):
        array[k] = value
    return frozen(array)


def unit(vector: Float) -> Float:
    """Return ``vector`` (..., 3) divided by its length along the last axis.

    Very long and very short vectors are first divided by their largest component, because their squares would otherwise
    overflow or underflow.
    """
    if vector.shape == (3,):  # mostly so; NumPy takes ten times as long to say the same
        x, y, z = vector.tolist()
        around = math.sqrt(x * x + y * y + z * z)
        if 1 / SAFE < around < SAFE:
            return np.asarray(vector / around, dtype=np.float64)
    with np.errstate(over="ignore", under="ignore"):
        length = np.linalg.norm(vector, axis=-1, keepdims=True)
    if not ((length > 1 / SAFE) & (length < SAFE)).all():
        vector = vector / np.where(vector.any(-1, keepdims=True), np.abs(vector).max(-1, keepdims=True), 1.0)
        length = np.linalg.norm(vector, axis=-1, keepdims=True)
    return np.asarray(vector / length, dtype=np.float64)


def _numbers(value: Any) -> Float:  # noqa: ANN401
    """Return a float64 copy of numbers; raise TypeError or ValueError for texts, truth values and complex numbers."""
    array = np.asarray(value)
    if array.dtype.kind not in "iufO" and array.size:
        raise TypeError("no numbers")
    if array.dtype.kind == "O" and any(isinstance(part, NO_NUMBERS) for part in array.flat):
        raise TypeError("no numbers")
    return np.array(array, dtype=np.float64)


def _first(array: Float, wrong: Bool) -> str:
    index = tuple(int(i) for i in np.argwhere(wrong)[0])
    return f"{array[index]} at index {index}"
