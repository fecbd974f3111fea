"""The elastic model of an assembly on the places of its contacts, in the units of ``elastic/model.py``.

Displacements and loads are along the assembly's own axes and rounded as the places are (places.py).

The stiffness of contacts per area is one number for all of them, or one for each pair of bodies or of materials.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from holdfast.assembly.assembly import Assembly
from holdfast.assembly.strengths import refuse_joined
from holdfast.base.arrays import Float, checked_number
from holdfast.base.ranges import STIFFNESS
from holdfast.base.rigid import snapped
from holdfast.elastic.model import Elastic, Runs
from holdfast.engines.compliant.places import Places
from holdfast.engines.imperfect import RandomFaces
from holdfast.native import core
from holdfast.scene.friction import check_known, checked_pairs, number_between

Stiffness: TypeAlias = float | Mapping[tuple[str, str], float] | None

WHAT = "Compliant: stiffness"  # in error messages


def checked_stiffness(stiffness: Stiffness) -> Stiffness:
    """Return ``stiffness``, a mapping as a read-only table; raise SceneError if it makes no sense in any scene."""
    if isinstance(stiffness, Mapping):
        return checked_pairs(stiffness, WHAT, WHAT, above=0, within=STIFFNESS)
    return None if stiffness is None else checked_number(stiffness, WHAT, above=0, within=STIFFNESS)


def check_stiffness(assembly: Assembly, stiffness: Stiffness) -> None:
    """Raise SceneError if ``stiffness`` names something that is neither a body nor a material.

    What counts are the names of the whole: if ``assembly`` is a part of a larger one, the names in ``absent`` are
    known, too. Bodies need not touch.
    """
    if isinstance(stiffness, Mapping):
        known = {*assembly.absent, *assembly.scene.names}
        check_known(stiffness, known, WHAT)


def stiffness_of(assembly: Assembly, stiffness: Stiffness) -> Float:
    """Return the stiffness per area (interfaces,), relative to that of interfaces that are not named."""
    if not isinstance(stiffness, Mapping):
        return np.ones(len(assembly.interfaces))
    materials = assembly.scene.materials
    found = [number_between(stiffness, *interface.bodies, materials) for interface in assembly.interfaces]
    return np.array([1.0 if value is None else value for value in found])


ROUGHEST = 1e3  # flatness, in compressions under the weight, beyond which bodies rest on three nodes of a patch anyway


@dataclass(frozen=True, eq=False)
class Springs:
    """The springs of the contacts and the number of their nodes.

    ``nodes`` is the number of nodes along each side of a square patch, ``ratio`` the tangential over the normal
    stiffness, and ``stiffness`` [N/m³] the normal stiffness per area, given as to engine ``Compliant``. ``faces`` are
    the faces where they are not ideal.
    """

    nodes: int
    ratio: float = 1.0
    stiffness: Stiffness = None
    faces: RandomFaces | None = None

    def finer(self, times: int) -> Springs:
        """Return the same springs with ``times`` as many nodes along each side."""
        return replace(self, nodes=times * self.nodes)

    def model(self, places: Places, wrench: Float) -> Elastic:
        """Return the elastic model of an assembly on these ``places`` under ``wrench`` (6J,) [N, N m].

        If there are ``faces``, clearances are at most ROUGHEST times the compression that the weight would cause on all
        contacts together.
        """
        assembly, sheets = places.assembly, places.sheets
        stiffness = stiffness_of(assembly, self.stiffness)
        if self.faces is None:
            return elastic_model(places, wrench, self.ratio, stiffness)
        refuse_joined(assembly, "imperfect faces", "leave out tension and cohesion, or imperfect=")
        stiffness = stiffness * self.faces.stiffness(assembly)
        total = float(stiffness[sheets.owner] @ sheets.weights)
        most = ROUGHEST * force_unit(assembly, wrench) / max(total, 1e-300)
        softened = min(1.0, most / max(self.faces.imperfect.flatness, 1e-300))
        apart = softened * self.faces.clearances(assembly, self.nodes**2)
        return elastic_model(places, wrench, self.ratio, stiffness, apart)


def force_unit(assembly: Assembly, wrench: Float) -> float:
    """Return the unit of force [N]: the total weight or, for a weightless assembly, the largest entry of ``wrench``."""
    return assembly.weight or float(np.abs(wrench).max(initial=0.0)) or 1.0


def own_rows(assembly: Assembly, rows: Float) -> Float:
    """Convert rows (k, 6J) of forces and torques [N, N m] to the model's axes and units of length, rounded."""
    own = ((rows * assembly.levers).reshape(-1, 3) @ assembly.axes.T).reshape(-1, len(assembly.movable), 6)
    return snapped(own, np.abs(own).max(2, keepdims=True), core.BITS).reshape(rows.shape)


