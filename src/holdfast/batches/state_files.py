"""Files with states of a simulation, one a row of numbers: .npy, .npz, .csv and .hdf5; nothing in them is run.

Robomimic and LIBERO write HDF5 with the trajectory of each demonstration in ``data/demo_0/states``; its first row is
the start state. Arrays of objects are pickles, which may run code, and are refused, as are links of HDF5 to other
files.
"""

from __future__ import annotations

import io
import zipfile
from collections.abc import Callable, Iterator, Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from holdfast.base.arrays import Float
from holdfast.base.borders.foreign import foreign
from holdfast.base.borders.supervisor import Limits, Supervisor
from holdfast.base.borders.worker import DONE
from holdfast.base.errors import HoldfastError, installing, message
from holdfast.base.files import check_ordinary, read_ordinary, write_atomically
from holdfast.base.text import listed, quoted

MOST_BYTES = 2_000_000_000  # of a file of states
MOST_NUMBERS = 50_000_000  # of all states: 400 MB
SUFFIXES = (".npy", ".npz", ".csv", ".hdf5", ".h5")
PICKLES = (".pkl", ".pickle", ".pt", ".pth", ".init", ".pruned_init")
NAMES = ("states", "qpos", "init_states")  # of arrays and datasets, the first of these that is there
DEMOS = "data"  # the group of demonstrations in HDF5
APART = Limits(seconds=120.0, megabytes=4_000.0)  # of the process that reads HDF5
PLAIN = "biuf"  # kinds of numbers
UNPICKLED = "pickles may run code: write its array with numpy.savez('states.npz', array)"
WHAT = "file of states"


class StateRows(NamedTuple):
    """The states of a file: their ``names``, the numbers (n, w), and how many rows it has that are not among them."""

    names: tuple[str, ...]
    values: Float
    later: int = 0


def read_states(path: Path, *, every: bool = False) -> StateRows:
    """Read the states of a file; of HDF5 the first of each demonstration, or with ``every`` all of them.

    Rows of other files are named by their numbers, from 0. Raises HoldfastError for anything but a table of numbers.
    """
    suffix = path.suffix.lower()
    size = check_ordinary(path, WHAT, error=HoldfastError)
    if suffix in PICKLES:
        raise HoldfastError(message(str(path), "is a pickle", UNPICKLED))
    if suffix not in SUFFIXES:
        raise HoldfastError(message(str(path), f"suffix {quoted(path.suffix)}", f"needs one of {', '.join(SUFFIXES)}"))
    if size > MOST_BYTES:
        raise HoldfastError(message(str(path), f"is {size:,} bytes", f"the limit is {MOST_BYTES:,}: divide it"))
    if suffix in (".hdf5", ".h5"):
        with Supervisor("holdfast.batches.state_files:answered", limits=APART) as reader:  # in C, and of anybody
            reply = reader.ask((path, every))
        if reply.outcome != DONE:
            raise HoldfastError(message(str(path), f"cannot be read: {reply.problem}", "write it again"))
        if isinstance(reply.value, HoldfastError):
            raise reply.value
        found: StateRows = reply.value
        return found
    read: Callable[[Path], Float] = {".npy": _npy, ".npz": _npz, ".csv": lambda place: _csv(place)[1]}[suffix]
    with foreign(str(path), "is no table of states", "write it again", HoldfastError):
        values = read(path)
    return StateRows(tuple(map(str, range(len(values)))), values)


def write_states(path: Path, rows: dict[str, Float], source: Path) -> None:
    """Write the file ``source`` to ``path``, with other numbers (w,) in the ``rows`` of these names."""
    content = read_ordinary(source, WHAT, most=MOST_BYTES, error=HoldfastError, too_large="divide it")
    with foreign(str(path), "cannot be written", "read the file again", HoldfastError):
        write = {".npy": _npy_with, ".npz": _npz_with, ".csv": _csv_with}.get(source.suffix.lower(), _hdf5_with)
        write_atomically(path, write(content, rows, source))


def answered(item: tuple[Path, bool], _: Callable[[Any], None]) -> StateRows | HoldfastError:
    """Read an HDF5 file in a worker."""
    path, every = item
    try:
        with foreign(str(path), "is no HDF5 file with states", "write it again", HoldfastError):
            return _hdf5(path, every=every)
    except HoldfastError as error:
        return HoldfastError(str(error))


