"""Read saved answers from files. This module imports all classes of answers, so that every file can be read."""

from __future__ import annotations

import os
from typing import Any

from holdfast.applications.calibration.measured_friction import MeasuredFriction
from holdfast.applications.carrying.carry import Carried
from holdfast.applications.disassembly.build import BuildOrder
from holdfast.applications.disassembly.order import Disassembly
from holdfast.applications.disassembly.removal import Removal
from holdfast.applications.gradients.differentiate import Derivatives
from holdfast.applications.monitor import Monitored
from holdfast.applications.placement.result import Placement, Placements
from holdfast.applications.pushing.firmer import Firmer
from holdfast.applications.pushing.safe_pushes import SafePushes
from holdfast.applications.resting_poses import RestingPoses
from holdfast.applications.settled import Settled
from holdfast.applications.transport import TransportLimits, TransportUnder
from holdfast.base.archive import load
from holdfast.base.errors import HoldfastError, message
from holdfast.batches.result import BatchReport
from holdfast.queries.constraint import Constraint
from holdfast.queries.map import RobustnessMap
from holdfast.queries.poses.robustness_of_poses import RobustnessOfPoses
from holdfast.queries.poses.stability_of_poses import StabilityOfPoses
from holdfast.queries.push import LoadFactor, Robustness, Sensitivity
from holdfast.queries.sets import ConvexSet
from holdfast.queries.stability import Stability
from holdfast.queries.uncertainty import RobustnessUnder, WorstCase

ANSWERS: tuple[type, ...] = (  # all classes of answers that can be saved
    *(Stability, Robustness, LoadFactor, RobustnessMap, RobustnessUnder, Sensitivity, WorstCase, MeasuredFriction),
    *(ConvexSet, Constraint, Derivatives, StabilityOfPoses, RobustnessOfPoses),
    *(
        TransportLimits,
        TransportUnder,
        Carried,
        Monitored,
        Disassembly,
        Removal,
        BuildOrder,
        SafePushes,
        Placement,
        Placements,
        Settled,
        RestingPoses,
        Firmer,
    ),
    BatchReport,
)


def load_answer(path: str | os.PathLike[str]) -> Any:  # noqa: ANN401 - the class that was saved
    """Read an answer from a .json or .npz file that its method ``save`` wrote.

    The result equals the answer that was saved. Raises HoldfastError if the file does not hold an answer.

    For example:

    >>> answer = hf.stability(hf.shipped_scene("cube"))
    >>> answer.save("cube.json")
    >>> hf.load_answer("cube.json") == answer
    True
    """
    found = load(path)
    if not isinstance(found, ANSWERS):
        problem = f"holds a {type(found).__name__}"
        known = ", ".join(cls.__name__ for cls in ANSWERS)
        raise HoldfastError(message(str(path), problem, f"needs an answer: {known}"))
    return found
