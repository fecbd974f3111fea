"""A planner's constraint: the load factor of any wrench on a body, for tens of thousands of wrenches a second."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import ArrayLike

from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import Float, checked, checked_number, checked_rows, checked_whole, frozen
from holdfast.base.errors import HoldfastError, message
from holdfast.base.public import PublicValue, Summary, column, number
from holdfast.base.ranges import FORCE, MANY, PLACE, SCALE
from holdfast.base.rigid import wrench_at
from holdfast.base.text import quoted
from holdfast.engines.answers import Claim
from holdfast.engines.bearing import unchecked_limits
from holdfast.engines.contract import HULLS
from holdfast.engines.groups import prepared
from holdfast.geometry.cells import surface_cells
from holdfast.geometry.hull import hull_gauge
from holdfast.queries.checked_hull import checked_hull
from holdfast.queries.request import Load, checked_assembly, engine_for, total_wrench
from holdfast.queries.sets import lower_of, notes_of, wrench_box, wrench_columns
from holdfast.scene.scene import Scene

SOLVES = 1500  # default number of solves
PUSHES = 1000  # approximate number of surface points at which pushes are sampled
ALONG = 4  # pushes sampled at each point
OBLIQUE = 0.3  # standard deviation of each component of a push about the unit inward normal


class Constraint(PublicValue):
    """A lower bound of the load factor of any wrench on ``body``, as a function with a derivative.

    A wrench is a force [N] and a torque [N m] about the body's centre of mass ``com`` (3,) [m], along the world axes.
    The load factor is the largest number by which it can be multiplied before anything in the assembly moves, in
    addition to the weight and the standing loads. The value interpolates between ``known`` wrenches (m, 6) that the
    assembly withstands; ``price`` (m,) is at least the reciprocal of the factor of each.

    With the ``claim`` *holds* the value is at most the default engine's ``lower`` at all wrenches that were asked. Its
    set is not convex, so in between the value may be above: ``above`` is the share of as many other wrenches where it
    was, and ``above_by`` the largest excess there, as a share of ``lower``; the value was then lowered at these. It is
    no proof. With the claim *exists* the value is never above the factor up to which an equilibrium exists, as that has
    one under every convex combination of two wrenches under which it has; both shares are 0.

    Accuracy was measured on a last set of test wrenches, half of them pushes on the body's surface (or directions near
    the requested ones), half of them random. Of these, half have a value of at least (1 - ``accuracy``) times the true
    factor, and nine in ten of at least (1 - ``accuracy_of_most``) times it. ``accuracy_wanted`` is the accuracy that
    was requested, and ``solves`` the number of solves that it took. ``box`` (6,) [N, N m] bounds the wrenches that were
    solved: far beyond it, values are too small.
    """

    body: str
    engine: str
    claim: Claim
    known: Float = column("m 6")
    price: Float = column("m")
    com: Float = column("3")
    box: Float = column("6")
    accuracy: float
    accuracy_of_most: float
    accuracy_wanted: float
    solves: int
    notes: tuple[str, ...]
    above: float = 0.0
    above_by: float = 0.0

    plain = (
        "body engine claim known price com box accuracy accuracy_of_most accuracy_wanted solves above above_by notes"
    )

    def value(self, wrenches: ArrayLike) -> float | Float:
        """Return the load factors of ``wrenches`` (6,) or (n, 6): a number, or (n,).

        A factor of at least 1 means what the ``claim`` says of the wrench: that everything holds, or only that an
        equilibrium exists. A zero wrench has the factor inf.
        """
        used, single = self._used(wrenches, "value: wrenches")[0::2]
        with np.errstate(divide="ignore"):
            factors = 1 / used
        return float(factors[0]) if single else factors

    def gradient(self, wrenches: ArrayLike) -> Float:
        """Return the derivatives of ``value`` by the wrench, of the shape of ``wrenches``.

        They are -cut · value². At a kink of ``value``, the result is a one-sided derivative.
        """
        used, cut, single = self._used(wrenches, "gradient: wrenches")
        with np.errstate(divide="ignore", invalid="ignore"):
            slopes = np.where(used[:, None] > 0, -cut / used[:, None] ** 2, 0.0)
        return slopes[0] if single else slopes

    def usage(self, wrenches: ArrayLike) -> float | Float:
        """Return 1 / value: the share of the load capacity that the wrench uses.

        It is convex and finite for every wrench, so it suits an optimiser as the constraint usage <= 1.
        """
        used, single = self._used(wrenches, "usage: wrenches")[0::2]
        return float(used[0]) if single else used

    def cut(self, wrenches: ArrayLike) -> Float:
        """Return the derivatives of ``usage`` by the wrench, of the shape of ``wrenches``.

        Each is a cutting plane: row·w equals the usage of its own wrench and is a lower bound of that of any other.
        """
        cut, single = self._used(wrenches, "cut: wrenches")[1:]
        return cut[0] if single else cut

    def wrenches(self, points: ArrayLike, forces: ArrayLike) -> Float:
        """Return the wrenches (n, 6) about ``com`` of ``forces`` (n, 3) [N] at ``points`` (n, 3) [m], world frame.

        A single point is used with all forces, and a single force with all points.
        """
        p = checked_rows(points, 3, "constraint: points", within=PLACE)[0]
        f = checked_rows(forces, 3, "constraint: forces", within=FORCE)[0]
        several = {len(p), len(f)} - {1}
        if len(several) > 1:
            problem = f"{len(p)} points and {len(f)} forces"
            raise HoldfastError(message("constraint: wrenches", problem, "needs as many of both, or one of one"))
        count = several.pop() if several else 1
        return wrench_at(np.broadcast_to(f, (count, 3)), np.broadcast_to(p, (count, 3)), self.com)

    def checked_after_load(self) -> None:
        """Raise HoldfastError if the values that were read from a file cannot be those of a constraint."""
        axes = self.known[:12] if len(self.known) >= 12 else np.zeros((12, 6))
        along = np.concatenate([np.diag(axes[:6]), -np.diag(axes[6:])])
        if not (self.price >= 0).all() or not (along > 0).all() or np.count_nonzero(axes) != 12:
            problem = "the first twelve points are not along the axes, or a price is negative"
            raise HoldfastError(message("constraint: known", problem, "needs what a constraint saved"))

    def summary(self) -> Summary:
        """Summarise the constraint by the largest forces and torques along the axes."""
        what = "where an equilibrium exists" if self.claim is Claim.EXISTS else "that hold"
        headline = f"wrenches on {self.body} {what}: {len(self.price):,} known, half within {self.accuracy:.2%}"
        names = ("force x", "force y", "force z", "torque x", "torque y", "torque z")
        factors = self.value(np.vstack([np.eye(6), -np.eye(6)]))
        ends = np.asarray(factors).reshape(2, 6)
        rows = [
            [name, number(-ends[1, k], unit), number(ends[0, k], unit)]
            for k, (name, unit) in enumerate(zip(names, ("N",) * 3 + ("N m",) * 3, strict=True))
        ]
        facts = [("engine", f"{self.engine} ({self.claim.words})"), ("solves", str(self.solves))]
        facts += [("nine in ten within", f"{self.accuracy_of_most:.2%}")]
        if self.claim is Claim.HOLDS:
            facts += [("above lower in between", f"{self.above:.2%} of the checks, by up to {self.above_by:.2%}")]
        return Summary(headline, facts, ("along", "from", "to"), rows, self.notes)

    def _used(self, wrenches: ArrayLike, where: str) -> tuple[Float, Float, bool]:
        """Return the usages (n,), the cuts (n, 6), and whether there is a single wrench."""
        given, single = checked_rows(wrenches, 6, where)
        used, cut = hull_gauge(self.known, self.price, np.ascontiguousarray(given))
        return used, cut, single


def constraint(
    assembly: Assembly | Scene,
    body: str,
    *,
    exists: bool = False,
    accuracy: float = 0.02,
    near: ArrayLike | None = None,
    box: ArrayLike | None = None,
    solves: int = SOLVES,
    standing: Iterable[Load] = (),
) -> Constraint:
    """Find a function that gives a lower bound of the load factor of any wrench on ``body``; see Constraint.

    By default it is what holds: the ``lower`` of the default engine, at all wrenches that were asked and checked in as
    many in between. With ``exists`` it is proved for every wrench, but says only that an equilibrium exists.

    It evaluates tens of thousands of wrenches a second, whatever the assembly. ``near`` (n, 6) are examples of the
    wrenches that will be asked; only their directions matter. By default they are pushes on the body's surface,
    somewhat off its normals. ``accuracy`` is a target: the values of half of the wrenches should be that close to the
    true factors, and nine in ten within three times that. ``solves`` limits the number of solves. ``box`` (2,) holds
    the largest force [N] and torque [N m] components that will be asked, with the defaults of ``admissible_wrenches``.
    The weight and the ``standing`` loads act throughout.

    Raises SceneError if the body is fixed or unknown, or if something is held, unless with ``exists``. Raises
    HoldfastError if the assembly does not stand, or if the body is about to move, so that some direction takes no
    wrench at all.
    """
    assembly = checked_assembly(assembly)
    where = f"constraint on {quoted(body)}"
    wanted = checked_number(accuracy, f"{where}: accuracy", above=0, below=1, within=SCALE)
    checked_whole(solves, f"{where}: solves", 0, MANY)
    columns = wrench_columns(assembly, body, where)
    limits = wrench_box(assembly, box, where)
    index = assembly.index[body]
    com = np.array(assembly.com[index])
    wrenches = (
        inward_pushes(assembly, body, com) if near is None else checked(near, (None, 6), f"{where}: near", within=FORCE)
    )
    engine = engine_for(assembly, where, exists=exists)
    groups, near_by = prepared(engine, assembly, total_wrench(assembly, standing)), wrenches / limits
    above = by = 0.0
    if exists:
        state, rows = groups.together([index], where)
        hulls = HULLS.of(state, engine=engine.name, where=where)
        found = hulls.load_hull(columns[rows] * limits, near_by, wanted, solves, where)
        notes = notes_of(state, assembly)
    else:
        hull = checked_hull(lower_of(groups, [index], columns * limits, where), near_by, wanted, solves, where)
        found, above, by = hull.hull, hull.above, hull.by
        notes = (*groups.notes, *unchecked_limits(assembly.bodies), *hull.notes("wrenches"))
    if found.accuracy > wanted:
        notes += (
            f"half of the wrenches tested last may have values more than {found.accuracy:.1%} below the true factor",
        )
    return Constraint(
        body=body,
        engine=engine.name,
        claim=engine.claim,
        known=np.asarray(frozen(found.known * limits)),
        price=np.asarray(frozen(found.price)),
        com=com,
        box=limits,
        accuracy=found.accuracy,
        accuracy_of_most=found.accuracy_of_most,
        accuracy_wanted=wanted,
        solves=found.solves,
        notes=notes,
        above=above,
        above_by=by,
    )


def inward_pushes(assembly: Assembly, body: str, com: Float) -> Float:
    """Return wrenches (n, 6) of inward pushes of about 1 N all over the surface of a body, in random directions.

    There are many, because a function that fits a few wrenches well need not fit those between them.
    """
    surface = assembly.scene.body(body).surface_world
    cells = surface_cells(surface, float(np.sqrt(surface.area / PUSHES)))
    normals, points = np.repeat(cells.normals, ALONG, axis=0), np.repeat(cells.points, ALONG, axis=0)
    aside = OBLIQUE * np.random.default_rng(0).normal(size=normals.shape)
    return wrench_at(aside - normals, points, com)