def _checked(shape: Sequence[int], dtype: Any, where: str) -> None:  # noqa: ANN401 - a dtype
    """Raise HoldfastError unless an array with this shape and type is a table of numbers, or one row, that fits."""
    if dtype.hasobject:
        raise HoldfastError(message(where, "holds objects, which are pickled", UNPICKLED))
    if dtype.kind not in PLAIN or len(shape) not in (1, 2):
        raise HoldfastError(
            message(where, f"has shape {tuple(shape)} of {dtype}", "needs numbers, a row for each state")
        )
    if not all(shape):
        raise HoldfastError(message(where, f"is empty, {tuple(shape)}", "needs at least one state"))
    if np.prod([float(n) for n in shape]) > MOST_NUMBERS:
        raise HoldfastError(message(where, f"has shape {tuple(shape)}", f"the limit is {MOST_NUMBERS:,}: divide it"))


def checked_rows(values: Any, where: str) -> Float:  # noqa: ANN401 - an array of anything
    """Return an array as states (n, w); raise HoldfastError unless it holds numbers, one row for each state."""
    array = np.asarray(values)
    _checked(array.shape, array.dtype, where)
    return np.atleast_2d(array.astype(np.float64))


def _array(stream: Any, where: str) -> Float:  # noqa: ANN401 - a binary stream
    """Return the array in .npy format; its header is checked before any memory is taken."""
    version = np.lib.format.read_magic(stream)
    read = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
    shape, _, dtype = read(stream)
    _checked(shape, dtype, where)
    stream.seek(0)
    return checked_rows(np.lib.format.read_array(stream, allow_pickle=False), where)


def _npy(path: Path) -> Float:
    with path.open("rb") as stream:
        return _array(stream, str(path))


def _npz(path: Path) -> Float:
    with zipfile.ZipFile(path) as archive:
        name = _member(archive, str(path))
        with archive.open(name) as stream:
            return _array(stream, f"{path}: {name.removesuffix('.npy')}")


def _member(archive: zipfile.ZipFile, where: str) -> str:
    """Return the name of the member of an .npz file that holds the states: a known one, or the only one."""
    names = [each for each in archive.namelist() if each.endswith(".npy")]
    if any(each.endswith(".pkl") for each in archive.namelist()):
        raise HoldfastError(message(where, "is a pickle", UNPICKLED))
    chosen = [f"{name}.npy" for name in NAMES if f"{name}.npy" in names] or names
    if not chosen or (len(names) > 1 and chosen is names):
        known = listed([each.removesuffix(".npy") for each in names]) or "none"
        raise HoldfastError(message(where, f"its arrays are {known}", f"needs one of {', '.join(NAMES)}, or one array"))
    return chosen[0]


def _csv(path: Path) -> tuple[list[str], Float]:
    """Return the lines before the first row of numbers, of which the names of columns may be one, and the rows."""
    content = read_ordinary(path, WHAT, most=10 * MOST_NUMBERS, error=HoldfastError, too_large="divide it")
    lines = content.decode("utf-8-sig").splitlines()
    head = [lines[0]] if lines and _numbers(lines[0]) is None else []
    rows: list[list[float]] = []
    for number, line in enumerate(lines[len(head) :], len(head) + 1):
        row = _numbers(line)
        if row is None:
            remedy = "needs numbers with commas between them"
            raise HoldfastError(message(f"{path}, line {number}", f"is {quoted(line, 80)}", remedy))
        if rows and row and len(row) != len(rows[0]):
            problem = f"has {len(row)} numbers, the first row {len(rows[0])}"
            raise HoldfastError(message(f"{path}, line {number}", problem, "needs as many in every row"))
        rows += [row] if row else []
    return head, checked_rows(rows, str(path))


def _numbers(line: str) -> list[float] | None:
    """Return the numbers of a line, none if it is empty; None if something in it is no number."""
    try:
        return [float(text) for text in line.split(",")] if line.strip() else []
    except ValueError:
        return None


def _hdf5(path: Path, *, every: bool) -> StateRows:
    """Return the states of an HDF5 file: of ``states`` itself, or of each demonstration."""
    names, parts, later = [], [], 0
    with _opened(path) as file:
        for name, data in _datasets(file, str(path)):
            rows = data[()] if every or not name else data[:1]
            later += 0 if every or not name or data.ndim == 1 else len(data) - 1
            values = checked_rows(rows, f"{path}: {name or data.name}")
            names += [f"{name}/{k}".strip("/") if every or not name else name for k in range(len(values))]
            parts.append(values)
    widths = sorted({part.shape[1] for part in parts})
    if len(widths) > 1:
        raise HoldfastError(message(str(path), f"rows have {listed(widths)} numbers", "needs states of one model"))
    return StateRows(tuple(names), np.vstack(parts), later)


