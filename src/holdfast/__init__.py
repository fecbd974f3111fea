"""How hard can you push here before something moves: robustness of rigid assemblies in frictional contact.

Every public name is imported when it is first used, so that ``import holdfast`` costs next to nothing.
"""

import os
import sys

# `python -m holdfast` searches the current folder first, where anybody's scenes and other files may be: no longer from
# here on, unless holdfast itself lies there. While Python looks for the module it has put "-m" into sys.argv.
if getattr(sys, "argv", [])[:1] == ["-m"] and sys.path[0] == os.getcwd() != os.path.dirname(os.path.dirname(__file__)):
    del sys.path[0]

from importlib import import_module
from typing import TYPE_CHECKING

from holdfast.base.painters import painters_come_from

if TYPE_CHECKING:
    from holdfast.applications.carrying.carry import carry
    from holdfast.applications.carrying.profile import Profile
    from holdfast.applications.carrying.result import Carried
    from holdfast.applications.carrying.standards import standard_profiles
    from holdfast.applications.disassembly.build import BuildOrder, build_order
    from holdfast.applications.disassembly.order import Disassembly, disassembly_order
    from holdfast.applications.disassembly.question import can_remove
    from holdfast.applications.disassembly.removal import Removal
    from holdfast.applications.inertia import inertial_loads
    from holdfast.applications.placement.options import Weights
    from holdfast.applications.placement.place_all import place_all
    from holdfast.applications.placement.plan import plan_placement
    from holdfast.applications.placement.rating import Rating
    from holdfast.applications.placement.result import Placement
    from holdfast.applications.placement.several_result import PlacedObject, Placements
    from holdfast.applications.pushing.result import Effect, SafePushes
    from holdfast.applications.pushing.safe import safe_pushes
    from holdfast.applications.settled import Fall, Settled, settle
    from holdfast.applications.strap import Strap, tied
    from holdfast.applications.strap_files import load_straps
    from holdfast.applications.transport import (
        TransportLimits,
        horizontal_directions,
        safe_time_scale,
        tilted,
        transport_limits,
    )
    from holdfast.assembly.assembly import Assembly, assemble
    from holdfast.base.errors import (
        GeometryError,
        HoldfastError,
        HoldfastWarning,
        SceneError,
        SolverError,
        UnstableError,
    )
    from holdfast.batches.result import BatchReport, BatchTables, read_batch
    from holdfast.batches.run import batch
    from holdfast.batches.saved import load_answer
    from holdfast.contacts.interface import Interface, Patch
    from holdfast.engines.answers import Bound, Claim
    from holdfast.engines.compliant.engine import Compliant
    from holdfast.engines.graph.engine import Graph
    from holdfast.engines.imperfect import Imperfect
    from holdfast.engines.limit.engine import Limit
    from holdfast.engines.verdict import Status
    from holdfast.live.start import LiveView, view
    from holdfast.queries.constraint import Constraint, constraint
    from holdfast.queries.map import RobustnessMap, robustness_map
    from holdfast.queries.push import LoadFactor, Robustness, load_factor, robustness
    from holdfast.queries.request import Load
    from holdfast.queries.sensitivity import Sensitivity, sensitivity
    from holdfast.queries.sets import ConvexSet, admissible_wrenches, sustainable_accelerations
    from holdfast.queries.stability import Stability, stability
    from holdfast.queries.uncertainty import RobustnessUnder, robustness_under
    from holdfast.queries.worst_case import WorstCase, worst_case
    from holdfast.scene.body import Body
    from holdfast.scene.compound import Compound, Part
    from holdfast.scene.formats.mjcf.live import from_mujoco
    from holdfast.scene.formats.nodes import from_trimesh
    from holdfast.scene.formats.registry import load_scene, save_scene
    from holdfast.scene.friction import Friction
    from holdfast.scene.halfspace import HalfSpace
    from holdfast.scene.round import Capsule, Ellipsoid
    from holdfast.scene.scene import Scene
    from holdfast.scene.shapes import Box, Cylinder, Mesh, Sphere
    from holdfast.scene.shipped import shipped_scene, shipped_scenes

__version__ = "0.2.0.dev0"

