"""Reads tables of boxes (.csv, .tsv): one box a row, with its size, its place and its mass."""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Collection

import numpy as np
from numpy.typing import ArrayLike

from holdfast.base.arrays import Float
from holdfast.base.errors import SceneError, located, message
from holdfast.base.text import listed, quoted
from holdfast.scene.body import Body
from holdfast.scene.formats.links import checked_fixed, pose_of, scene_of, with_floor
from holdfast.scene.formats.named_meshes import Numbers, Weights
from holdfast.scene.formats.registry import Format
from holdfast.scene.formats.source import PlainMap, Source
from holdfast.scene.friction import Friction
from holdfast.scene.scene import Scene
from holdfast.scene.shapes import Box

MOST_ROWS = 100_000  # boxes of one table; contact detection would take hours for more
MOST_COLUMNS = 1_000  # of one table; no program writes as many


def _along(*names: str) -> tuple[tuple[str, str, str], ...]:
    """Return the names of three columns for each of these names, where a star stands for the axis."""
    return tuple((name.replace("*", "x"), name.replace("*", "y"), name.replace("*", "z")) for name in names)


# Names of three columns, as tables of packing programs and spreadsheets have them
SIZES = (*_along("size_*", "s*", "size*", "d*", "dim_*", "extent_*", "*_size"), ("length", "width", "height"),
         ("length", "depth", "height"), ("width", "depth", "height"), ("l", "w", "h"), ("w", "d", "h"))  # fmt: skip
CENTRES = _along("*", "position_*", "pos_*", "p*", "centre_*", "center_*", "c*", "*_centre", "*_center")
CORNERS = _along("corner_*", "*_min", "min_*", "*min", "*0", "origin_*")
ALSO = {"id": "name", "label": "name", "box": "name", "item": "name", "weight": "mass", "m": "mass", "kg": "mass",
        "yaw_deg": "yaw", "yaw_degrees": "yaw"}  # fmt: skip
UNITS = re.compile(r"\s*[\[(]\s*(?:m|kg|deg|°|n|pa)\s*[\])]$|_(?:m|kg)$")  # behind a name, as in "size_x [m]"
LIMITS = ("top_load", "pressure")
OTHERS = ("name", "mass", "yaw", "fixed", "material", *LIMITS)
WORDS = {"true": True, "yes": True, "1": True, "false": False, "no": False, "0": False, "": False}
HEADER = "name,size_x,size_y,size_z,x,y,z,mass"


def read(
    source: Source,
    *,
    friction: Friction | float | None = None,
    density: Numbers | None = None,
    mass: Numbers | None = None,
    fixed: Collection[str] = (),
    floor: bool = False,
    gravity: ArrayLike = (0.0, 0.0, -9.81),
) -> Scene:
    """Return the scene of a table of boxes, whose first line names the columns.

    A row has its size (``size_x``, ``size_y``, ``size_z``; ``sx`` ...; ``dx`` ...; ``length``, ``width``, ``height``)
    and the place of its centre (``x``, ``y``, ``z``; ``cx`` ...; ``pos_x`` ...) or of its least corner (``corner_x``
    ...; ``x_min`` ...), all in metres; a unit may stand behind a name, as in ``x [m]`` or ``x_m``. It may have ``name``
    or ``id`` (or else its number), ``mass`` or ``weight`` [kg], ``yaw`` [deg] about the vertical through its centre,
    ``fixed``, ``material``, and what it may bear, ``top_load`` [N] and ``pressure`` [Pa].

    ``mass`` and ``density`` [kg/m³] are for boxes without one, ``fixed`` names further boxes that never move, and
    ``floor`` adds the half space below z = 0. Raises SceneError or GeometryError if the table is malformed, or if
    friction or a mass is missing.
    """
    table = _BoxTable(source)
    where = str(source.path)
    if friction is None:
        raise SceneError(message(where, "says nothing of friction", "give friction="))
    names = [row.name for row in table.rows]
    weights = Weights(mass, density, names)
    fixed_names = checked_fixed(fixed, names, "box")
    bodies = []
    for row in table.rows:
        still = row.name in fixed_names or row.truth("fixed")
        said = row.values.get("mass", "")
        weight = (row.number("mass"), None) if said else weights.of(row.name)
        if weight == (None, None) and not still:
            row.fail("has no mass", "give a column mass, or density= or mass=")
        with located(row.where):
            given = (None, None) if still else weight
            material = row.values.get("material") or None
            limits = {name: row.number(name) for name in LIMITS if row.values.get(name)}
            bodies.append(Body(row.name, row.box, *given, pose=row.pose, material=material, fixed=still, **limits))
    remedy = f"give floor=True for a floor at z = 0, or fixed=[name] ({listed(names)})"
    return scene_of(with_floor(bodies, floor, where, remedy), friction, gravity, source.path.stem, table.notes)


