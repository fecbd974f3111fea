"""Register the functions that draw each class of answers in ``base.painters``.

The methods ``save_png``, ``save_html``, ``save_glb`` and ``save_ply`` of an answer find them there.
"""

from __future__ import annotations

import os
from collections.abc import Sequence

from holdfast.applications.carrying.result import Carried
from holdfast.applications.disassembly.order import Disassembly
from holdfast.applications.firmer.result import Firmer
from holdfast.applications.placement.result import Placement
from holdfast.applications.placement.several_result import Placements
from holdfast.applications.resting_poses import RestingPoses
from holdfast.applications.settled import Settled
from holdfast.applications.transport import TransportLimits
from holdfast.base.arrays import checked_items
from holdfast.base.errors import HoldfastError, message
from holdfast.base.painters import register_glimpse, register_painter
from holdfast.base.text import quoted
from holdfast.queries.map import RobustnessMap
from holdfast.report.carried_plot import save_carried_png
from holdfast.report.disassembly import save_strip
from holdfast.report.firmer import save_firmer_png
from holdfast.report.map_picture import save_glb, save_html, save_ply, save_png
from holdfast.report.notebook import glimpse
from holdfast.report.placement import save_placement_png
from holdfast.report.placements import save_placements_png
from holdfast.report.resting import save_resting_png
from holdfast.report.settled_picture import save_settled_png
from holdfast.report.transport_plot import save_polar


def register() -> None:
    """Register the painters of all answers that can be drawn."""
    register_painter(RobustnessMap, ".png", save_png)
    register_painter(RobustnessMap, ".html", save_html)
    register_painter(RobustnessMap, ".glb", save_glb)
    register_painter(RobustnessMap, ".ply", save_ply)
    register_painter(TransportLimits, ".png", _polar)
    register_painter(Carried, ".png", save_carried_png)
    register_painter(Disassembly, ".png", save_strip)
    register_painter(Placement, ".png", save_placement_png)
    register_painter(Placements, ".png", save_placements_png)
    register_painter(Firmer, ".png", save_firmer_png)
    register_painter(RestingPoses, ".png", save_resting_png)
    register_painter(Settled, ".png", save_settled_png)
    register_glimpse(glimpse)


def _polar(
    result: TransportLimits,
    path: str | os.PathLike[str],
    *,
    others: Sequence[TransportLimits] = (),
    names: Sequence[str] | None = None,
) -> None:
    more = checked_items(others, "polar plot: others", "TransportLimits")
    for other in more:
        if not isinstance(other, TransportLimits):
            raise HoldfastError(message("polar plot: others", f"hold {quoted(other)}", "needs TransportLimits"))
    save_polar([result, *more], path, names)
