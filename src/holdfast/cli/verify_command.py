"""The command ``verify``."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Any

import typer

from holdfast.base.errors import HoldfastError, message
from holdfast.base.files import read_ordinary
from holdfast.base.text import listed
from holdfast.certificates.verify_certificate import MOST, UNCHECKED, RefusedError, claims_of
from holdfast.cli.output import out

NOT_VERIFIED = 1  # exit code
AGREED = "agrees with {}: gravity, masses, centres of mass, friction and points of contact, found anew"
LOADS = "not checked: that loads and acceleration are as they really are, and the scene"


def verify(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="a certificate: a JSON file")],
    geometry: Annotated[
        str | None, typer.Option("--geometry", metavar="SCENE", help="compare bodies and contacts with this scene, too")
    ] = None,
) -> None:
    """Check that a certificate proves what it claims, in exact arithmetic, and say what that is."""
    content = read_ordinary(file, "certificate", most=MOST, error=HoldfastError, too_large="certify fewer rows")
    try:
        claims = claims_of(content.decode())
    except UnicodeDecodeError as cause:
        raise HoldfastError(message(str(file), "is no text in UTF-8", "give a certificate")) from cause
    except RefusedError as why:
        _say(f"NOT verified: {why}")
        raise typer.Exit(NOT_VERIFIED) from None
    for claim in claims:
        _say(f"verified: {claim}")
    if geometry is None:
        _say(UNCHECKED)
    else:
        _compare(json.loads(content), geometry)


def _compare(data: Any, scene: str) -> None:  # noqa: ANN401 - JSON
    """Say whether the bodies and contacts of a verified certificate are those of a scene."""
    from holdfast.assembly.assembly import assemble  # checking alone needs none of this
    from holdfast.certificates.beside_scene import differences, left_out
    from holdfast.cli.scenes import SceneGiven
    from holdfast.scene.hold import refuse_holds

    assembly = assemble(SceneGiven(scene=scene).read())
    refuse_holds(assembly.scene.holds, f"--geometry {scene}", "certificates hold contact forces alone")
    states = data if isinstance(data, list) else [data]
    for k, state in enumerate(states, 1):
        which = f"state {k}: " if states is data else ""
        different = differences(state, assembly)
        if different:
            _say(f"{which}does NOT agree with {scene}: {'; '.join(different)}")
            raise typer.Exit(NOT_VERIFIED)
        missing, touching = left_out(state, assembly)
        if missing:
            _say(f"{which}without {listed(missing)}, which the scene has")
        if touching and states is not data:
            _say(f"does NOT agree with {scene}: some of these touch what is listed")
            raise typer.Exit(NOT_VERIFIED)
    _say(AGREED.format(scene))
    _say(LOADS)


def _say(line: str) -> None:
    """Print a line as it is: names in it may look like markup."""
    out.print(line, markup=False, soft_wrap=True)