class _BoxRow(PlainMap):
    """A row of the table: the text of each column, and where it is."""

    def __init__(self, values: dict[str, str], name: str, where: str, size: Float, centre: Float) -> None:
        self.values, self.name, self.where = values, name, where
        with located(where):
            self.box = Box(size)
        self.pose = pose_of(centre.tolist(), (0, 0, math.radians(self.number("yaw") if values.get("yaw") else 0.0)))

    def number(self, column: str) -> float:
        return _number(self.values[column], column, self.where)

    def truth(self, column: str) -> bool:
        word = self.values.get(column, "").lower()
        return WORDS[word] if word in WORDS else self.fail(f"{column} is {quoted(word)}", "needs true or false")


class _BoxTable:
    """The rows of a table, with notes on what is not read."""

    def __init__(self, source: Source) -> None:
        where = str(source.path)
        lines = source.text.splitlines()
        header = lines[0] if lines else ""
        between = max(",;\t", key=header.count)
        columns = [_column(word) for word in header.split(between, MOST_COLUMNS)]
        if len(columns) > MOST_COLUMNS:
            raise SceneError(message(f"{where}:1", "has too many columns", f"the limit is {MOST_COLUMNS:,}"))
        columns = [word if ALSO.get(word, word) in columns else ALSO[word] for word in columns]
        repeated = [word for word in columns if columns.count(word) > 1]
        if repeated:
            raise SceneError(message(f"{where}:1", f"two columns are named {quoted(repeated[0])}", "keep one"))
        size = self._of(SIZES, columns, where, "a size")
        corner = not any(set(each) <= set(columns) for each in CENTRES)
        place = self._of(CORNERS if corner else CENTRES, columns, where, "a place (x, y, z, or corner_x, ...)")
        unread = [word for word in columns if word not in (*size, *place, *OTHERS)]
        self.notes = [f"columns that are not read: {listed(unread)}"] if unread else []
        self.notes.append("lengths are taken as metres: a table has no units")
        self.rows: list[_BoxRow] = []
        seen: set[str] = set()
        try:
            for number, row in enumerate(csv.reader(lines[1:], delimiter=between), 2):
                if not any(word.strip() for word in row):
                    continue
                here = f"{where}:{number}"
                if len(row) != len(columns) or len(self.rows) >= MOST_ROWS:
                    problem = (
                        f"has {len(row)} columns of {len(columns)}" if len(row) != len(columns) else "is one too many"
                    )
                    raise SceneError(message(here, problem, f"needs one box a line, at most {MOST_ROWS:,}"))
                values = {column: word.strip() for column, word in zip(columns, row, strict=True)}
                name = values.get("name") or f"box {len(self.rows) + 1}"
                if name in seen:
                    raise SceneError(message(here, f"is the second box named {quoted(name)}", "names are unique"))
                seen.add(name)
                lengths = np.array([_number(values[column], column, here) for column in size])
                at = np.array([_number(values[column], column, here) for column in place])
                self.rows.append(_BoxRow(values, name, here, lengths, at + lengths / 2 if corner else at))
        except csv.Error as cause:
            raise SceneError(message(where, f"is no table: {cause}", "check the file")) from cause
        if not self.rows:
            raise SceneError(message(where, "has no boxes", "needs a line for each, below the names of the columns"))

    def _of(self, known: tuple[tuple[str, ...], ...], columns: list[str], where: str, what: str) -> tuple[str, ...]:
        """Return the names of three columns that are there."""
        found = next((each for each in known if set(each) <= set(columns)), None)
        if found is None:
            problem = f"has no columns for {what} among {listed([quoted(word, 40) for word in columns], 8)}"
            raise SceneError(message(f"{where}:1", problem, f"begin the table with {HEADER}"))
        return found


def _column(title: str) -> str:
    """Return the name of a column without its unit."""
    return re.sub(r"[ .-]", "_", UNITS.sub("", title.strip().strip('"').lower()))


def _number(text: str, column: str, where: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise SceneError(message(where, f"{column} is {quoted(text)}", "needs a number, with a point for decimals"))
    return value


BOX_TABLE = Format("table of boxes", (".csv", ".tsv"), read=read)
