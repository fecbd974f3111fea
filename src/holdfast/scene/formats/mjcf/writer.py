"""Write MJCF files that MuJoCo loads with the same masses, inertias, poses, shapes and friction of every pair.

MuJoCo collides the convex hull of a mesh and keeps its vertices in single precision, so a hollow body has to be a
compound. Coefficients stand at the geoms where the larger one of two is that of the pair, else in ``<pair>``s. Where
single parts are excluded, their bodies are, and ``<pair>``s name the geoms that may touch. Names of materials,
densities, what bodies may bear, and how finely round shapes are divided have no place in the format.
"""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree as Xml

import numpy as np

from holdfast.base.arrays import Float
from holdfast.base.errors import SceneError, message
from holdfast.base.rigid import quaternion_of
from holdfast.base.text import quoted
from holdfast.scene.body import Body
from holdfast.scene.compound import Solid, solids_in
from holdfast.scene.excluded import Excluded, by_bodies, may_touch
from holdfast.scene.formats.surfaces import Unit, table_of, units_of
from holdfast.scene.halfspace import HalfSpace
from holdfast.scene.round_shapes import Capsule, Ellipsoid
from holdfast.scene.scene import Scene
from holdfast.scene.shapes import Box, Cylinder, Mesh, Sphere

WORLD = "world"  # a name that MuJoCo reserves
FRICTIONLESS, SLIDING = "1", "3"  # condim


def write(scene: Scene, path: Path) -> bytes:
    """Return the content of an MJCF file with the scene.

    Raises SceneError for a name that XML or MuJoCo cannot hold, for a pair of bodies without friction, and for inertias
    that no mass distribution has.
    """
    del path
    for name in (scene.name, *(body.name for body in scene.bodies)):
        if name == WORLD:
            raise SceneError(message(f"body {quoted(name)}", "has the name of MuJoCo's world", "give it another name"))
        if any(not (c.isprintable() or c in "\t\n") for c in name):
            raise SceneError(message(f"name {quoted(name)}", "holds what XML cannot", "give it another name"))
    root = Xml.Element("mujoco", {"model": scene.name} if scene.name else {})
    Xml.SubElement(root, "compiler", angle="radian", balanceinertia="false", boundmass="0", boundinertia="0")
    Xml.SubElement(root, "option", gravity=_text(scene.gravity))
    assets, world = Xml.SubElement(root, "asset"), Xml.SubElement(root, "worldbody")
    units = units_of(scene)
    mu, touch = table_of(scene, units)
    own = np.where(touch, mu, np.inf).min(1, initial=np.inf)
    own[~np.isfinite(own)] = 0.0
    others = touch & (np.maximum(own[:, None], own[None]) != mu)
    friction = {geom: float(own[k]) for k, unit in enumerate(units) for geom in _geoms(unit)}
    for body in scene.bodies:
        _write_body(world, assets, body, friction)
    if not len(assets):
        root.remove(assets)
    contact = Xml.SubElement(root, "contact")
    for (a, b), apart in by_bodies(scene.excluded).items():
        Xml.SubElement(contact, "exclude", body1=a, body2=b)
        _write_parts(contact, scene, scene.body(a), scene.body(b), apart)
    for i, j in np.argwhere(np.triu(others)).tolist():
        for one in _geoms(units[i]):
            for two in _geoms(units[j]):
                Xml.SubElement(contact, "pair", {"geom1": one, "geom2": two} | _sliding(float(mu[i, j]), 5))
    Xml.indent(root)
    return (Xml.tostring(root, encoding="unicode") + "\n").encode()


def _geoms(unit: Unit) -> list[str]:
    return [_geom(unit.body, part) for part in unit.parts]


def _geom(body: Body, part: int) -> str:
    return f"{body.name}/{part}"