def _opened(path: Path | io.BytesIO, mode: str = "r") -> Any:  # noqa: ANN401 - h5py has no types
    if find_spec("h5py") is None:
        raise HoldfastError(message(str(path), "needs h5py, which is not installed", installing("states")))
    import h5py

    return h5py.File(path, mode)


def _datasets(file: Any, where: str) -> Iterator[tuple[str, Any]]:  # noqa: ANN401 - h5py has no types
    """Yield the datasets of states with the name of their demonstration, "" for one of the whole file, in order."""
    whole = next((name for name in NAMES if name in file), None)
    group = _inside(file, DEMOS, where) if whole is None else None
    if whole is None and group is None:
        raise HoldfastError(message(where, "has no states", f"needs {NAMES[0]}, or {DEMOS}/demo_0/{NAMES[0]} ..."))
    total = 0
    for name in [""] if group is None else sorted(group, key=_in_order):
        home = file if group is None else _inside(group, name, where)
        data = _inside(home, whole or NAMES[0], where)
        place = f"{where}: {name or whole}"
        if data is None or not hasattr(data, "shape") or data.shape is None:
            raise HoldfastError(message(place, f"has no dataset {NAMES[0]}", "leave it out, or write it again"))
        _checked(data.shape, data.dtype, place)
        if data.is_virtual or data.external:
            raise HoldfastError(message(place, "lies in another file", "copy it into this one"))
        total += data.size
        if total > MOST_NUMBERS:
            raise HoldfastError(message(where, f"has over {MOST_NUMBERS:,} numbers", "divide it"))
        yield name, data
    if group is not None and not len(group):
        raise HoldfastError(message(where, f"{DEMOS} is empty", "needs at least one demonstration"))


def _inside(group: Any, name: str, where: str) -> Any:  # noqa: ANN401 - h5py has no types
    """Return a member of a group, None if it is missing; raise HoldfastError for a link to elsewhere."""
    import h5py

    if not isinstance(group, h5py.Group) or name not in group:
        return None
    if not isinstance(group.get(name, getlink=True), h5py.HardLink):
        raise HoldfastError(message(f"{where}: {name}", "is a link", "copy what it leads to into this file"))
    return group[name]


def _in_order(name: str) -> tuple[int, str]:
    """Return the key by which demo_2 comes before demo_10."""
    digits = name.rpartition("_")[2]
    return (int(digits) if digits.isascii() and digits.isdecimal() and len(digits) < 10 else -1, name)


def _changed(values: Any, rows: dict[str, Float]) -> Any:  # noqa: ANN401 - an array
    """Return a table, or a single row, with other numbers in the rows of these numbers."""
    table = np.array(values)
    for name, row in rows.items():
        np.atleast_2d(table)[int(name)] = row  # a view of a single row
    return table


def _npy_with(content: bytes, rows: dict[str, Float], _: Path) -> bytes:
    stream = io.BytesIO()
    np.save(stream, _changed(np.load(io.BytesIO(content), allow_pickle=False), rows))
    return stream.getvalue()


def _npz_with(content: bytes, rows: dict[str, Float], source: Path) -> bytes:
    stream = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(content)) as old, zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as new:
        name = _member(old, str(source))
        for each in old.infolist():
            own = old.read(each)
            new.writestr(each.filename, _npy_with(own, rows, source) if each.filename == name else own)
    return stream.getvalue()


def _csv_with(_: bytes, rows: dict[str, Float], source: Path) -> bytes:
    head, values = _csv(source)
    lines = [",".join(map(repr, row)) for row in _changed(values, rows).tolist()]
    return ("\n".join([*head, *lines]) + "\n").encode()


def _hdf5_with(content: bytes, rows: dict[str, Float], source: Path) -> bytes:
    stream = io.BytesIO(content)
    with _opened(stream, "r+") as file:
        known = dict(_datasets(file, str(source)))
        for name, row in rows.items():
            demo, _, number = name.rpartition("/") if "" not in known and name not in known else (name, "", "0")
            if "" in known:
                demo, number = "", name
            data = known[demo]
            if data.ndim == 1:
                data[...] = row
            else:
                data[int(number)] = row
    return stream.getvalue()
