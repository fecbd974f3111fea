"""The motion of a carrier over time: accelerations in its own axes, from arrays, from CSV files or by name.

Named ones are accelerations that cargo has to withstand, as public sources state them; they imply no claim of
compliance. Every number is from a source that could be read, which the entry names. The coefficients of EN 12195-1 for
rail and sea and those of IATA for unit load devices are missing because no public source was found; give them as a
table of your own (``Profile.from_table``).
"""

from __future__ import annotations

import os
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from holdfast.base.arrays import Float, checked, checked_direction, checked_number
from holdfast.base.errors import HoldfastError, located, message, nearest_of
from holdfast.base.files import checked_path, read_ordinary
from holdfast.base.public import Record, column
from holdfast.base.ranges import ACCELERATION, PLACE, SCALE, TURNING, Range
from holdfast.base.text import quoted
from holdfast.base.values import seal

COLUMNS = ("t", "ax", "ay", "az", "alphax", "alphay", "alphaz", "omegax", "omegay", "omegaz")
NEEDED = 4  # number of columns that every table must have
G = 9.80665  # [m/s²] standard gravity, the unit in which most sources state accelerations

Side = Literal["forwards", "backwards", "left", "right", "up", "down"]
WIDTHS = (4, 7, 10)  # numbers of columns: without rotation, with angular acceleration, and also with angular velocity
MOST_BYTES = 200_000_000  # largest size of a CSV file
PULSE = (0.0, 0.05, 0.35, 0.4)  # [s] corners of a trapezoidal pulse of acceleration in a named profile
PERIOD = 0.5  # [s] from the beginning of one pulse to that of the next
DURATION = Range(0.0, 1e9, "s")


def table_of(content: bytes) -> Float:
    """Return the rows of a CSV file with columns in the order of COLUMNS.

    If the first row names the columns, the result has all COLUMNS, with zeros in those that the file lacks. Otherwise
    it has the columns of the file. Raises HoldfastError if a row does not hold numbers, or if the first row names other
    columns.
    """
    try:
        lines = content.decode("utf-8-sig").splitlines()
    except UnicodeDecodeError:
        raise HoldfastError(message("profile", "is not a text", "needs a CSV file")) from None
    numbered = [(k, line.strip()) for k, line in enumerate(lines, 1) if line.strip() and line.strip()[0] != "#"]
    if not numbered:
        raise HoldfastError(message("profile", "has no rows", f"needs rows of {', '.join(COLUMNS[:NEEDED])}"))
    first = _cells(numbered[0][1])
    try:
        float(first[0])
        names = None
    except ValueError:
        names = _names(first)
    body = numbered if names is None else numbered[1:]
    table = np.zeros((len(body), len(first)))
    for row, (number, line) in enumerate(body):
        cells = _cells(line)
        if len(cells) != len(first):
            raise HoldfastError(message("profile", f"row {number} has {len(cells)} cells", f"needs {len(first)}"))
        try:
            table[row] = [float(cell) for cell in cells]
        except ValueError:
            problem = f"row {number} is {quoted(line, 60)}"
            raise HoldfastError(message("profile", problem, "needs numbers")) from None
    if names is None:
        return table
    ordered = np.zeros((len(table), len(COLUMNS)))
    ordered[:, [COLUMNS.index(name) for name in names]] = table
    return ordered


def _cells(line: str) -> list[str]:
    """Return the cells of a row, separated by semicolons, commas, tabs or spaces.

    Between semicolons, numbers may have a decimal comma.
    """
    if ";" in line:
        return [cell.strip().replace(",", ".") for cell in line.split(";")]
    return [cell.strip() for cell in line.split(",")] if "," in line else line.split()


def _names(cells: list[str]) -> list[str]:
    """Return the names of the columns, without units in brackets and without anything that is not a letter."""
    names = [re.sub(r"[^a-z]", "", re.sub(r"[\[(].*", "", cell.lower())) for cell in cells]
    names = ["t" if name == "time" else name for name in names]
    unknown = [cell for cell, name in zip(cells, names, strict=True) if name not in COLUMNS]
    if unknown:
        problem = f"has a column {quoted(unknown[0])}"
        raise HoldfastError(message("profile", problem, f"known: {', '.join(COLUMNS)}"))
    missing = [name for name in COLUMNS[:NEEDED] if name not in names]
    if missing or len(set(names)) < len(names):
        problem = f"has no column {missing[0]}" if missing else "names a column twice"
        raise HoldfastError(message("profile", problem, f"needs {', '.join(COLUMNS[:NEEDED])}, each once"))
    return names


