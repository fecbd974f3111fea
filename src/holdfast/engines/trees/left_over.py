"""The bodies that trees leave open, such as a ball on a shelf, as an assembly of their own on those that stand."""

from __future__ import annotations

import numpy as np

from holdfast.assembly.assembly import FIXED, Assembly
from holdfast.base.arrays import Int
from holdfast.base.values import altered
from holdfast.engines.trees.forest import Forest


def left_over(forest: Forest) -> tuple[Assembly, Int] | None:
    """Return the bodies that are not ``forest.decided``, on decided ones that are fixed, and their numbers (K,).

    None unless all their contacts are bridges. Then equilibrium alone says what each of them carries, so that whether
    they rest does not depend on how soft those are that stand beneath them.
    """
    whole, open_ = forest.assembly, np.flatnonzero(~forest.decided)
    of_open = set(open_.tolist())
    contacts = [k for k, ends in enumerate(whole.ends) if not of_open.isdisjoint(ends)]
    if whole.scene.holds or not set(forest.cuts.interfaces.tolist()).issuperset(contacts):
        return None
    names = {whole.movable[k].name for k in of_open}
    touched = {name for k in contacts for name in whole.interfaces[k].bodies}
    bodies = tuple(
        body if body.fixed or body.name in names else altered(body, fixed=True)
        for body in whole.bodies
        if body.name in touched
    )
    fixed = {k for k in range(FIXED, len(whole.movable)) if k not in of_open}
    interfaces = tuple(
        whole.interfaces[k].flipped() if whole.ends[k][1] in fixed else whole.interfaces[k] for k in contacts
    )
    scene = altered(whole.scene, bodies=bodies, excluded=())
    part = Assembly(scene, interfaces, whole.tolerances, detected=False, absent=whole.known_names)
    part.__dict__["axes"] = whole.axes
    return part, open_
