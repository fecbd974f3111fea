"""Reads scenes of Habitat (.scene_instance.json), with the configurations and meshes of the data set around them."""

from __future__ import annotations

import os
from collections.abc import Collection, Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from holdfast.base.arrays import Float, checked, checked_number, checked_truth
from holdfast.base.borders.foreign import foreign
from holdfast.base.errors import GeometryError, SceneError, located, message
from holdfast.base.files import read_ordinary
from holdfast.base.ranges import FRICTION, MASS, PLACE, SCALE
from holdfast.base.rigid import UNIT_LENGTH, Y_TO_Z, pose_from, transform
from holdfast.base.text import listed, quoted
from holdfast.scene.body import Body
from holdfast.scene.compound import Inertial
from holdfast.scene.formats.links import FLOOR, BodyPiece, checked_fixed, filled, rigid_body, scene_of, with_floor
from holdfast.scene.formats.made_meshes import hull_of
from holdfast.scene.formats.named_meshes import Numbers, Weights
from holdfast.scene.formats.references import References, model_folders
from holdfast.scene.formats.registry import Format
from holdfast.scene.formats.source import MAX_BYTES, PlainMap, Source, from_json
from holdfast.scene.formats.surfaces import Surfaces
from holdfast.scene.meshes.by_trimesh import Node, joined, read_nodes
from holdfast.scene.meshes.read import SUFFIXES
from holdfast.scene.scene import Scene
from holdfast.scene.shapes import Box, Mesh

MANIFEST = ".scene_dataset_config.json"  # the end of the name of the file that makes a folder a data set
MOST_FILES = 200_000  # largest number of files in the folders of a data set
STAGE = "stage"
# keys that are read, or that do not matter at rest; a note lists all others
SCENE_KEYS = ("stage_instance", "object_instances", "translation_origin", "default_lighting", "navmesh_instance",
              "semantic_scene_instance", "default_pbr_shader_config", "pbr_shader_region_configs",
              "user_defined")  # fmt: skip
INSTANCE_KEYS = ("template_name", "translation", "rotation", "motion_type", "uniform_scale", "non_uniform_scale",
                 "mass_scale", "apply_scale_to_mass", "translation_origin", "shader_type", "is_instance_visible",
                 "user_defined")  # fmt: skip
CONFIG_KEYS = ("render_asset", "collision_asset", "scale", "mass", "COM", "inertia", "friction_coefficient", "up",
               "front", "units_to_meters", "use_bounding_box_for_collision", "join_collision_meshes", "semantic_id",
               "margin", "restitution_coefficient", "rolling_friction_coefficient", "spinning_friction_coefficient",
               "linear_damping", "angular_damping", "requires_lighting", "force_flat_shading", "shader_type",
               "nav_asset", "semantic_asset", "semantic_descriptor_filename", "origin", "is_visible",
               "user_defined")  # fmt: skip


def sniff(source: Source) -> bool:
    """Tell whether the file is JSON with a ``stage_instance`` or ``object_instances``."""
    if source.suffix != ".json":
        return False
    data = source.data
    return isinstance(data, dict) and ("stage_instance" in data or "object_instances" in data)


