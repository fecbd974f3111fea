"""How load paths of bodies that regularisation springs hold begin.

A body at rest may just touch others without any force, and be free to roll along them. There the law has a kink, and in
which direction a path begins is decided by rounding. Under a small load it has left the kink: the body rests against
those that resist, or in its hold.
"""

from __future__ import annotations

import numpy as np

from holdfast.base.arrays import Float
from holdfast.elastic.outcome import PathOutcome, RestOutcome
from holdfast.engines.compliant.grid import Grid

SMALL = 1e-3  # a load, relative to the weight of the loaded body, that leaves the kink and changes nothing else
PATIENCE = 200  # largest number of Newton steps in the search for rest under such a load


def path_from(grid: Grid, load: Float, start: float) -> tuple[float, Float]:
    """Return the peak of the path of a ``load`` (6J,) that begins under ``start`` times it, and its last motion (6J,).

    Loads and motion are in units of the model. The peak is inf where the path has no end, and 0 where there is no rest
    under that load or the path is lost.
    """
    system = grid.system.under(grid.system.model.wrench + start * load)
    end = system.come_to_rest(near=np.asarray(grid.settled.q), most=PATIENCE)
    if end.outcome is not RestOutcome.RESTS:
        return 0.0, np.zeros(len(load))
    found = system.paths(end.q, load[None])
    peak = 0.0 if found.outcome[0] == PathOutcome.LOST else start + float(found.peak[0])
    return peak, np.asarray(found.motion[0])
