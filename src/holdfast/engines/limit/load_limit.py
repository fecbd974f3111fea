"""The largest factor of one load, with the evidence that proves it."""

from __future__ import annotations

from dataclasses import dataclass

from holdfast.base.arrays import Float
from holdfast.engines.verdict import Status


@dataclass(frozen=True, eq=False)
class LoadLimit:
    """The largest ``factor`` of one load, with its bounds ``lower`` and ``upper``, its ``status`` and the evidence.

    Finite: the dual ``twists`` (6J,) of the movable bodies, scaled so that the load does work at unit power, and
    ``proof`` (6J,), the same motion mended (repair.py) so that it proves ``upper`` and a cutting plane for all other
    loads. Where it cannot be mended, ``proof`` is None and ``upper`` infinite. Infinite: the ``ray`` (I, 3) [N], world
    axes: forces on each node's second body that balance the load alone, so that any multiple of it is carried.
    ``certain`` says whether ``lower`` is proved. ``slope`` (6J,): where the ray is proved with room to spare, any
    multiple of the load and of a wrench w with the sum of slope |w| <= 1 is carried together.
    """

    factor: float
    lower: float
    upper: float
    status: Status
    twists: Float | None
    proof: Float | None = None
    ray: Float | None = None
    certain: bool = False
    slope: Float | None = None