def read(
    source: Source,
    *,
    friction: float | None = None,
    density: Numbers | None = None,
    mass: Numbers | None = None,
    fixed: Collection[str] = (),
    floor: bool = False,
    model_path: Iterable[str | Path] | None = None,
    gravity: ArrayLike = (0.0, 0.0, -9.81),
) -> Scene:
    """Return the scene of a scene instance of Habitat, turned so that its y axis, which is up, becomes z.

    The stage and objects that are not dynamic are fixed. Configurations and meshes are sought in the data set: the
    nearest folder above the file with a ``.scene_dataset_config.json``, or else the file's own, and those in
    ``model_path``. As in Habitat, each mesh of a collision asset is its convex hull, except those of the stage, and a
    pair takes the product of two coefficients. ``friction`` is the coefficient of configurations without one, and
    ``mass`` [kg] or ``density`` [kg/m³] are for objects without a mass, each one number or one for each name. ``fixed``
    names objects that never move, and ``floor`` adds the half space below z = 0.

    Raises SceneError or GeometryError if a file is malformed or missing, or leaves out what is needed.
    """
    notes: list[str] = ["y is up in the file: turned about x so that z is up"]
    data, where = source.data, str(source.path)
    if friction is not None:
        friction = checked_number(friction, "friction", minimum=0, within=FRICTION)
    data_set = _DataSet(source.path, model_folders(model_path, notes))
    top = _NotedMap(data, where, SCENE_KEYS, notes)
    instances = top.values.get("object_instances", [])
    if not isinstance(instances, list):
        top.fail("object_instances is no list", "needs a list of objects")
    things = []
    if "stage_instance" in top.values:
        things.append(
            _Instance.of(top.values["stage_instance"], f"{where}: stage_instance", data_set, top, STAGE, notes)
        )
    taken: dict[str, int] = {}
    for number, each in enumerate(instances):
        thing = _Instance.of(each, f"{where}: object_instances[{number}]", data_set, top, "", notes)
        taken[thing.name] = taken.get(thing.name, 0) + 1
        again = taken[thing.name]
        things.append(thing if again == 1 else thing._replace(name=f"{thing.name}_{again}"))
    names = [thing.name for thing in things]
    weights = Weights(mass, density, names)
    fixed_names, surfaces = checked_fixed(fixed, names, "object"), Surfaces("product")
    bodies = []
    for thing in things:
        weight = weights.of(thing.name, (thing.mass(), None))
        with located(f"{where}: {quoted(thing.name)}"):
            bodies += thing.body(weight, surfaces, friction, thing.name in fixed_names, notes)
    remedy = f"give floor=True for a floor at z = 0, or fixed=[name] ({listed(names)})"
    bodies = with_floor(bodies, floor, where, remedy)
    name = source.path.name.partition(".")[0]
    return scene_of(bodies, surfaces.table(FLOOR if floor else None), gravity, name, notes)


class _NotedMap(PlainMap):
    """A map whose keys that are not known are noted."""

    def __init__(self, values: Any, where: str, known: Collection[str], notes: list[str]) -> None:  # noqa: ANN401
        if not isinstance(values, dict):
            raise SceneError(message(where, f"is {quoted(values, 40)}", "needs keys and values"))
        self.values, self.where = values, where
        unread = [key for key in values if key not in known and values[key] not in ([], {}, None)]
        if unread:
            notes.append(f"{where}: not read, though it may matter: {listed(unread, 6)}")

    def number(self, key: str, usual: float) -> float:
        return checked_number(self.values.get(key, usual), f"{self.where}: {key}", above=0, within=SCALE)

    def triple(self, key: str, usual: tuple[float, float, float]) -> Float:
        return checked(self.values.get(key, usual), (3,), f"{self.where}: {key}", within=PLACE)

    def truth(self, key: str, usual: bool) -> bool:
        return checked_truth(self.values.get(key, usual), f"{self.where}: {key}")