def world_rows(assembly: Assembly, rows: Float) -> Float:
    """Convert rows (k, 6J) of displacements or motions in the model's axes and units of length to the world's."""
    return (rows.reshape(-1, 3) @ assembly.axes).reshape(rows.shape) * assembly.levers


def motion_row(assembly: Assembly, twists: Float) -> Float:
    """Convert the twists (J, 6) of a motion to a row (6J,) in the model's axes and units of length."""
    return (twists.reshape(-1, 3) @ assembly.axes.T).ravel() / assembly.levers


def elastic_model(
    places: Places, wrench: Float, ratio: float = 1.0, stiffness: Float | None = None, apart: Float | None = None
) -> Elastic:
    """Return the elastic model of an assembly on these ``places`` under ``wrench`` (6J,) [N, N m].

    The stiffness of a node is the ``stiffness`` per area (interfaces,) [N/m³] of its interface, 1 unless given, times
    the node's tributary area. ``apart`` (I,) [m] is the clearance of each node, 0 unless given. A node with tension
    presses from the outset as much as it can be pulled, against that pull, and stays elastic until it is pulled so.
    """
    assembly, sheets = places.assembly, places.sheets
    k = sheets.weights if stiffness is None else sheets.weights * stiffness[sheets.owner]
    total = max(float(k.sum()), 1e-300)
    k = k / total
    clear = np.zeros(len(k))
    if apart is not None:
        clear = apart * (total / force_unit(assembly, wrench))
    if sheets.pull.any():
        clear = clear - sheets.pull / (force_unit(assembly, wrench) * k)
    if clear.any():
        clear = snapped(clear, np.abs(clear).max(initial=0.0), core.BITS)
    scale = assembly.equation_scale / assembly.levers
    model = Elastic(
        sheets.first,
        sheets.x,
        sheets.y,
        snapped(k, k, core.BITS),
        clear,
        sheets.mu,
        float(ratio),
        sheets.a,
        sheets.b,
        sheets.axes,
        sheets.arm_a,
        sheets.arm_b,
        own_rows(assembly, wrench[None] / force_unit(assembly, wrench))[0],
        snapped(scale, scale, core.BITS),
        np.zeros((len(sheets.a), 6, 6)),
        np.ones(6 * len(assembly.movable)),
        Runs.of(sheets.first, sheets.x, sheets.y, clear),
        np.zeros(6 * len(assembly.movable)),
        np.zeros(6 * len(assembly.movable)),
    )
    core.bond(model, model.bonded, model.still)
    core.set_units(model, model.unit)
    if sheets.pull.any():
        # what nodes press at no displacement, which is their pull, to the last digit
        ends = model.first[:-1]
        fn, g1, g2 = (
            np.add.reduceat(each * model.k * model.apart, ends) for each in (np.ones_like(model.x), model.y, -model.x)
        )
        wrenches = np.zeros((len(model.a), 6))
        wrenches[:, 0], wrenches[:, 4], wrenches[:, 5] = fn, g1, g2
        core.add_wrenches(model, wrenches, model.wrench)
    return model
