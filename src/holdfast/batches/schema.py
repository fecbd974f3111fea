"""The columns of the tables of a batch: the source of the Parquet schema, of schema.json and of the docs."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal, NamedTuple

VERSION = "holdfast-batch/1"

Kind = Literal["text", "texts", "number", "whole", "flag"]
Row = dict[str, Any]  # one value for each column of a table, plain data
Tables = dict[str, list[Row]]  # rows by the name of their table


class Column(NamedTuple):
    """A column: its name, the kind of its values, their unit ("" if none) and its meaning.

    Values may be missing (null) in every column. ``reproducible`` is False where two runs of one scene may differ.
    """

    name: str
    kind: Kind
    unit: str
    meaning: str
    reproducible: bool = True


_WHERE = (
    Column("number", "whole", "", "place of the scene among the inputs, from 0"),
    Column("scene", "text", "", "name of the scene: its path as it was given, or the name it was given"),
)
_PLACE = (
    Column("x", "number", "m", "where the push acts, in the world"),
    Column("y", "number", "m", ""),
    Column("z", "number", "m", ""),
    Column("dx", "number", "", "unit direction of the push, in the world"),
    Column("dy", "number", "", ""),
    Column("dz", "number", "", ""),
)


def _answered(name: str, unit: str, what: str) -> tuple[Column, ...]:
    """Return the columns of answers: the amount, its bounds, its status and what gives way."""
    return (
        Column(name, "number", unit, f"the largest {what} before anything moves; inf if none moves anything"),
        Column("lower", "number", unit, "lower bound of the true answer, as far as the engine promises one"),
        Column("upper", "number", unit, "upper bound of the true answer, as far as the engine promises one"),
        Column("status", "text", "", "finite, infinite, unstable or undecided: if undecided, 0 is no answer"),
        Column("mode", "text", "", "slip, topple, mixed, roll, crush or none"),
        Column("moving", "texts", "", "names of the bodies that begin to move"),
    )


SCENES = (
    *_WHERE,
    Column("path", "text", "", "path of the scene file; null for a scene that was given as a value"),
    Column("key", "text", "", "SHA-256 of the scene with all its files, the question, its options and the version"),
    Column("files", "texts", "", "the files that were read, relative to the folder of the scene file"),
    Column("outcome", "text", "", "answered, error, time, memory or crash"),
    Column("problem", "text", "", "what went wrong, if the outcome is not answered"),
    Column("status", "text", "", "stable, unstable or undecided; null if it was not asked or not answered"),
    Column("reason", "text", "", "the reason for the verdict, in words"),
    Column("equilibrium_exists", "flag", "", "true or false with evidence; null if it is not known"),
    Column("moving", "texts", "", "names of the bodies that move in a scene that does not stand"),
    Column("crushed", "texts", "", "names of the bodies that bear more than they may, the most crushed first"),
    Column("engine", "text", "", "the engine of the verdict"),
    Column("bodies", "whole", "", "number of movable bodies"),
    Column("fixed", "whole", "", "number of fixed bodies"),
    Column("interfaces", "whole", "", "number of contact interfaces"),
    Column("groups", "whole", "", "number of groups of movable bodies that touch each other"),
    Column("overlaps", "whole", "", "number of pairs of bodies that overlap"),
    Column("mass", "number", "kg", "total mass of the movable bodies"),
    Column("weakest", "number", "N", "the smallest decided force of all pushes and map points; null without one"),
    Column("weakest_lower", "number", "N", "the smallest lower bound of all pushes and map points"),
    Column("weakest_body", "text", "", "the body at which the smallest decided force acts"),
    Column("weakest_mode", "text", "", "what the contacts do then: slip, topple ..."),
    Column("weakest_moving", "texts", "", "names of the bodies that move then, not always the pushed one"),
    Column("undecided", "whole", "", "number of pushes, map points and accelerations without an answer"),
    Column("acceleration", "number", "m/s²", "the smallest decided acceleration of the carrier; null without one"),
    Column("acceleration_lower", "number", "m/s²", "the smallest lower bound of the accelerations"),
    Column("notes", "texts", "", "simplifications on which the verdict depends"),
    Column("warnings", "texts", "", "warnings of holdfast"),
    Column("seconds", "number", "s", "time that the scene took in its process", reproducible=False),
    Column("peak_mb", "number", "MB", "largest resident memory of its process meanwhile", reproducible=False),
)
BODIES = (
    *_WHERE,
    Column("body", "text", "", "name of the body"),
    Column("fixed", "flag", "", "whether the body never moves"),
    Column("mass", "number", "kg", "mass; null for a fixed body without one"),
    Column("x", "number", "m", "position of the body's frame in the world"),
    Column("y", "number", "m", ""),
    Column("z", "number", "m", ""),
    Column("qx", "number", "", "rotation from the body's frame to the world, as a unit quaternion with qw >= 0"),
    Column("qy", "number", "", ""),
    Column("qz", "number", "", ""),
    Column("qw", "number", "", ""),
    Column("group", "whole", "", "number of its group of bodies that touch each other; null for a fixed body"),
    Column("status", "text", "", "verdict on its group; null if it was not asked"),
    Column("bearing", "number", "", "what it bears over what it may bear, above 1: crushed; null without a limit"),
    Column("weakest", "number", "N", "the smallest decided force of all pushes and map points on it"),
)
INTERFACES = (
    *_WHERE,
    Column("a", "text", "", "first body"),
    Column("b", "text", "", "second body, into which the normals point"),
    Column("status", "text", "", "touching or penetrating"),
    Column("certain", "flag", "", "false if the two bodies may not touch at all"),
    Column("flags", "texts", "", "how the contact depends on a tolerance, a pose or a mesh"),
    Column("mu", "number", "", "coefficient of friction"),
    Column("patches", "whole", "", "number of contact patches"),
    Column("area", "number", "m²", "total area of the patches"),
    Column("separation", "number", "m", "smallest distance at a patch, negative where bodies overlap"),
    Column("normal_force", "number", "N", "sum of the normal forces at rest; null unless the scene stands"),
    Column("usage", "number", "", "largest share of the friction limit that a node uses at rest"),
)
PUSHES = (
    *_WHERE,
    Column("source", "text", "", "map, or push for one that was asked by name"),
    Column("body", "text", "", "name of the body that is pushed"),
    *_PLACE,
    *_answered("force", "N", "push"),
)
TRANSPORTS = (
    *_WHERE,
    Column("dx", "number", "", "unit direction in which the carrier accelerates, in the axes of the scene"),
    Column("dy", "number", "", ""),
    Column("dz", "number", "", ""),
    *_answered("acceleration", "m/s²", "acceleration of the carrier"),
)
TABLES: Mapping[str, tuple[Column, ...]] = {
    "scenes": SCENES,
    "bodies": BODIES,
    "interfaces": INTERFACES,
    "pushes": PUSHES,
    "transports": TRANSPORTS,
}


def described() -> dict[str, Any]:
    """Return the schema as plain data, the content of schema.json."""
    return {
        "format": VERSION,
        "tables": {name: [column._asdict() for column in columns] for name, columns in TABLES.items()},
    }
