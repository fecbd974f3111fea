"""Straps, lashings and bands of film: pretension as standing forces, stretching as tension-only elastic bands.

A strap runs straight from point to point. At a point on a body it bends by an angle β. If it was tightened over the
point with the friction coefficient μ, the tension beyond is smaller by the capstan law (Euler, Eytelwein)

    T_after = T_before exp(-μ β)

and the forces on the body are T_before along the strap towards the tensioner and T_after along it away from there. A
strap only pulls: at its ends it pulls the body that it is hooked to, and at a bend it presses on the body.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from holdfast.assembly.assembly import Assembly
from holdfast.assembly.on_surface import check_on_surface
from holdfast.base.arrays import Float, checked, checked_items, checked_name, checked_number, checked_truth, frozen
from holdfast.base.errors import SceneError, located, message, nearest_of
from holdfast.base.files import checked_path, read_ordinary
from holdfast.base.public import Record, column
from holdfast.base.ranges import FORCE, FRICTION, LENGTH, PLACE, STIFFNESS
from holdfast.base.rigid import tangents
from holdfast.base.text import quoted
from holdfast.base.values import seal
from holdfast.contacts.interface import Interface, Patch
from holdfast.geometry.distance import winding_number
from holdfast.geometry.hull import convex_hull
from holdfast.queries.request import Load, checked_assembly
from holdfast.scene.body import Body
from holdfast.scene.formats.source import from_json, from_yaml
from holdfast.scene.scene import Scene

BENT = 1e-6  # sine of the angle above which a strap counts as bent at a point
DEPTH = 1e-3  # depth inside a bend at which the body must be, as a share of the body's size
FIELDS = ("route", "pretension", "mu", "closed", "spring")
NEEDED = ("route", "pretension")
MOST_BYTES = 10_000_000  # largest size of a file with straps
FORM = "needs a list of {route: [[BODY, X, Y, Z], ...], pretension: N}, optionally mu, closed, spring"


class Strap(Record):
    """A strap along ``points`` (k, 3) [m], in the world frame, on the bodies named in ``bodies``.

    Its ``route`` is given as pairs of the name of a body and a point on its surface. It is hooked to the body at the
    first and the last point, and led over the bodies at all others. It is tightened to the ``pretension`` [N] at the
    first point; ``mu`` is its friction coefficient at the points, and 0 means the same tension everywhere. If
    ``closed``, it returns from the last point to the first, as film does, and is hooked to nothing; the tension is then
    the same everywhere, so ``mu`` must be 0. ``spring`` [N/m] is its stiffness, see ``tied``.

    Raises SceneError for fewer than two points (three if closed), two that coincide, or numbers out of range.
    """

    bodies: tuple[str, ...]
    points: Float = column("k 3")
    pretension: float
    mu: float
    closed: bool
    spring: float | None

    def __init__(
        self,
        route: Sequence[tuple[str, Any]],
        pretension: float,
        *,
        mu: float = 0.0,
        closed: bool = False,
        spring: float | None = None,
    ) -> None:
        where = "strap"
        round_all = checked_truth(closed, f"{where}: closed")
        least = 3 if round_all else 2
        pairs = checked_items(route, f"{where}: route", "pairs (body, point)")
        if len(pairs) < least or any(not isinstance(pair, tuple | list) or len(pair) != 2 for pair in pairs):
            raise SceneError(message(where, f"has the route {quoted(route, 80)}", f"needs {least} pairs or more"))
        set_ = object.__setattr__
        set_(self, "bodies", tuple(checked_name(name, f"{where}: body") for name, _ in pairs))
        set_(self, "points", np.array([checked(p, (3,), f"{where}: point", within=PLACE) for _, p in pairs]))
        set_(self, "pretension", checked_number(pretension, f"{where}: pretension", minimum=0, within=FORCE))
        set_(self, "mu", checked_number(mu, f"{where}: mu", minimum=0, within=FRICTION))
        set_(self, "closed", round_all)
        stiff = None if spring is None else checked_number(spring, f"{where}: spring", above=0, within=STIFFNESS)
        set_(self, "spring", stiff)
        seal(self)
        if round_all and self.mu:
            raise SceneError(message(where, "is closed and has mu", "leave mu out: it has no first point"))
        if (self.lengths < LENGTH.least).any():
            raise SceneError(message(where, "two neighbouring points coincide", "needs points apart from each other"))

    @classmethod
    def around(
        cls, assembly: Assembly | Scene, height: float, pretension: float, bodies: Iterable[str] | None = None
    ) -> Strap:
        """Return a closed band, such as a layer of stretch film, around movable bodies at one height.

        ``height`` [m] is measured along the up direction of the scene from its origin. The band runs along the convex
        hull of the cross-section of the ``bodies`` (by default all movable ones) and presses on the bodies at its
        corners. Film with a containment force of f newtons per metre of height can be modelled by a band with the
        pretension f h at every h metres. Raises SceneError if there is no body at this height.
        """
        given = checked_assembly(assembly)
        up = given.scene.up
        level = checked_number(height, "strap: height", within=PLACE)
        names = given.scene.checked_names(bodies) if bodies is not None else {body.name for body in given.movable}
        sections = [(body.name, _cross_section(body, up, level)) for body in given.movable if body.name in names]
        points = np.vstack([np.empty((0, 3)), *(section for _, section in sections)])
        owner = [name for name, section in sections for _ in section]
        if not len(points):
            raise SceneError(
                message("strap: height", f"there is no body at {level:g} m", "needs a height within a body")
            )
        frame = np.array(tangents(up))
        flat = points @ frame.T
        corners = convex_hull(flat, 1e-9 * float(np.ptp(flat, axis=0).max()))
        chosen = [int(np.argmin(((flat - corner) ** 2).sum(1))) for corner in corners]
        return cls([(owner[k], points[k]) for k in chosen], pretension, closed=True)

    @classmethod
    def from_file(cls, path: str | os.PathLike[str]) -> tuple[Strap, ...]:
        """Read straps from a .yaml or .json file: a list with the arguments of ``Strap`` by name.

        Each ``route`` is a list of [body, x, y, z] with coordinates in metres, world frame. Raises SceneError for
        anything else.
        """
        straps = []
        for number, entry in enumerate(strap_entries(path), 1):
            with located(f"{path}: strap {number}"):
                straps.append(cls(**entry))
        return tuple(straps)

    @property
    def lengths(self) -> Float:
        """The lengths [m] of the straight pieces, in order."""
        return frozen(np.asarray(np.linalg.norm(self._ahead, axis=1)))

    @property
    def _ahead(self) -> Float:
        """The vectors [m] from each point to the next one."""
        following = np.roll(self.points, -1, axis=0) - self.points
        return following if self.closed else following[:-1]

    @property
    def tensions(self) -> Float:
        """The tension [N] of each straight piece, beginning at the tensioner."""
        ways = self._ahead / self.lengths[:, None]
        cosine = np.clip((ways[1:] * ways[:-1]).sum(1), -1, 1)
        wrapped = np.concatenate([[0.0], np.cumsum(np.arccos(cosine))])
        return frozen(np.asarray(self.pretension * np.exp(-self.mu * wrapped)))

    def forces(self) -> Float:
        """Return the forces (k, 3) [N] of the strap on the bodies at its k points; they add up to zero."""
        pull = self.tensions[:, None] * self._ahead / self.lengths[:, None]
        if self.closed:
            return np.asarray(pull - np.roll(pull, 1, axis=0))
        none = np.zeros((1, 3))
        return np.asarray(np.vstack([pull, none]) - np.vstack([none, pull]))

    def loads(self, assembly: Assembly | Scene) -> tuple[Load, ...]:
        """Return the forces of the strap on its bodies as loads, for the argument ``standing`` of any query.

        The tension is constant: a strap is so much softer than contacts that the small motions with which bodies begin
        to move hardly change it. Raises SceneError for an unknown body, a point that is not on its body, or a bend that
        would pull the body that the strap is led over instead of pressing on it.
        """
        given = checked_assembly(assembly)
        self.check(given)
        return tuple(Load(name, p, f) for name, p, f in zip(self.bodies, self.points, self.forces(), strict=True))

    def check(self, assembly: Assembly) -> None:
        """Raise SceneError if the strap does not lie on the bodies of the assembly; see ``loads``."""
        ways = self._ahead / self.lengths[:, None]
        for k, (name, point) in enumerate(zip(self.bodies, self.points, strict=True)):
            check_on_surface(assembly, name, point[None], f"strap at {quoted(name)}")
            if not self.closed and k in (0, len(self.bodies) - 1):
                continue
            into = ways[k] - ways[k - 1]
            bend = float(np.linalg.norm(into))
            body = assembly.scene.body(name)
            inside = point + DEPTH * body.shape.surface.diagonal * into / max(bend, BENT)
            if bend > BENT and winding_number(inside[None], body.surface_world) < 0.5:
                problem = f"is led around point {k}, but the body lies on the other side of the strap"
                raise SceneError(
                    message(f"strap at {quoted(name)}", problem, "lead it over the body, or hook it there")
                )

    @staticmethod
    def tied(assembly: Assembly | Scene, straps: Iterable[Strap], *, bedding: float) -> Assembly:
        """Return the assembly with straps as tension-only elastic bands.

        A band acts in addition to the pretension, which is given as ``standing=strap.loads(assembly)``: it adds tension
        where its ends move apart and nothing where they approach. It is a frictionless contact between the two bodies,
        with its normal along the strap, so it pulls and never pushes. It has no strength limit: compare its force
        (``stability(...).forces``) with the strength of the strap. For engine ``limit``, a band is rigid; for engine
        ``compliant``, its ``spring`` [N/m] is relative to the ``bedding`` [N/m³], the stiffness of contacts per area.
        Only straps between two points can be bands; one that is led over bodies has pretension only.

        Later edits of the assembly may drop the bands, so tie straps last. Raises SceneError for a strap without
        ``spring``, with more than two points, within one body or between fixed bodies.
        """
        given = checked_assembly(assembly)
        per_area = checked_number(bedding, "tied: bedding", above=0, within=STIFFNESS)
        bands = []
        for strap in checked_items(straps, "tied: straps", "straps"):
            if not isinstance(strap, Strap):
                raise SceneError(
                    message("tied: straps", f"hold a {type(strap).__name__}", "needs holdfast.Strap objects")
                )
            strap.check(given)
            bodies, stiff = strap.bodies, strap.spring
            if len(strap.points) != 2 or stiff is None:
                problem = "has no spring" if stiff is None else f"has {len(strap.points)} points"
                raise SceneError(message("tied: strap", problem, "needs two points and a spring [N/m]"))
            if bodies[0] == bodies[1] or all(given.scene.body(name).fixed for name in bodies):
                raise SceneError(
                    message("tied: strap", f"joins {quoted(bodies)}", "needs two bodies, one of them movable")
                )
            back = (strap.points[0] - strap.points[1]) / strap.lengths[0]
            patch = Patch(frozen(strap.points[1:].copy()), frozen(back), breadth=float(np.sqrt(stiff / per_area)))
            bands.append(Interface((bodies[0], bodies[1]), patches=[patch], mu=0.0))
        return replace(given, interfaces=(*given.interfaces, *bands))


def _cross_section(body: Body, up: Float, level: float) -> Float:
    """Return the points (m, 3) [m] where the edges of a body's surface cross a horizontal plane."""
    surface = body.surface_world
    edges = np.vstack([surface.faces[:, [k, (k + 1) % 3]] for k in range(3)])
    low, high = surface.vertices[edges[:, 0]], surface.vertices[edges[:, 1]]
    a, b = low @ up - level, high @ up - level
    crossing = (a <= 0) & (b > 0)
    share = a[crossing] / (a[crossing] - b[crossing])
    return np.asarray(low[crossing] + share[:, None] * (high - low)[crossing])