def _write_parts(contact: Xml.Element, scene: Scene, a: Body, b: Body, apart: list[Excluded]) -> None:
    """Write the pairs of geoms that may touch though their bodies are excluded, which MuJoCo lets them."""
    if a.fixed and b.fixed:
        return
    for i, j in np.argwhere(may_touch(a, b, apart)).tolist():
        mu = scene.friction.between(a.name, b.name, {a.name: a.materials[i], b.name: b.materials[j]})
        Xml.SubElement(contact, "pair", {"geom1": _geom(a, i), "geom2": _geom(b, j)} | _sliding(mu, 5))


def _sliding(mu: float, count: int) -> dict[str, str]:
    """Return the attributes of a geom (count 3) or pair (count 5) with a coefficient; none at all is condim 1."""
    rest = (0.005, 0.0001) if count == 3 else (mu, 0.005, 0.0001, 0.0001)
    return {"friction": _text(np.array([mu, *rest])), "condim": SLIDING if mu else FRICTIONLESS}


def _write_body(world: Xml.Element, assets: Xml.Element, body: Body, friction: dict[str, float]) -> None:
    element = Xml.SubElement(world, "body", {"name": body.name} | _placed(body.pose))
    if not body.fixed:
        Xml.SubElement(element, "freejoint")
        moments, axes = np.linalg.eigh(body.inertia_com)  # MuJoCo takes principal moments and their axes
        if moments[0] <= 0 or moments[0] + moments[1] < moments[2] * (1 - 1e-12):
            problem = f"has the principal moments {', '.join(f'{m:.4g}' for m in moments)} kg m²"
            remedy = "MuJoCo needs positive ones, the largest at most the sum of the others"
            raise SceneError(message(f"body {quoted(body.name)}", problem, remedy))
        moments[2] = min(moments[2], moments[0] + moments[1])
        turn = axes * [1.0, 1.0, float(np.linalg.det(axes))]
        place = {"pos": _text(body.com_body), "quat": _text(quaternion_of(turn))}
        mass = {"mass": repr(float(body.mass or 0.0)), "diaginertia": _text(moments)}
        Xml.SubElement(element, "inertial", place | mass)
    if isinstance(body.shape, HalfSpace):
        name = _geom(body, 0)
        plane = {"name": name, "type": "plane", "size": "0 0 1"}
        Xml.SubElement(element, "geom", plane | _sliding(friction[name], 3))
        return
    for k, (shape, pose) in enumerate(solids_in(body.shape)):
        name = _geom(body, k)
        _write_geom(element, assets, shape, {"name": name} | _placed(pose) | _sliding(friction[name], 3))


def _write_geom(element: Xml.Element, assets: Xml.Element, shape: Solid, attributes: dict[str, str]) -> None:
    match shape:
        case Box():
            kind, size = "box", shape.size / 2
        case Sphere():
            kind, size = "sphere", np.array([shape.radius])
        case Capsule():
            kind, size = "capsule", np.array([shape.radius, shape.length / 2])
        case Cylinder():
            kind, size = "cylinder", np.array([shape.radius, shape.height / 2])
        case Ellipsoid():
            kind, size = "ellipsoid", shape.radii
        case Mesh():
            surface, name = shape.surface, attributes["name"]
            data = {"vertex": _text(surface.vertices.ravel()), "face": " ".join(map(str, surface.faces.ravel()))}
            Xml.SubElement(assets, "mesh", {"name": name, "inertia": "convex"} | data)
            Xml.SubElement(element, "geom", attributes | {"type": "mesh", "mesh": name})
            return
    Xml.SubElement(element, "geom", attributes | {"type": kind, "size": _text(size)})


def _placed(pose: Float) -> dict[str, str]:
    return {"pos": _text(pose[:3, 3]), "quat": _text(quaternion_of(pose[:3, :3]))}


def _text(values: Float) -> str:
    """Return numbers as an attribute, every digit kept."""
    return " ".join(repr(float(value)) for value in np.ravel(values))
