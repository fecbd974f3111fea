"""A rule for NVIDIA's USD validator (``usd-validation-nvidia``), which finds it by its entry point.

The rule asks of every stage with UsdPhysics what ``scene_findings`` asks of a scene. Nothing of the validator or of USD
is imported before the validator starts the plugin.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from functools import partial
from typing import Any, Final

import numpy as np

from holdfast.base.errors import HoldfastError, SceneError
from holdfast.base.text import listed, one_line
from holdfast.batches.scene_findings import SceneFinding, ScenePolicy, findings_of_scene
from holdfast.scene.formats.usd.moved_prims import Placement, place, placements
from holdfast.scene.formats.usd.reader import read_open
from holdfast.scene.formats.usd.stage import Stage
from holdfast.scene.formats.usd.usd_bodies import RIGID, PrimGroup, has
from holdfast.scene.scene import Scene

CATEGORY: Final = "Physics"
LONGEST = 1000  # characters of a message
RULE_TEXT = """Everything stands, and nothing overlaps or hovers.

Bodies with UsdPhysics must stand at rest in frictional contact, overlap or hover by no more than a tolerance, and
withstand a stated push. What is not certain is a warning that begins with "undecided". The suggestion of a finding
moves the bodies that touch to rest, in the root layer.

Parameters: HOLDFAST_TOLERANCE [m], default a thousandth of the size of a pair. HOLDFAST_MIN_FORCE [N], default none.
HOLDFAST_TRAVEL [m], how far suggestions may move bodies, default 0.03. HOLDFAST_FRICTION, of colliders without a
physics material. HOLDFAST_COMBINE, how two coefficients combine: least (default), mean, product, largest.
HOLDFAST_FLOOR, adds the half space below zero. HOLDFAST_RIGID, joints that can move hold. HOLDFAST_NOTES, tells what
was guessed or left out of stages that pass, too.
"""
# Parameter of the validator: its type there and its default
PARAMETERS: Mapping[str, tuple[str, Any]] = {
    "HOLDFAST_TOLERANCE": ("FLOAT", None),
    "HOLDFAST_MIN_FORCE": ("FLOAT", None),
    "HOLDFAST_TRAVEL": ("FLOAT", ScenePolicy.travel),
    "HOLDFAST_FRICTION": ("FLOAT", None),
    "HOLDFAST_COMBINE": ("ENUM", None),
    "HOLDFAST_FLOOR": ("BOOL", False),
    "HOLDFAST_RIGID": ("BOOL", False),
    "HOLDFAST_NOTES": ("BOOL", False),
}


class HoldfastPlugin:
    """What the validator starts: it registers the rule, and takes it away at the end."""

    def __init__(self) -> None:
        self._rule: Any = None

    def on_startup(self) -> None:
        """Register the rule."""
        from usd_validation_nvidia import register_requirements, register_rule

        rule, requirement = _rule()
        self._rule = register_rule(CATEGORY)(register_requirements(requirement)(rule))

    def on_shutdown(self) -> None:
        """Take the rule away."""
        from usd_validation_nvidia import unregister_requirements, unregister_rule

        unregister_rule(self._rule)
        unregister_requirements(self._rule)
        self._rule = None


def _rule() -> tuple[Any, Any]:
    """Return the class of the rule, and the requirement that declares its parameters."""
    from usd_validation_nvidia import BaseRuleChecker, Issue, IssueSeverity, Suggestion
    from usd_validation_nvidia.capabilities import Parameter, ParameterType, Requirement

    words = ("least", "mean", "product", "largest")
    parameters = tuple(
        Parameter(name, ParameterType[kind], default, words if kind == "ENUM" else None)
        for name, (kind, default) in PARAMETERS.items()
    )
    requirement = Requirement(
        code="HOLDFAST.001",
        version="1.0.0",
        display_name="at-rest",
        message="Everything stands, and nothing overlaps or hovers.",
        tags=("physics",),
        parameters=parameters,
    )

    class HoldfastChecker(BaseRuleChecker):  # type: ignore[misc]  # of a package that need not be installed
        __doc__ = RULE_TEXT

        def CheckStage(self, usdStage: Any) -> None:  # noqa: N802, ANN401 - names of the validator
            """Check what can move in a stage; nothing is written."""
            given = {name: default for name, (_, default) in PARAMETERS.items()}
            given |= {one.display_name: one.assigned_value for one in self.parameters if one.display_name in given}
            for finding, at, wanted in stage_findings(usdStage, given):
                issue = Issue(
                    message=one_line(finding.text, LONGEST),
                    severity=IssueSeverity[finding.severity.upper()],
                    rule=type(self),
                    at=at,
                    suggestion=Suggestion(partial(_move, wanted=wanted), finding.how) if wanted else None,
                    requirement=requirement,
                )
                self._AddIssue(issue)

    return HoldfastChecker, requirement


def _move(stage: Any, _at: Any, *, wanted: tuple[Placement, ...]) -> None:  # noqa: ANN401 - as the validator calls it
    place(stage, wanted)


def stage_findings(
    whole: Any,  # noqa: ANN401 - a stage of USD
    given: Mapping[str, Any],
) -> Iterator[tuple[SceneFinding, Any, tuple[Placement, ...]]]:
    """Yield the findings of a stage, each with the prim or the stage where it is, and where prims should be.

    ``given`` are values of all parameters by name. A stage without rigid bodies has no findings; one that cannot be
    read or asked, or whose layers are not all there, has one that says so.
    """
    from pxr import Usd

    lost = [str(error) for error in whole.GetCompositionErrors()]
    if lost:
        text = f"undecided whether everything stands, as not all of it could be composed: {listed(lost, 2)}"
        yield SceneFinding("warning", text), whole, ()
    if not any(has(prim, RIGID) for prim in whole.Traverse(Usd.TraverseInstanceProxies())):
        return
    own = {name.removeprefix("HOLDFAST_").lower(): value for name, value in given.items()}
    options = {name: own[name] for name in ("friction", "combine", "rigid", "floor")}
    policy = ScenePolicy(*(own[name] for name in ("tolerance", "min_force", "travel")))
    try:
        scene, stage, groups = read_open(whole, **options)
        found = findings_of_scene(scene, policy)
    except HoldfastError as error:
        yield SceneFinding("warning", f"undecided whether everything stands: {error}"), _named(whole, error), ()
        return
    for name, group in groups.items():
        if not group.colliders and not group.fixed:
            text = f"undecided whether {one_line(name)} stands: it has no collider, so all else is asked without it"
            yield SceneFinding("warning", text), group.prim, ()
    told = own["notes"] or any(finding.severity != "info" for finding in found)
    for finding in found:
        if finding.severity != "info" or told:
            yield _at_prims(whole, scene, stage, groups, finding)


def _at_prims(
    whole: Any,  # noqa: ANN401
    scene: Scene,
    stage: Stage,
    groups: Mapping[str, PrimGroup],
    finding: SceneFinding,
) -> tuple[SceneFinding, Any, tuple[Placement, ...]]:
    """Return a finding with its prim and with where its remedy places prims; without these if no layer can say so.

    Bodies whose prims are below those that move stay where they are.
    """
    at = groups[finding.body].prim if finding.body in groups else whole
    wanted = list[Placement]()
    try:
        for name, pose in finding.remedy.items():
            motion = pose @ np.linalg.inv(scene.body(name).pose)
            wanted += placements(stage, [prim for prim, _ in groups[name].members], motion)
        moved = [prim.GetPath() for name in finding.remedy for prim, _ in groups[name].members]
        others = [prim for name, group in groups.items() if name not in finding.remedy for prim, _ in group.members]
        below = [prim for prim in others if any(prim.GetPath().HasPrefix(path) for path in moved)]
        wanted += placements(stage, below, np.eye(4))
    except SceneError as error:
        return SceneFinding(finding.severity, f"{finding.text}; no remedy: {error}", finding.body), at, ()
    return finding, at, tuple(wanted)


def _named(whole: Any, error: HoldfastError) -> Any:  # noqa: ANN401 - of types of USD
    """Return the prim whose path an error names, or the stage."""
    from pxr import Sdf

    paths = [path for path in re.findall(r"/[\w/]+", str(error)) if Sdf.Path.IsValidPathString(path)]
    return next((prim for path in paths if (prim := whole.GetPrimAtPath(path))), whole)
