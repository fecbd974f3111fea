"""The motion of a carrier over time: accelerations in its own axes, from arrays, from CSV files or by name."""

from __future__ import annotations

import os
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from holdfast.applications.carrying.reading import COLUMNS, table_of
from holdfast.applications.carrying.standards import STANDARDS
from holdfast.base.archive import archived
from holdfast.base.arrays import Float, checked, checked_direction, checked_number
from holdfast.base.errors import HoldfastError, located, message, nearest_of
from holdfast.base.files import checked_path, read_ordinary
from holdfast.base.kinds import shaped
from holdfast.base.ranges import ACCELERATION, PLACE, SCALE, TURNING, Range
from holdfast.base.text import quoted
from holdfast.base.values import Value, seal

WIDTHS = (4, 7, 10)  # numbers of columns: without rotation, with angular acceleration, and also with angular velocity
MOST_BYTES = 200_000_000  # largest size of a CSV file
PULSE = (0.0, 0.05, 0.35, 0.4)  # [s] corners of a trapezoidal pulse of acceleration in a named profile
PERIOD = 0.5  # [s] from the beginning of one pulse to that of the next
DURATION = Range(0.0, 1e9, "s")


@archived
@shaped(time="n", acceleration="n 3", angular_acceleration="n 3", angular_velocity="n 3", pivot="3")
@dataclass(frozen=True, init=False, eq=False, repr=False)
class Profile(Value):
    """The motion of a carrier at n times: how it accelerates and turns, along the axes of the scene.

    ``time`` (n,) [s] increases. ``acceleration`` (n, 3) [m/s²] is that of the carrier at ``pivot`` (3,) [m], without
    gravity: it is zero for a carrier at rest, where an accelerometer would read 9.81 m/s² upwards.
    ``angular_acceleration`` (n, 3) [rad/s²] and ``angular_velocity`` (n, 3) [rad/s] are about the pivot. The axes are
    those of the scene, which move with the carrier. Everything is interpolated linearly between the times.

    At the first time, gravity is that of the scene. As the carrier turns by ``angular_velocity``, gravity turns the
    other way in its axes. ``name`` and ``source`` say where the numbers are from. Raises HoldfastError if times do not
    increase or if numbers are out of range.
    """

    time: Float
    acceleration: Float
    angular_acceleration: Float
    angular_velocity: Float
    pivot: Float
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
