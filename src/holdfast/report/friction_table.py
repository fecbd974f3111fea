"""Show friction from measured pushes as tables for the terminal."""

from __future__ import annotations

from rich.box import SIMPLE_HEAD
from rich.console import Group, RenderableType
from rich.table import Table

from holdfast.applications.calibration.measured_friction import MeasuredFriction
from holdfast.base.public import number
from holdfast.report.texts import cell, sentence


def friction_report(result: MeasuredFriction) -> RenderableType:
    """Return a table of coefficients by pair, with what is not known and the pushes that fit worst."""
    told = result.summary()
    table = Table(title="friction", title_justify="left", box=SIMPLE_HEAD)
    for heading in told.heads:
        table.add_column(cell(heading))
    for row in told.rows:
        table.add_row(*map(cell, row))
    lines = [
        told.headline,
        *(f"{name}: {text}" for name, text in told.facts),
        *(f"note: {note}" for note in told.notes),
    ]
    return Group(*map(sentence, lines), *([table] if told.rows else []), _pushes(result))


def _pushes(result: MeasuredFriction) -> RenderableType:
    """Return the pushes whose forces are furthest from what is predicted with the most likely coefficients."""
    table = Table(title="the pushes that fit worst", title_justify="left", box=SIMPLE_HEAD)
    for heading in ("push", "body", "measured", "predicted", "ratio"):
        table.add_column(cell(heading), justify="left" if heading == "body" else "right")
    for k in result.worst:
        ratio = number(float(result.force[k] / result.predicted[k])) if result.predicted[k] > 0 else "?"
        measured = number(float(result.force[k]), "N") + ("" if result.moved[k] else ", held")
        predicted = number(float(result.predicted[k]), "N") if result.predicted[k] > 0 else "?"
        table.add_row(*map(cell, (str(k), result.bodies[k], measured, predicted, ratio)))
    return table
