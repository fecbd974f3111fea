"""The command ``settle``."""

from __future__ import annotations

from functools import partial
from typing import Annotated

from holdfast.applications.settled import settle as settle_scene
from holdfast.cli.file_commands import WRITTEN_SUFFIXES
from holdfast.cli.output import AsJson, progress
from holdfast.cli.scenes import SceneGiven, takes_scene
from holdfast.cli.shared_options import (
    EngineName,
    File,
    Files,
    Png,
    Several,
    check_suffix,
    engine_with,
    option,
    tell,
)
from holdfast.queries.request import DEFAULT_ENGINE
from holdfast.report.pose_report import settled_report
from holdfast.scene.formats.registry import save_scene
from holdfast.scene.scene import with_notes

TURN = 15.0  # [deg] default of --turn-degrees of settle


@takes_scene
def settle(
    scene: SceneGiven,
    output: Annotated[
        File, option(f"write the scene at rest to this file: {WRITTEN_SUFFIXES}", "--output", "-o")
    ] = None,
    travel: Annotated[float, option("a body that goes farther than this in m falls")] = 0.03,
    turn_degrees: Annotated[float, option("a body that turns by more than this in degrees falls")] = TURN,
    known: Annotated[Several, option("a body whose pose is exact (may be repeated)")] = None,
    upright: Annotated[Several, option("a body that stands upright (may be repeated)")] = None,
    pose_sigma: Annotated[float | None, option("standard deviation of the positions in m")] = None,
    png: Png = None,
    engine: EngineName = DEFAULT_ENGINE,
    gap: Annotated[float | None, option("contact tolerance of the verdict in m; default: by pair")] = None,
    as_json: AsJson = False,
) -> None:
    """Bring a perceived or authored scene to rest near its poses, and say what moved and what falls."""
    check_suffix(png, ".png")
    method = engine_with(engine)
    remarks = [f"--turn-degrees: what turns by more than {turn_degrees:g}° falls"] if turn_degrees != TURN else []
    with progress():
        result = settle_scene(
            with_notes(scene.read(), remarks),
            travel=travel,
            turn_degrees=turn_degrees,
            known=known or (),
            upright=upright or (),
            pose_sigma=pose_sigma,
            gap=gap,
            engine=method,
        )
    files: Files = [(png, result.save_png), (output, partial(save_scene, result.scene))]
    report = partial(settled_report, scene=result.given.name or scene.scene)
    tell(result, report, as_json=as_json, files=files)
