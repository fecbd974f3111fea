"""How load paths of bodies that regularisation springs hold begin: resisted by contacts, or by these springs alone.

A body at rest may just touch others without any force, and be free to roll along them. There the law has a kink, and in
which direction a path begins is decided by rounding. Under a small load it has left the kink: the body rests against
those that resist, or in its hold.
"""

from __future__ import annotations

import numpy as np

from holdfast.base.arrays import Float
from holdfast.elastic.outcome import PathOutcome, RestOutcome
from holdfast.elastic.step_control import SPRING_SHARE
from holdfast.elastic.stepper import by_springs
from holdfast.elastic.system import Settled, System
from holdfast.engines.compliant.grid import Grid

TENTH = 0.1  # share of the load at which a path ended, where the springs show whether contacts resist at all
CLEARLY = 0.5  # share of what ends a path, above which springs have carried the load from the beginning
SMALL = 1e-3  # a load, relative to the weight of the loaded body, that leaves the kink and changes nothing else
PATIENCE = 200  # largest number of Newton steps in the search for rest under such a load


def gives_way(grid: Grid, load: Float, force: float) -> bool:
    """Tell whether regularisation springs alone keep a body from being moved by any share of ``force`` times ``load``.

    The load (6J,) is in units of the model. Its path ended at that force, where the hold carried SPRING_SHARE of a
    weight. Where contacts resist, the hold carries next to nothing of a tenth of it; where they do not, it carries a
    tenth as much from the beginning, however little that is of the force: of a press on a box beside the edge that it
    is balanced on, contacts carry all but the moment about the edge.
    """
    system, end = _under(grid, TENTH * force * load)
    more = by_springs(system.model, end.q) - by_springs(system.model, grid.settled.q)
    return end.outcome is RestOutcome.RESTS and more > CLEARLY * TENTH * SPRING_SHARE


def path_from(grid: Grid, load: Float, start: float) -> tuple[float, Float]:
    """Return the peak of the path of a ``load`` (6J,) that begins under ``start`` times it, and its last motion (6J,).

    Loads and motion are in units of the model. The peak is inf where the path has no end, and 0 where there is no rest
    under that load or the path is lost.
    """
    system, end = _under(grid, start * load)
    if end.outcome is not RestOutcome.RESTS:
        return 0.0, np.zeros(len(load))
    found = system.paths(end.q, load[None])
    peak = 0.0 if found.outcome[0] == PathOutcome.LOST else start + float(found.peak[0])
    return peak, np.asarray(found.motion[0])


def _under(grid: Grid, load: Float) -> tuple[System, Settled]:
    system = grid.system.under(grid.system.model.wrench + load)
    return system, system.come_to_rest(near=np.asarray(grid.settled.q), most=PATIENCE)