def strap_entries(path: str | os.PathLike[str]) -> tuple[dict[str, Any], ...]:
    """Return the arguments of ``Strap`` by name for each strap in a file, whose form ``Strap.from_file`` describes.

    Raises SceneError for any other content.
    """
    file = checked_path(path, "straps")
    content = read_ordinary(file, "straps", most=MOST_BYTES, too_large="take fewer straps")
    with located(str(file)):
        try:
            text = content.decode("utf-8-sig")
        except UnicodeDecodeError:
            raise SceneError(message("straps", "the file is not a text", FORM)) from None
        data = (from_json if file.suffix.lower() == ".json" else from_yaml)(text, str(file))
        if not isinstance(data, list):
            raise SceneError(message("straps", f"the file holds a {type(data).__name__}", FORM))
        entries = []
        for number, entry in enumerate(data, 1):
            with located(f"strap {number}"):
                if not isinstance(entry, dict) or any(name not in entry for name in NEEDED):
                    raise SceneError(message("strap", f"is {quoted(entry, 80)}", FORM))
                unknown = [name for name in entry if name not in FIELDS]
                if unknown:
                    problem = f"has a field {quoted(unknown[0])}"
                    raise SceneError(message("strap", problem, nearest_of(unknown[0], FIELDS)))
                points = entry["route"]
                if not isinstance(points, list) or any(not isinstance(p, list) or len(p) != 4 for p in points):
                    raise SceneError(message("strap: route", f"is {quoted(points, 80)}", FORM))
                if not isinstance(entry.get("closed", False), bool):
                    raise SceneError(message("strap: closed", f"is {quoted(entry['closed'])}", "needs true or false"))
                given = {name: value for name, value in entry.items() if name != "route" and value is not None}
                entries.append({"route": [(str(body), place) for body, *place in points], **given})
        return tuple(entries)