_NAMES = {
    "holdfast.applications.carrying.carry": ("carry",),
    "holdfast.applications.carrying.profile": ("Profile",),
    "holdfast.applications.carrying.result": ("Carried",),
    "holdfast.applications.carrying.standards": ("standard_profiles",),
    "holdfast.applications.disassembly.build": ("BuildOrder", "build_order"),
    "holdfast.applications.disassembly.order": ("Disassembly", "disassembly_order"),
    "holdfast.applications.disassembly.question": ("can_remove",),
    "holdfast.applications.disassembly.removal": ("Removal",),
    "holdfast.applications.inertia": ("inertial_loads",),
    "holdfast.applications.placement.options": ("Weights",),
    "holdfast.applications.placement.place_all": ("place_all",),
    "holdfast.applications.placement.plan": ("plan_placement",),
    "holdfast.applications.placement.rating": ("Rating",),
    "holdfast.applications.placement.result": ("Placement",),
    "holdfast.applications.pushing.result": ("Effect", "SafePushes"),
    "holdfast.applications.pushing.safe": ("safe_pushes",),
    "holdfast.applications.placement.several_result": ("PlacedObject", "Placements"),
    "holdfast.applications.settled": ("Fall", "Settled", "settle"),
    "holdfast.applications.strap": ("Strap", "tied"),
    "holdfast.applications.strap_files": ("load_straps",),
    "holdfast.applications.transport": (
        "TransportLimits",
        "horizontal_directions",
        "safe_time_scale",
        "tilted",
        "transport_limits",
    ),
    "holdfast.assembly.assembly": ("Assembly", "assemble"),
    "holdfast.batches.result": ("BatchReport", "BatchTables", "read_batch"),
    "holdfast.batches.run": ("batch",),
    "holdfast.batches.saved": ("load_answer",),
    "holdfast.base.errors": (
        "GeometryError",
        "HoldfastError",
        "HoldfastWarning",
        "SceneError",
        "SolverError",
        "UnstableError",
    ),
    "holdfast.contacts.interface": ("Interface", "Patch"),
    "holdfast.engines.answers": ("Bound", "Claim"),
    "holdfast.engines.compliant.engine": ("Compliant",),
    "holdfast.engines.graph.engine": ("Graph",),
    "holdfast.engines.imperfect": ("Imperfect",),
    "holdfast.engines.limit.engine": ("Limit",),
    "holdfast.engines.verdict": ("Status",),
    "holdfast.live.start": ("LiveView", "view"),
    "holdfast.queries.constraint": ("Constraint", "constraint"),
    "holdfast.queries.map": ("RobustnessMap", "robustness_map"),
    "holdfast.queries.push": ("LoadFactor", "Robustness", "load_factor", "robustness"),
    "holdfast.queries.request": ("Load",),
    "holdfast.queries.sensitivity": ("Sensitivity", "sensitivity"),
    "holdfast.queries.sets": ("ConvexSet", "admissible_wrenches", "sustainable_accelerations"),
    "holdfast.queries.stability": ("Stability", "stability"),
    "holdfast.queries.uncertainty": ("RobustnessUnder", "robustness_under"),
    "holdfast.queries.worst_case": ("WorstCase", "worst_case"),
    "holdfast.scene.body": ("Body",),
    "holdfast.scene.formats.mjcf.live": ("from_mujoco",),
    "holdfast.scene.formats.nodes": ("from_trimesh",),
    "holdfast.scene.formats.registry": ("load_scene", "save_scene"),
    "holdfast.scene.friction": ("Friction",),
    "holdfast.scene.scene": ("Scene",),
    "holdfast.scene.compound": ("Compound", "Part"),
    "holdfast.scene.halfspace": ("HalfSpace",),
    "holdfast.scene.round": ("Capsule", "Ellipsoid"),
    "holdfast.scene.shapes": ("Box", "Cylinder", "Mesh", "Sphere"),
    "holdfast.scene.shipped": ("shipped_scene", "shipped_scenes"),
}
_HOMES = {name: module for module, names in _NAMES.items() for name in names}

__all__ = [
    "Assembly",
    "BatchReport",
    "BatchTables",
    "Body",
    "Bound",
    "Box",
    "BuildOrder",
    "Capsule",
    "Carried",
    "Claim",
    "Compliant",
    "Compound",
    "Constraint",
    "ConvexSet",
    "Cylinder",
    "Disassembly",
    "Effect",
    "Ellipsoid",
    "Fall",
    "Friction",
    "GeometryError",
    "Graph",
    "HalfSpace",
    "HoldfastError",
    "HoldfastWarning",
    "Imperfect",
    "Interface",
    "Limit",
    "LiveView",
    "Load",
    "LoadFactor",
    "Mesh",
    "Part",
    "Patch",
    "PlacedObject",
    "Placement",
    "Placements",
    "Profile",
    "Rating",
    "Removal",
    "Robustness",
    "RobustnessMap",
    "RobustnessUnder",
    "SafePushes",
    "Scene",
    "SceneError",
    "Sensitivity",
    "Settled",
    "SolverError",
    "Sphere",
    "Stability",
    "Status",
    "Strap",
    "TransportLimits",
    "UnstableError",
    "Weights",
    "WorstCase",
    "admissible_wrenches",
    "assemble",
    "batch",
    "build_order",
    "can_remove",
    "carry",
    "constraint",
    "disassembly_order",
    "from_mujoco",
    "from_trimesh",
    "horizontal_directions",
    "inertial_loads",
    "load_answer",
    "load_factor",
    "load_scene",
    "load_straps",
    "place_all",
    "plan_placement",
    "read_batch",
    "robustness",
    "robustness_map",
    "robustness_under",
    "safe_pushes",
    "safe_time_scale",
    "save_scene",
    "sensitivity",
    "settle",
    "shipped_scene",
    "shipped_scenes",
    "stability",
    "standard_profiles",
    "sustainable_accelerations",
    "tied",
    "tilted",
    "transport_limits",
    "view",
    "worst_case",
]


if not TYPE_CHECKING:  # type checkers read the imports above, and would let any name pass here

    def __getattr__(name: str) -> object:
        if name not in _HOMES:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        value = getattr(import_module(_HOMES[name]), name)
        globals()[name] = value
        return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})


def _painters() -> None:
    """Import what draws answers: heavy, so not before the first picture is wanted."""
    from holdfast.report import painters

    painters.register()


painters_come_from(_painters)