@dataclass
class _DataSet:
    """The files of a data set, by their names; none outside of its folders is read."""

    path: Path
    models: tuple[Path, ...]
    configs: dict[Path, _NotedMap] = field(default_factory=dict)
    _known: dict[str, list[Path]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        here = Path(os.path.abspath(self.path)).parent
        root = next((each for each in (here, *here.parents) if any(each.glob(f"*{MANIFEST}"))), here)
        self.folders = [root, *self.models]
        count = 0
        for folder in self.folders:
            for above, _, files in os.walk(folder):
                count += len(files)
                if count > MOST_FILES:
                    problem = f"has more than {MOST_FILES:,} files"
                    raise SceneError(message(str(folder), problem, "give model_path= folders with less in them"))
                for name in files:
                    self._known.setdefault(name, []).append(Path(above) / name)

    def config(self, template: str, stage: bool, where: str, notes: list[str]) -> _NotedMap:
        """Return the configuration of a template, or one that only names its mesh."""
        name = template.rpartition("/")[2]
        end = ".stage_config.json" if stage else ".object_config.json"
        meshes = (name,) if name.lower().endswith(SUFFIXES) else (f"{name}.glb", f"{name}.obj")
        for file in (name if name.endswith(end) else f"{name}{end}", *meshes):
            found = sorted(self._known.get(file, []))
            whole = f"/{template.removesuffix(name)}{file}"
            beside = [path for path in found if path.as_posix().endswith(whole)]
            if found:
                path = (beside or found)[0]
                if path not in self.configs:
                    if path.suffix != ".json":
                        self.configs[path] = _NotedMap({"render_asset": path.name}, str(path), CONFIG_KEYS, notes)
                    else:
                        content = read_ordinary(path, "configuration", most=MAX_BYTES).decode("utf-8", "replace")
                        self.configs[path] = _NotedMap(from_json(content, str(path)), str(path), CONFIG_KEYS, notes)
                return self.configs[path]
        folders = listed([quoted(str(folder), 120) for folder in self.folders])
        remedy = "give model_path=[the folder of the data set]"
        raise SceneError(message(where, f"names {quoted(template)}: no {name}{end} in {folders}", remedy))

    def asset(self, config: _NotedMap) -> Path:
        """Return the path of the mesh with which an object collides."""
        key = "collision_asset" if config.values.get("collision_asset") else "render_asset"
        given, here = config.text(key), Path(config.where)
        inside = {str(number): folder for number, folder in enumerate(self.folders)}
        return References(here, inside, "model_path").file(given, config.where)


class _Instance(NamedTuple):
    """An instance in the scene with its configuration."""

    name: str
    given: _NotedMap
    config: _NotedMap
    asset: Path
    stage: bool
    origin: str

    @classmethod
    def of(cls, values: Any, where: str, data_set: _DataSet, top: _NotedMap, name: str, notes: list[str]) -> _Instance:  # noqa: ANN401
        given = _NotedMap(values, where, INSTANCE_KEYS, notes)
        template = given.text("template_name")
        config = data_set.config(template, bool(name), where, notes)
        origin = str(given.values.get("translation_origin") or top.values.get("translation_origin") or "asset_local")
        if origin.lower() not in ("com", "asset_local"):
            given.fail(f"translation_origin is {quoted(origin)}", "needs COM or asset_local")
        short = template.rpartition("/")[2].partition(".")[0]
        return cls(name or short, given, config, data_set.asset(config), bool(name), origin.lower())

    def mass(self) -> float | None:
        """Return the mass [kg] that the files give, with the scales of the instance."""
        value = self.config.values.get("mass")
        if value is None:
            return None
        found = checked_number(value, f"{self.config.where}: mass", above=0, within=MASS)
        found *= self.given.number("mass_scale", 1.0)
        return found * float(self._stretch().prod()) if self.given.truth("apply_scale_to_mass", True) else found

    def _stretch(self) -> Float:
        return self.given.number("uniform_scale", 1.0) * self.given.triple("non_uniform_scale", (1, 1, 1))

    def body(
        self, weight: tuple[float | None, float | None], surfaces: Surfaces, friction: float | None, fixed: bool,
        notes: list[str],
    ) -> list[Body]:  # fmt: skip
        """Return the body of this instance; none if it does not collide."""
        motion = str(self.given.values.get("motion_type", "dynamic")).lower()
        if motion not in ("static", "kinematic", "dynamic", "undefined"):
            self.given.fail(f"motion_type is {quoted(motion)}", "needs STATIC, KINEMATIC or DYNAMIC")
        if not self.config.values.get("is_collidable", True):
            notes.append(f"left out, as it collides with nothing: {self.name}")
            return []
        still = self.stage or fixed or motion in ("static", "kinematic")
        scale = self.config.triple("scale", (1, 1, 1)) * self.config.number("units_to_meters", 1.0) * self._stretch()
        if (scale <= 0).any():
            self.given.fail(f"is scaled by {scale.tolist()}", "needs factors > 0")
        value = self.config.values.get("friction_coefficient", friction)
        if value is None:
            self.config.fail("has no friction_coefficient", "give friction=, for all without one")
        mu = checked_number(value, f"{self.config.where}: friction_coefficient", minimum=0, within=FRICTION)
        material = surfaces.material(mu)
        meshes = self._meshes(scale, notes)
        vertices = np.vstack([mesh.vertices for mesh in meshes])
        low, high = vertices.min(0), vertices.max(0)
        if self.config.truth("use_bounding_box_for_collision", False) and not self.stage:
            middle = np.eye(4)
            middle[:3, 3] = (low + high) / 2
            pieces = [BodyPiece(Box(high - low), middle, material)]
        else:
            pieces = [BodyPiece(mesh, np.eye(4), material) for mesh in meshes]
        given = "COM" in self.config.values
        com = self.config.triple("COM", (0, 0, 0)) if given else (low + high) / 2
        if not given and not self.stage:
            notes.append(f"{self.config.where}: no COM, so it is in the middle of the bounding box, as in Habitat")
        w, x, y, z = checked(self.given.values.get("rotation", (1, 0, 0, 0)), (4,), f"{self.given.where}: rotation")
        if abs(np.linalg.norm((w, x, y, z)) - 1) > UNIT_LENGTH:
            self.given.fail("has a quaternion of another length than 1", "needs w, x, y, z")
        pose = np.array(pose_from(self.given.triple("translation", (0, 0, 0)), np.array([w, x, y, z])))
        if self.origin == "com" and not self.stage:
            pose[:3, 3] -= pose[:3, :3] @ com
        inertial = None
        if not still:
            mass, density = weight
            if mass is None and density is None:
                self.config.fail("has no mass", "give mass= or density=, for it or for all")
            shape = filled(pieces, 1.0 if density is None else density)
            inertial = Inertial(shape.mass, com, shape.about(com)).weighing(mass)
        return [rigid_body(self.name, pieces, pose=Y_TO_Z @ pose, inertial=inertial, fixed=still)]

    def _meshes(self, scale: Float, notes: list[str]) -> list[Mesh]:
        """Return the meshes of the asset in the frame of the object: hulls of its parts, or for a stage as they are."""
        up, front = self.config.triple("up", (0, 1, 0)), self.config.triple("front", (0, 0, -1))
        own = np.column_stack([np.cross(front, up), up, -front])
        if np.abs(own @ own.T - np.eye(3)).max() > UNIT_LENGTH:
            self.config.fail("up and front are no two unit vectors at right angles", "correct them")
        turn = own.T
        if self.asset.suffix.lower() == ".glb":
            content = read_ordinary(self.asset, "mesh file", most=MAX_BYTES)
            with foreign(str(self.asset), error=GeometryError):
                nodes, _, _ = read_nodes(content)
            found = [node._replace(vertices=transform(node.matrix, node.vertices)) for node in nodes]
        else:
            mesh = Mesh.from_file(self.asset, up_axis="z")
            found = [Node("", mesh.vertices, mesh.faces, np.eye(4))]
        if not found:
            raise GeometryError(message(str(self.asset), "holds no triangles", "needs a mesh"))
        if self.config.truth("join_collision_meshes", False) and not self.stage:
            found = [joined(found)]
        made = [Mesh((node.vertices * scale) @ turn.T, node.faces, label=str(self.asset)) for node in found]
        if self.stage:
            return made
        notes.append("meshes of objects are their convex hulls, as Habitat collides them")
        return [hull_of(mesh) for mesh in made]


HABITAT = Format("Habitat scene", (".json",), sniff, read, mark="`object_instances`")