@dataclass(frozen=True)
class Standard:
    """The accelerations of one standard.

    ``cargo`` holds pairs of the side to which cargo is thrown, seen from the driver, and the acceleration [m/s²]; the
    carrier accelerates the other way. ``sources`` are the pages from which the numbers were taken.
    """

    title: str
    sources: tuple[str, ...]
    cargo: tuple[tuple[Side, float], ...]


def _all_round(forwards: float, backwards: float, sideways: float) -> tuple[tuple[Side, float], ...]:
    return ("forwards", forwards), ("backwards", backwards), ("left", sideways), ("right", sideways)


_BENCH = (
    "https://en.wikipedia.org/wiki/Acceleration_test (0.3 s or longer, reached within 50 ms; mostly 0.5 g)",
    "http://www.safeloadtesting.com/stability-testing/ (k g for at least 0.3 s, reached within 0.05 s)",
)
_ANNEX_13 = (
    "https://puc.overheid.nl/doc/PUC_2092_14/2, table 2 (basic acceleration data of annex 13, before corrections for "
    "length, speed and metacentric height; transverse figures include gravity parallel to the deck)",
)

STANDARDS: Mapping[str, Standard] = {
    "eumos40509_0.5g": Standard(
        "acceleration bench in the manner of EUMOS 40509, 0.5 g", _BENCH, (("backwards", 0.5 * G),)
    ),
    "eumos40509_0.8g": Standard(
        "acceleration bench in the manner of EUMOS 40509, 0.8 g",
        (*_BENCH, "https://www.safeloadtesting.com/en/acceleration-test/ (0.8 g in the direction of travel)"),
        (("backwards", 0.8 * G),),
    ),
    "road": Standard(
        "road, as in EN 12195-1: 0.8 g forwards, 0.5 g backwards and sideways, 1 g downwards throughout",
        (
            "https://tis-gdv.de/tis/ls/ls_im_strassenverkehr/kapitel01.html (GDV: consensus in Germany and elsewhere)",
            "https://www.kuljettaja.net/hakemisto/kiihtyvyyskerroin/ (the same numbers, as those of SFS-EN 12195-1)",
        ),
        _all_round(0.8 * G, 0.5 * G, 0.5 * G),
    ),
    "rail_aar": Standard(
        "rail, loading restraint factors recommended by the Association of American Railroads",
        ("TM 55-3930-660-14, appendix B: https://constructionforklifts.tpub.com/TM-55-3930-660-14/",),
        (*_all_round(3 * G, 3 * G, 2 * G), ("up", 2 * G), ("down", 2 * G)),
    ),
    "sea_msc": Standard(
        "sea, design factors of the Military Sealift Command for severe conditions",
        ("TM 55-3930-660-14, appendix B: https://constructionforklifts.tpub.com/TM-55-3930-660-14/",),
        (*_all_round(0.7 * G, 0.7 * G, 1.2 * G), ("up", 0.2 * G), ("down", 0.2 * G)),
    ),
    "sea_on_deck": Standard(
        "sea, CSS Code annex 13, on deck high, the worst place along the ship",
        _ANNEX_13,
        (*_all_round(3.8, 3.8, 7.4), ("up", 9.2), ("down", 9.2)),
    ),
    "sea_tween_deck": Standard(
        "sea, CSS Code annex 13, tween deck amidships",
        _ANNEX_13,
        (*_all_round(2.0, 2.0, 5.4), ("up", 4.3), ("down", 4.3)),
    ),
    "air_emergency": Standard(
        "air, ultimate inertia forces of an emergency landing, 14 CFR 25.561",
        ("http://federal.elaws.us/cfr/title-14/section-25.561 (b)(3)",),
        (*_all_round(9 * G, 1.5 * G, 3 * G), ("up", 3 * G), ("down", 6 * G)),
    ),
}


