"""Convex sets in files: JSON for any language, NPZ for NumPy; the same names in both.

``format``, ``engine``, ``claim``, ``inner`` and ``outer`` (A and b of A x <= b), ``vertices``, ``bound``, ``gap``,
``gap_wanted``, ``solves``, ``units``, ``frame``, ``notes``. In NPZ the polyhedra are ``inner_A`` and so on.
"""

from __future__ import annotations

import io
import json
import os
from pathlib import Path
from typing import TYPE_CHECKING, Any
from zipfile import BadZipFile

import numpy as np

from holdfast.base.arrays import Float, checked, checked_number
from holdfast.base.errors import HoldfastError, located, message
from holdfast.base.files import write_atomically
from holdfast.engines.answers import Claim

if TYPE_CHECKING:
    from holdfast.queries.sets import ConvexSet

FORMAT = "holdfast-set/1"
SUFFIXES = (".json", ".npz")
POLYHEDRA = ("inner", "outer")
TEXTS = ("engine", "claim", "frame")


def save_set(value: ConvexSet, path: str | os.PathLike[str]) -> None:
    """Write a convex set; the suffix of ``path`` tells the format."""
    data: dict[str, Any] = {"format": FORMAT, "engine": value.engine, "claim": value.claim.value}
    data |= {name: dict(zip("Ab", getattr(value, name), strict=True)) for name in POLYHEDRA}
    names = ("vertices", "bound", "gap", "gap_wanted", "solves", "units", "frame", "notes")
    data |= {name: getattr(value, name) for name in names}
    if _suffix(path) == ".json":
        text = json.dumps(data, allow_nan=False, default=np.ndarray.tolist)
        write_atomically(path, (text + "\n").encode())
        return
    flat: dict[str, Any] = {f"{name}_{part}": array for name in POLYHEDRA for part, array in data.pop(name).items()}
    stream = io.BytesIO()
    np.savez(stream, allow_pickle=False, **flat, **data)
    write_atomically(path, stream.getvalue())


def read_set(path: str | os.PathLike[str]) -> dict[str, Any]:
    """The fields of a convex set from a file, checked."""
    read = _json if _suffix(path) == ".json" else _npz
    with located(str(path)):
        try:
            data = read(Path(path))
            return _fields(data)
        except OSError as cause:
            raise HoldfastError(message("set", f"cannot be read: {cause.strerror or cause}", "name a file")) from cause
        except (KeyError, TypeError, ValueError, BadZipFile) as cause:
            remedy = "needs a file written by ConvexSet.save"
            raise HoldfastError(message("set", f"is not one ({type(cause).__name__}: {cause})", remedy)) from cause


def _fields(data: dict[str, Any]) -> dict[str, Any]:
    if data["format"] != FORMAT:
        raise HoldfastError(message("format", f"is {data['format']!r:.40}", f"needs {FORMAT!r}"))
    bound = checked(data["bound"], (None,), "bound")
    dimension = len(bound)
    fields: dict[str, Any] = {name: str(data[name]) for name in TEXTS}
    fields["claim"] = Claim(fields["claim"])
    fields |= {name: _polyhedron(data[name], dimension, name) for name in POLYHEDRA}
    fields |= {name: tuple(str(item) for item in data[name]) for name in ("units", "notes")}
    fields |= {name: checked_number(data[name], name, minimum=0) for name in ("gap", "gap_wanted")}
    fields["vertices"] = checked(data["vertices"], (None, dimension), "vertices")
    return fields | {"bound": bound, "solves": int(data["solves"])}


def _polyhedron(value: dict[str, Any], dimension: int, where: str) -> tuple[Float, Float]:
    b = checked(value["b"], (None,), f"{where}: b")
    A = checked(np.reshape(value["A"], (-1, dimension)), (len(b), dimension), f"{where}: A")
    if not (b > 0).all():
        raise HoldfastError(message(f"{where}: b", f"has {b.min():g}", "needs positive numbers: 0 is in the set"))
    return A, b


def _json(path: Path) -> dict[str, Any]:
    data: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return data


def _npz(path: Path) -> dict[str, Any]:
    with np.load(path, allow_pickle=False) as archive:
        data = {name: archive[name] for name in archive.files}
    whole = {name: item.item() if item.ndim == 0 else item for name, item in data.items()}
    return whole | {name: {part: data[f"{name}_{part}"] for part in "Ab"} for name in POLYHEDRA}


def _suffix(path: str | os.PathLike[str]) -> str:
    suffix = Path(path).suffix.lower()
    if suffix not in SUFFIXES:
        raise HoldfastError(
            message(f"{path}", "has another suffix", f"name a file that ends in {' or '.join(SUFFIXES)}")
        )
    return suffix
