"""Measure the room around a placed object: to the edges of its supports, and to the bodies beside it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely

from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import Float, unit
from holdfast.base.rigid import tangents
from holdfast.contacts.interface import Interface, Patch
from holdfast.contacts.neighbours import box_distance
from holdfast.contacts.overlap import distance
from holdfast.scene.body import Body

STEEPEST = 0.2  # cosine of the largest angle between up and the normal of a surface that can carry weight
ALIKE = 0.9  # cosine of the largest angle between the normals of a contact and of the triangles of its top
ROOM = 1.1  # an object may overhang if the tops are smaller than this multiple of it: exact fits are rarely found
NOTHING = 1e-3  # overhang that is allowed for rounding and round faces, as a share of the object's size
AROUND = 8  # number of directions of a step, and on each of two rings of the approach cone, besides its axis
SLIT = 0.02  # width of gaps between tops that do not count as edges, as a share of the object's size


def around(axes: Float) -> Float:
    """Return the unit directions (AROUND, 3) of steps in the plane of two ``axes`` (2, 3)."""
    angles = 2 * np.pi * np.arange(AROUND) / AROUND
    return np.column_stack([np.cos(angles), np.sin(angles)]) @ axes


def contacts_of(name: str, interfaces: Sequence[Interface]) -> list[Interface]:
    """Return the interfaces of one body."""
    return [interface for interface in interfaces if name in interface.bodies]


def _across(name: str, interface: Interface) -> tuple[str, float]:
    """Return the other body of an interface, and the sign with which its normals point from there into ``name``."""
    first, second = interface.bodies
    return (first, 1.0) if second == name else (second, -1.0)


def _carrying(interface: Interface, sense: float, up: Float) -> list[Patch]:
    """Return the patches whose normals, times ``sense``, face along ``up`` (3,), so that they can carry weight."""
    return [patch for patch in interface.patches if sense * float(patch.normal @ up) > STEEPEST]


def supporting_bodies(name: str, interfaces: Sequence[Interface], up: Float) -> set[str]:
    """Return the names of the bodies that support ``name`` from below, by contacts that face along ``up`` (3,)."""
    across = [(*_across(name, interface), interface) for interface in contacts_of(name, interfaces)]
    return {other for other, sense, interface in across if _carrying(interface, sense, up)}


def normals_into(assembly: Assembly, name: str) -> Float:
    """Return the normals (n, 3) of all contact patches of a body, which point into it."""
    sides = [(_across(name, i)[1], i) for i in contacts_of(name, assembly.interfaces)]
    return np.array([side * patch.normal for side, i in sides for patch in i.patches]).reshape(-1, 3)


def edge_margin(placed: Body, beside: Sequence[Body], interfaces: Sequence[Interface], up: Float) -> float:
    """Return the smallest distance [m] between a supporting contact patch and the edges of the tops beneath it.

    It is measured as seen along ``up`` (3,), with the tops of all supports joined. It is 0 for an object that overhangs
    an edge, and if no patch supports it from below. ``interfaces`` are those of ``placed`` with the bodies ``beside``.
    """
    axes, slit = np.array(tangents(up)), SLIT * placed.size
    under = _underneath(placed, beside, interfaces, up)
    feet = [shapely.MultiPoint(patch.polygon @ axes.T).convex_hull for _, _, patch, _ in under]
    if not feet:
        return 0.0
    edge = (
        shapely.union_all([top for *_, top in under])
        .buffer(slit, join_style="mitre")
        .buffer(-slit, join_style="mitre")
        .boundary
    )
    return float(min(edge.distance(foot) for foot in feet)) if not edge.is_empty else 0.0


def way_back(placed: Body, beside: Sequence[Body], interfaces: Sequence[Interface], up: Float) -> Float | None:
    """Return the horizontal shift (3,) [m] that ends the overhang of an object over an edge, or None without one.

    Seen along ``up`` (3,), the faces on which the object lies must be within the tops of its supports, or within their
    convex hull if there are several. An object may overhang if it is larger than the tops, or about as large. The shift
    moves its faces into the smallest rectangle around the tops. ``interfaces`` are those of ``placed`` with the bodies
    ``beside``.
    """
    axes, slack = np.array(tangents(up)), NOTHING * placed.size
    under = _underneath(placed, beside, interfaces, up)
    feet = [_top(placed, patch.polygon, -sense * patch.normal, up, SLIT * placed.size) for _, sense, patch, _ in under]
    carriers = {other for other, *_ in under}
    whole, foot = shapely.union_all([top for *_, top in under]), shapely.union_all(feet)
    if foot.is_empty or not foot.area > 0:  # the object lies on a round side, an edge or a corner
        return None
    whole = whole.convex_hull if len(carriers) > 1 else whole
    sides, room = _sides(foot), _sides(whole)
    fits = np.sort(np.linalg.norm(sides, axis=1)) * ROOM <= np.sort(np.linalg.norm(room, axis=1))
    if not fits.all() or whole.buffer(slack).covers(foot):
        return None
    ways = room / np.linalg.norm(room, axis=1)[:, None]
    inner, outer = (shapely.get_coordinates(shape.convex_hull) @ ways.T for shape in (foot, whole))
    back = np.maximum(outer.min(0) - inner.min(0), 0) + np.minimum(outer.max(0) - inner.max(0), 0)
    return np.asarray(back @ ways @ axes)


def _underneath(
    placed: Body, beside: Sequence[Body], interfaces: Sequence[Interface], up: Float
) -> list[tuple[str, float, Patch, shapely.Geometry]]:
    """Return each patch that supports an object, with the name of the support, the sense of the normal and the top."""
    bodies, found = {body.name: body for body in beside}, []
    for interface in interfaces:
        other, sense = _across(placed.name, interface)
        for patch in _carrying(interface, sense, up):
            top = _top(bodies[other], patch.polygon, sense * patch.normal, up, SLIT * placed.size)
            found.append((other, sense, patch, top))
    return found


def _sides(outline: shapely.Geometry) -> Float:
    """Return two sides (2, 2) of the smallest rectangle around an outline, as vectors."""
    return np.diff(shapely.get_coordinates(shapely.minimum_rotated_rectangle(outline)), axis=0)[:2]


def _top(support: Body, corners: Float, normal: Float, up: Float, slack: float) -> shapely.Geometry:
    """Return the outline, seen along ``up``, of the part of a support's surface on which a patch lies.

    It consists of the triangles that face like ``normal`` (3,), at the heights of the patch's ``corners`` (k, 3) [m] to
    within ``slack`` [m].
    """
    surface, axes = support.reduced_world, np.array(tangents(up))
    triangles = surface.vertices[surface.faces]
    heights, level = triangles @ up, corners @ up
    alike = surface.normals @ normal > ALIKE
    near = (heights.min(1) <= level.max() + slack) & (heights.max(1) >= level.min() - slack)
    flat = triangles[alike & near] @ axes.T
    return shapely.union_all(shapely.make_valid(shapely.polygons(flat)))


def clearance(placed: Body, others: Sequence[Body], search: float) -> float:
    """Return the distance [m] of the object from the nearest of ``others``, or ``search`` [m] if that is smaller."""
    least = search
    for gap, body in sorted(((box_distance(placed, body), body) for body in others), key=lambda pair: pair[0]):
        if gap >= least:
            break
        found = distance(placed, body, least)
        least = least if found is None else min(least, found)
    return least


def support_normal(assembly: Assembly, name: str) -> Float | None:
    """Return the mean unit normal (3,) of the contacts that support a body from below, or None if there are none."""
    normals = normals_into(assembly, name)
    carrying = normals[normals @ assembly.scene.up > STEEPEST]
    return unit(carrying.sum(0)) if len(carrying) else None


def rests_on(assembly: Assembly, name: str, *, touching: bool = True) -> tuple[str, ...]:
    """Return the names of the bodies that ``name`` touches and of all bodies that support these, down to the ground.

    Without ``touching``, only those that support ``name``, directly or through others. One body supports another if a
    contact between them faces upwards. Other bodies on the same ground do not count.
    """
    carriers: dict[str, set[str]] = {body.name: set() for body in assembly.bodies}
    touched = set()
    for interface in assembly.interfaces:
        for body in interface.bodies:
            other, sense = _across(body, interface)
            if _carrying(interface, sense, assembly.scene.up):
                carriers[body].add(other)
        if name in interface.bodies:
            touched |= {*interface.bodies}
    found, waiting = set[str](), sorted((touched if touching else carriers[name]) - {name})
    while waiting:
        body = waiting.pop()
        if body not in found:
            found.add(body)
            waiting += sorted(carriers[body] - {name})
    return tuple(body.name for body in assembly.bodies if body.name in found)
