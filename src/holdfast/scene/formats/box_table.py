"""Reads tables of boxes (.csv, .tsv): one box a row, with its size, its place and its mass."""

from __future__ import annotations

import csv
import math
from collections.abc import Collection
from typing import NoReturn

import numpy as np
from numpy.typing import ArrayLike

from holdfast.base.arrays import Float
from holdfast.base.errors import SceneError, located, message
from holdfast.base.text import listed, quoted
from holdfast.scene.body import Body
from holdfast.scene.formats.floor import with_floor
from holdfast.scene.formats.named_meshes import Numbers, check_weights, common, first_of, own
from holdfast.scene.formats.registry import Format
from holdfast.scene.formats.rigid_parts import checked_fixed, pose_of, scene_of
from holdfast.scene.formats.source import Source
from holdfast.scene.friction import Friction
from holdfast.scene.scene import Scene
from holdfast.scene.shapes import Box

MOST_ROWS = 100_000  # boxes of one table; contact detection would take hours for more
MOST_COLUMNS = 1_000  # of one table; no program writes as many
SIZES = (("size_x", "size_y", "size_z"), ("length", "width", "height"), ("dx", "dy", "dz"))  # names of three columns
CENTRES = (("x", "y", "z"), ("position_x", "position_y", "position_z"))
CORNERS = (("corner_x", "corner_y", "corner_z"), ("x_min", "y_min", "z_min"))
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

    A row has its size (``size_x``, ``size_y``, ``size_z``; or ``length``, ``width``, ``height``; or ``dx``, ``dy``,
    ``dz``) and the place of its centre (``x``, ``y``, ``z``) or of its least corner (``corner_x``, ``corner_y``,
    ``corner_z``; or ``x_min``, ``y_min``, ``z_min``), all in metres. It may have ``name`` (or else its number),
    ``mass`` [kg], ``yaw`` [deg] about the vertical through its centre, ``fixed``, ``material``, and what it may bear,
    ``top_load`` [N] and ``pressure`` [Pa].

    ``mass`` and ``density`` [kg/m³] are for boxes without one, ``fixed`` names further boxes that never move, and
    ``floor`` adds the half space below z = 0. Raises SceneError or GeometryError if the table is malformed, or if
    friction or a mass is missing.
    """
    table = _Table(source)
    where = str(source.path)
    if friction is None:
        raise SceneError(message(where, "says nothing of friction", "give friction="))
    names = [row.name for row in table.rows]
    check_weights(mass, density, names)
    held = checked_fixed(fixed, names, "box")
    bodies = []
    for row in table.rows:
        still = row.name in held or row.truth("fixed")
        said = row.values.get("mass", "")
        weight = (row.number("mass"), None) if said else first_of(own(mass, density, row.name), common(mass, density))
        if weight == (None, None) and not still:
            row.fail("has no mass", "give a column mass, or density= or mass=")
        with located(row.where):
            given = (None, None) if still else weight
            material = row.values.get("material") or None
            limits = {name: row.number(name) for name in LIMITS if row.values.get(name)}
            bodies.append(Body(row.name, row.box, *given, pose=row.pose, material=material, fixed=still, **limits))
    remedy = f"give floor=True for a floor at z = 0, or fixed=[name] ({listed(names)})"
    return scene_of(with_floor(bodies, floor, where, remedy), friction, gravity, source.path.stem, table.notes)


class _Row:
    """A row of the table: the text of each column, and where it is."""

    def __init__(self, values: dict[str, str], name: str, where: str, size: Float, centre: Float) -> None:
        self.values, self.name, self.where = values, name, where
        with located(where):
            self.box = Box(size)
        self.pose = pose_of(centre.tolist(), (0, 0, math.radians(self.number("yaw") if values.get("yaw") else 0.0)))

    def fail(self, problem: str, remedy: str) -> NoReturn:
        raise SceneError(message(self.where, problem, remedy))

    def number(self, column: str) -> float:
        return _number(self.values[column], column, self.where)

    def truth(self, column: str) -> bool:
        word = self.values.get(column, "").lower()
        return WORDS[word] if word in WORDS else self.fail(f"{column} is {quoted(word)}", "needs true or false")


class _Table:
    """The rows of a table, with notes on what is not read."""

    def __init__(self, source: Source) -> None:
        where = str(source.path)
        lines = source.text.splitlines()
        header = lines[0] if lines else ""
        between = max(",;\t", key=header.count)
        columns = [word.strip().lower() for word in header.split(between, MOST_COLUMNS)]
        if len(columns) > MOST_COLUMNS:
            raise SceneError(message(f"{where}:1", "has too many columns", f"the limit is {MOST_COLUMNS:,}"))
        repeated = [word for word in columns if columns.count(word) > 1]
        if repeated:
            raise SceneError(message(f"{where}:1", f"two columns are named {quoted(repeated[0])}", "keep one"))
        size = self._of(SIZES, columns, where, "a size")
        corner = not any(set(each) <= set(columns) for each in CENTRES)
        place = self._of(CORNERS if corner else CENTRES, columns, where, "a place (x, y, z, or corner_x, ...)")
        unread = [word for word in columns if word not in (*size, *place, *OTHERS)]
        self.notes = [f"columns that are not read: {listed(unread)}"] if unread else []
        self.notes.append("lengths are taken as metres: a table has no units")
        self.rows: list[_Row] = []
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
                self.rows.append(_Row(values, name, here, lengths, at + lengths / 2 if corner else at))
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


def _number(text: str, column: str, where: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise SceneError(message(where, f"{column} is {quoted(text)}", "needs a number, with a point for decimals"))
    return value


BOX_TABLE = Format("table of boxes", (".csv", ".tsv"), read=read)
