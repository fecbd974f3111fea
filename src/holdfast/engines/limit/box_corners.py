"""The worst case over a box of masses and centres of mass, which is at one of the corners of the box.

R is the largest value of a cone program, and therefore concave in the wrench of the weights w_g. This wrench is affine
in each mass and in each centre of mass while the others are held. A concave function on an interval is smallest at an
end of the interval. Applied to one value after another, this shows that R is smallest at a corner of the box.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from typing import Literal

import numpy as np

from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import Float
from holdfast.base.errors import HoldfastError, message
from holdfast.base.progress import reported
from holdfast.engines.answers import Answers, joined
from holdfast.engines.contract import Corner, State, Weakest
from holdfast.engines.verdict import Status

MAX_CORNERS = 4096  # largest number of corners, that of twelve uncertain values; each corner takes a program of its own

GUARANTEE = (
    "exact for engine limit: R grows with every friction coefficient, is concave in the weights' wrench, and that is "
    "affine in each mass and in each centre of mass, so a corner of the box is weakest"
)

_WEAKEST_FIRST = (Status.UNSTABLE, Status.UNDECIDED, Status.FINITE, Status.INFINITE)
_CERTAIN = 0.5  # the place of a force 0 that is known among these: nothing can be weaker, except what does not stand


def weakest(
    assembly: Assembly, prepare: Callable[[Float], State], standing: Float, W: Float, corners: tuple[Corner, ...]
) -> Weakest:
    """Find the smallest value of the largest factor of each column of W (6J, n) over all ``corners``.

    ``prepare`` prepares the engine under a wrench (6J,) that acts in addition to the nominal weights. ``standing``
    (6J,) is the part of this wrench that is the same at every corner.
    """
    found = (prepare(standing + change_at(assembly, c)).load_factor(W) for c in reported("worst case", corners))
    answers, corner = least_of(found, "force")
    return Weakest(answers=answers, corner=corner, corners=corners, guarantee=GUARANTEE)


def least_of(tables: Iterable[Answers], by: Literal["force", "lower"]) -> tuple[Answers, tuple[int, ...]]:
    """Return the weakest of the answers to the same n loads in several tables, and the number of its table (n,) each.

    They are ranked ``by`` a column, after what does not stand and what is undecided. ``lower`` and ``upper`` are the
    least of all tables.
    """
    worst: dict[int, tuple[float, float, int]] = {}
    rows: dict[int, Answers] = {}
    lower, upper = np.array(np.inf), np.array(np.inf)
    for number, found in enumerate(tables):
        lower, upper = np.minimum(lower, found.lower), np.minimum(upper, found.upper)
        for k in range(len(found)):
            here = (_weakness(found, k), float(getattr(found, by)[k]), number)
            if k not in worst or here < worst[k]:
                worst[k], rows[k] = here, found.rows(slice(k, k + 1))
    answers = joined([rows[k] for k in range(len(rows))])
    force = np.minimum(answers.force, upper)  # another corner may have the least one
    return replace(answers, force=force, lower=lower, upper=upper), tuple(worst[k][2] for k in range(len(rows)))


def _weakness(found: Answers, k: int) -> float:
    """Return the place of row ``k`` among the answers of all corners: the first of them is that of the worst case.

    An undecided corner may be weaker than every finite one, so the worst case is then undecided, too.
    """
    if found.status[k] is Status.FINITE and not found.force[k] > 0:
        return _CERTAIN
    return _WEAKEST_FIRST.index(found.status[k])


def corners_of(
    assembly: Assembly, masses: Mapping[str, tuple[float, float]], coms: Mapping[str, Float], where: str
) -> tuple[Corner, ...]:
    """Return all corners of a box of masses and centres of mass, both keyed by body name.

    ``masses`` are intervals (low, high) [kg], and ``coms`` are half widths (3,) [m] along the world axes around the
    nominal centres of mass. ``where`` names the query in error messages. More than MAX_CORNERS raise HoldfastError.
    """
    gravity = assembly.scene.gravity
    matters = [k for k in range(3) if np.linalg.norm(np.delete(gravity, k)) > 0]  # weight may slide along itself
    values: list[tuple[str, int, tuple[float, ...]]] = [
        (name, -1, tuple(dict.fromkeys(interval))) for name, interval in masses.items()
    ]
    values += [(name, k, (-half[k], half[k])) for name, half in coms.items() for k in matters if half[k] > 0]
    count = int(np.prod([len(choices) for _, _, choices in values], dtype=object))
    if count > MAX_CORNERS:
        problem = f"{len(values)} uncertain values have {count:,} corners"
        raise HoldfastError(message(where, problem, f"at most {MAX_CORNERS:,}: name the bodies that matter"))
    corners = []
    for chosen in itertools.product(*(choices for _, _, choices in values)):
        weights: dict[str, float] = {}
        centres = {name: assembly.com[assembly.index[name]].tolist() for name in coms}
        for (name, axis, _), value in zip(values, chosen, strict=True):
            if axis < 0:
                weights[name] = value
            else:
                centres[name][axis] += value
        corners.append(Corner(weights, {name: (c[0], c[1], c[2]) for name, c in centres.items()}))
    return tuple(corners)


def change_at(assembly: Assembly, corner: Corner) -> Float:
    """Return the change (6J,) of the wrench of the weights at a corner, about the nominal centres of mass."""
    change = np.zeros((len(assembly.movable), 6))
    for name in {**corner.masses, **corner.coms}:
        k = assembly.index[name]
        pull = corner.masses.get(name, float(assembly.mass[k])) * assembly.scene.gravity
        change[k, :3] = pull - assembly.mass[k] * assembly.scene.gravity
        change[k, 3:] = np.cross(np.array(corner.coms.get(name, assembly.com[k])) - assembly.com[k], pull)
    return change.ravel()
