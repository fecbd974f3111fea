"""Options of the form NAME=VALUE, which may be repeated."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from holdfast.base.arrays import Float
from holdfast.base.errors import HoldfastError, message
from holdfast.base.text import quoted
from holdfast.scene.formats.links import pose_of

POSE = "BODY=X,Y,Z or BODY=X,Y,Z,ROLL,PITCH,YAW"


def wrong(option: str, text: str, form: str) -> HoldfastError:
    """Return the error for an option whose text does not have the ``form``."""
    return HoldfastError(message(option, f"is {quoted(text)}", f"needs {form}"))


def assigned(option: str, texts: Sequence[str], form: str, *, last: bool = True) -> dict[str, str]:
    """Return the values of texts NAME=VALUE by name, split at the last ``=``, as names may hold any character.

    With ``last=False`` they are split at the first ``=``, as values may hold any character. Raises HoldfastError for a
    text of another form, and for a name that occurs twice.
    """
    found: dict[str, str] = {}
    for text in texts:
        name, equals, value = text.rpartition("=") if last else text.partition("=")
        if not equals or not name or not value:
            raise wrong(option, text, form)
        if name in found:
            raise HoldfastError(message(option, f"is given twice for {quoted(name)}", "give it once"))
        found[name] = value
    return found


def numbers(option: str, text: str, form: str) -> list[float]:
    """Return numbers that are separated by commas; raise HoldfastError, with the ``form``, for anything else."""
    try:
        return [float(word) for word in text.split(",")]
    except ValueError:
        raise wrong(option, text, form) from None


def number(option: str, text: str, form: str) -> float:
    """Return one number; raise HoldfastError, with the ``form``, for anything else."""
    found = numbers(option, text, form)
    if len(found) != 1:
        raise wrong(option, text, form)
    return found[0]


def poses(texts: Sequence[str]) -> dict[str, Float]:
    """Return the poses (4, 4) of bodies by name, from positions [m] and optionally angles in degrees.

    The angles are about the fixed axes x, y and z, in this order, as in URDF.
    """
    found = {}
    for name, value in assigned("--pose", texts, POSE).items():
        given = numbers("--pose", value, POSE)
        if len(given) not in (3, 6) or not np.isfinite(given).all():
            raise wrong("--pose", f"{name}={value}", POSE)
        found[name] = pose_of(given[:3], np.deg2rad([*given[3:], 0.0, 0.0, 0.0][:3]).tolist())
    return found


def turns(texts: Sequence[str]) -> list[str]:
    """Return a remark with the angles in degrees for each pose that has angles."""
    found = []
    for name, value in assigned("--pose", texts, POSE).items():
        angles = numbers("--pose", value, POSE)[3:]
        if any(angles):
            found.append(f"{name} by {', '.join(f'{angle:g}°' for angle in angles)} about x, y and z")
    return found


def of_all_and_each(option: str, texts: Sequence[str], form: str) -> tuple[float | None, dict[str, float]]:
    """Split texts into a number for all (None if there is none) and numbers by name."""
    alone = [text for text in texts if "=" not in text]
    if len(alone) > 1:
        raise HoldfastError(message(option, f"is given {len(alone)} times for all", "give it once"))
    each = assigned(option, [text for text in texts if "=" in text], form)
    of_all = number(option, alone[0], form) if alone else None
    return of_all, {name: number(option, value, form) for name, value in each.items()}
