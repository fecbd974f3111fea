"""What a carton may bear, from its board, the climate and the time for which it is stacked."""

from __future__ import annotations

import numpy as np

from holdfast.base.arrays import checked_number
from holdfast.base.ranges import LENGTH, Range

MCKEE = 5.87  # for regular slotted cartons; dimensionless
# What is left at most of the strength of a carton of 50 % relative humidity, and after days under load.
HUMIDITY = ((0.5, 0.6, 0.7, 0.8, 0.9), (1.0, 0.9, 0.8, 0.68, 0.48))
DAYS = ((0.0, 10.0, 30.0, 90.0, 180.0), (1.0, 0.63, 0.6, 0.55, 0.5))


def box_compression_strength(
    edge_crush: float, caliper: float, perimeter: float, *, humidity: float = 0.5, days: float = 0.0
) -> float:
    """Return the force [N] on its top that crushes a regular slotted carton; a ``top_load`` is less by a safety factor.

    McKee's formula, 5.87 ECT √(h Z), takes the edge crush strength ECT of the board, ``edge_crush`` [N/m], its
    ``caliper`` h [m] and the ``perimeter`` Z [m] of the carton (McKee, Gander and Wachuta, Paperboard Packaging 48(8),
    1963). The strength is then multiplied by what the Fibre Box Handbook (Fibre Box Association) leaves of it at a
    relative ``humidity`` from 0 to 0.9 and after up to 180 ``days`` under load, each by the next worse entry of its
    table. Raises HoldfastError for numbers out of range.
    """
    where = "box_compression_strength"
    edge = checked_number(edge_crush, f"{where}: edge_crush", above=0)
    h, z = (
        checked_number(value, f"{where}: {name}", above=0, within=LENGTH)
        for name, value in (("caliper", caliper), ("perimeter", perimeter))
    )
    damp = checked_number(
        humidity, f"{where}: humidity", minimum=0, within=Range(0.0, HUMIDITY[0][-1], "of saturation")
    )
    stood = checked_number(days, f"{where}: days", minimum=0, within=Range(0.0, DAYS[0][-1], "days"))
    left = [table[1][int(np.searchsorted(table[0], at))] for table, at in ((HUMIDITY, damp), (DAYS, stood))]
    return float(MCKEE * edge * np.sqrt(h * z) * left[0] * left[1])