class Profile(Record):
    """The motion of a carrier at n times: how it accelerates and turns, along the axes of the scene.

    ``time`` (n,) [s] increases. ``acceleration`` (n, 3) [m/s²] is that of the carrier at ``pivot`` (3,) [m], without
    gravity: it is zero for a carrier at rest, where an accelerometer would read 9.81 m/s² upwards.
    ``angular_acceleration`` (n, 3) [rad/s²] and ``angular_velocity`` (n, 3) [rad/s] are about the pivot. The axes are
    those of the scene, which move with the carrier. Everything is interpolated linearly between the times.

    At the first time, gravity is that of the scene. As the carrier turns by ``angular_velocity``, gravity turns the
    other way in its axes. ``name`` and ``source`` say where the numbers are from. Raises HoldfastError if times do not
    increase or if numbers are out of range.
    """

    time: Float = column("n")
    acceleration: Float = column("n 3")
    angular_acceleration: Float = column("n 3")
    angular_velocity: Float = column("n 3")
    pivot: Float = column("3")
    name: str
    source: str

    def __init__(
        self,
        time: ArrayLike,
        acceleration: ArrayLike,
        angular_acceleration: ArrayLike | None = None,
        angular_velocity: ArrayLike | None = None,
        *,
        pivot: ArrayLike = (0.0, 0.0, 0.0),
        name: str = "",
        source: str = "",
    ) -> None:
        where = "profile"
        t = checked(time, (None,), f"{where}: time", within=DURATION, error=HoldfastError)
        if not len(t):
            raise HoldfastError(message(f"{where}: time", "is empty", "needs at least one time"))
        if (np.diff(t) <= 0).any():
            k = int(np.argmax(np.diff(t) <= 0))
            problem = f"{t[k + 1]:g} s follows {t[k]:g} s"
            raise HoldfastError(message(f"{where}: time", problem, "needs times that increase"))
        set_ = object.__setattr__
        set_(self, "time", t)
        for label, value, within in (
            ("acceleration", acceleration, ACCELERATION),
            ("angular_acceleration", angular_acceleration, TURNING),
            ("angular_velocity", angular_velocity, TURNING),
        ):
            given = np.zeros((len(t), 3)) if value is None else value
            set_(self, label, checked(given, (len(t), 3), f"{where}: {label}", within=within, error=HoldfastError))
        set_(self, "pivot", checked(pivot, (3,), f"{where}: pivot", within=PLACE, error=HoldfastError))
        set_(self, "name", str(name))
        set_(self, "source", str(source))
        seal(self)

    @classmethod
    def from_table(
        cls, rows: ArrayLike, *, pivot: ArrayLike = (0.0, 0.0, 0.0), name: str = "", source: str = ""
    ) -> Profile:
        """Return the profile whose times are the ``rows`` of a table.

        The columns are t [s], the acceleration ax, ay, az [m/s²], and, if there are 7 or 10 of them, the angular
        acceleration [rad/s²] and the angular velocity [rad/s]. Raises HoldfastError for another number of columns.
        """
        rows = checked(rows, (None, None), "profile", error=HoldfastError)
        if rows.shape[1] not in WIDTHS:
            raise HoldfastError(
                message("profile", f"has {rows.shape[1]} columns", f"needs 4, 7 or 10: {', '.join(COLUMNS)}")
            )
        more = {"angular_acceleration": slice(4, 7), "angular_velocity": slice(7, 10)}
        turning = {label: rows[:, columns] for label, columns in more.items() if rows.shape[1] >= columns.stop}
        return cls(rows[:, 0], rows[:, 1:4], **turning, pivot=pivot, name=name, source=source)

    @classmethod
    def from_file(cls, path: str | os.PathLike[str], *, pivot: ArrayLike = (0.0, 0.0, 0.0)) -> Profile:
        """Read a profile from a text file with one time in each row.

        Numbers are separated by commas, semicolons, tabs or spaces. The first row may name the columns, in any order,
        upper or lower case: t, ax, ay, az, and optionally alphax, alphay, alphaz and omegax, omegay, omegaz (SI units);
        without names, the columns are those of ``from_table``. Rows that begin with # are comments. Raises
        HoldfastError for any other file.
        """
        file = checked_path(path, "profile")
        content = read_ordinary(file, "profile", most=MOST_BYTES, error=HoldfastError, too_large="take fewer samples")
        with located(str(file)):
            return cls.from_table(table_of(content), pivot=pivot, name=file.stem, source=file.name)

    @staticmethod
    def standards() -> dict[str, str]:
        """Return the names that ``Profile.named`` takes, each with a description and its sources."""
        return {name: f"{each.title}; source: {'; '.join(each.sources)}" for name, each in STANDARDS.items()}

    @classmethod
    def named(cls, name: str, *, heading: ArrayLike = (1.0, 0.0, 0.0), up: ArrayLike = (0.0, 0.0, 1.0)) -> Profile:
        """Return a profile that is known by name, for a vehicle that drives along ``heading``.

        There is one pulse for every direction in which the source demands that cargo is held: the acceleration rises
        within 0.05 s, is constant for 0.3 s and falls within 0.05 s. Between two pulses the carrier is at rest for
        0.1 s. ``heading`` is projected into the plane normal to ``up``. ``Profile.standards()`` lists the names with
        their sources. A load that holds under such a profile does not thereby comply with the standard.

        Raises HoldfastError if the name is unknown, or if ``heading`` is along ``up``.
        """
        standard = STANDARDS.get(name) if isinstance(name, str) else None
        if standard is None:
            raise HoldfastError(message("profile", f"{quoted(name)} is unknown", nearest_of(name, STANDARDS)))
        top = checked_direction(up, "profile: up")
        ahead = checked_direction(heading, "profile: heading")
        ahead = ahead - (ahead @ top) * top
        if np.linalg.norm(ahead) < 1e-6:
            raise HoldfastError(message("profile: heading", "is vertical", "needs a horizontal direction"))
        ahead = ahead / np.linalg.norm(ahead)
        left, none = np.cross(top, ahead), np.zeros(3)
        axes = {"forwards": ahead, "backwards": -ahead, "left": left, "right": -left, "up": top, "down": -top}
        time, rows = [], []
        for number, (side, value) in enumerate(standard.cargo):
            pulse = -value * axes[side]  # cargo is thrown forwards when the carrier accelerates backwards
            time += [number * PERIOD + t for t in PULSE]
            rows += [none, pulse, pulse, none]
        return cls(time, np.array(rows), name=name, source="; ".join(standard.sources))

    def at_speed(self, factor: float) -> Profile:
        """Return the same motion played ``factor`` times as fast: accelerations are multiplied by its square."""
        s = checked_number(factor, "profile: speed", above=0, within=SCALE)
        return self._like(
            self.time / s, self.acceleration * s**2, self.angular_acceleration * s**2, self.angular_velocity * s
        )

    def at(self, times: ArrayLike) -> Profile:
        """Return the motion at other ``times`` (m,) [s], between the first and the last, by linear interpolation.

        The new times must be dense enough where the carrier tilts, because gravity is integrated from their angular
        velocities. Raises HoldfastError for a time outside.
        """
        t = checked(times, (None,), "profile: times", within=DURATION, error=HoldfastError)
        if len(t) and (t.min() < self.time[0] or t.max() > self.time[-1]):
            span = f"{self.time[0]:g} to {self.time[-1]:g} s"
            raise HoldfastError(message("profile: times", "some are outside", f"needs times within {span}"))
        given = (self.acceleration, self.angular_acceleration, self.angular_velocity)
        return self._like(t, *(np.stack([np.interp(t, self.time, axis) for axis in rows.T], 1) for rows in given))

    def _like(self, time: Float, acceleration: Float, alpha: Float, omega: Float) -> Profile:
        return Profile(time, acceleration, alpha, omega, pivot=self.pivot, name=self.name, source=self.source)

    def turns(self) -> Rotation:
        """Return the n rotations of the carrier from its first pose, integrated by the trapezoidal rule."""
        steps = np.diff(self.time)[:, None] * (self.angular_velocity[1:] + self.angular_velocity[:-1]) / 2
        turn = [Rotation.identity()]
        for step in Rotation.from_rotvec(steps) if len(steps) else ():
            turn.append(turn[-1] * step)  # the step is about the axes of the carrier
        return Rotation.concatenate(turn)

    def course(self) -> tuple[Float, Float]:
        """Return the velocity (n, 3) [m/s] and the place (n, 3) [m] of the carrier at each time.

        At the first time it is at rest in the origin. Both are along the axes of the scene there.
        """
        a = self.turns().apply(self.acceleration.copy())  # scipy refuses read-only arrays
        h = np.diff(self.time)[:, None]
        velocity = np.vstack([np.zeros(3), np.cumsum(h * (a[1:] + a[:-1]) / 2, axis=0)])
        steps = h * velocity[:-1] + h**2 * (2 * a[:-1] + a[1:]) / 6  # exact where the acceleration is linear
        return velocity, np.vstack([np.zeros(3), np.cumsum(steps, axis=0)])

    def gravity(self, first: Float) -> Float:
        """Return gravity (n, 3) [m/s²] in the axes of the scene; ``first`` (3,) is gravity at the first time."""
        if not np.cross(self.angular_velocity, first).any():
            return np.broadcast_to(first, (len(self.time), 3))
        return np.asarray(self.turns().inv().apply(first.copy()))  # scipy refuses read-only arrays
