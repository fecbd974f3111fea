"""Show a verdict as a table for the terminal."""

from __future__ import annotations

import numpy as np
from rich.box import SIMPLE_HEAD
from rich.console import Group, RenderableType
from rich.table import Table

from holdfast.assembly.assembly import Assembly
from holdfast.assembly.strengths import strengths_of
from holdfast.base.arrays import Bool, Float
from holdfast.base.public import MOST_ROWS
from holdfast.base.text import LONGEST_NAME, one_line
from holdfast.engines.verdict import Status
from holdfast.queries.stability import Stability
from holdfast.report.texts import STYLES, WORDS, cell, headline, sentence


def stability_report(assembly: Assembly, result: Stability) -> RenderableType:
    """Return a table with the verdict, its reason and the contacts."""
    word, style = WORDS[result.status], STYLES[result.status]
    if result.crushed:
        word, style = f"{word}, but {len(result.crushed)} crushed", STYLES[Status.UNSTABLE]
    name = assembly.scene.name or "scene"
    head = headline(name, (word, style), f"  (engine {result.engine}: {result.claim.words})")
    lines: list[RenderableType] = [head, sentence(result.reason, "dim")]
    lines += [
        sentence(f"crushed: {one.text}", "red") if one.crushed else sentence(f"bearing: {one.text}", "dim")
        for one in result.bearing[:MOST_ROWS]
    ]
    lines += [sentence(f"note: {note}", "yellow") for note in result.notes]
    lines.append(_contacts(assembly, result))
    return Group(*lines)


def _contacts(assembly: Assembly, result: Stability) -> Table:
    movable, interfaces = len(assembly.movable), len(assembly.interfaces)
    table = Table(
        title=f"{movable} movable bodies, {interfaces} interfaces ({assembly.tolerances.text})",
        title_justify="left",
        box=SIMPLE_HEAD,
    )
    for heading in ("between", "area [cm²]", "μ", "normal force [N]", "friction used"):  # as a share of its limit
        table.add_column(cell(heading), justify="left" if heading == "between" else "right")
    shown, strengths = range(min(interfaces, 40)), strengths_of(assembly)
    for k in shown:
        interface = assembly.interfaces[k]
        force, usage = "-", "-"
        if result.forces is not None:
            here = result.forces.interface == k
            pressing = (result.forces.force[here] * result.forces.normal[here]).sum()
            tangential = np.linalg.norm(result.forces.force[here].sum(0) - _along(result, here))
            force = f"{pressing:.3g}"
            limit = assembly.mu[k] * (pressing + strengths[k].tension * interface.area)
            usage = f"{tangential / limit:.0%}" if limit > 1e-9 * assembly.weight else "-"
        a, b = (one_line(name, LONGEST_NAME) for name in interface.bodies)
        said = interface.flags if interface.certain else (*interface.flags, "may not exist")
        flags = f" ({', '.join(said)})" if said else ""
        table.add_row(cell(f"{a} - {b}{flags}"), f"{interface.area * 1e4:.4g}", f"{assembly.mu[k]:g}", force, usage)
    if interfaces > len(shown):
        table.add_row(f"... and {interfaces - len(shown)} more", "", "", "", "")
    return table


def _along(result: Stability, here: Bool) -> Float:
    assert result.forces is not None
    force, normal = result.forces.force[here], result.forces.normal[here]
    return np.asarray(((force * normal).sum(1, keepdims=True) * normal).sum(0))
