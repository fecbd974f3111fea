"""The commands that work without the rest of the program, whatever is wrong with it: verify and doctor."""

from __future__ import annotations

import json
import platform
import re
import sys
from importlib import metadata
from pathlib import Path
from typing import Annotated, Any

import typer

from holdfast import __version__
from holdfast.base.envelope import envelope
from holdfast.base.errors import DISTRIBUTION, HoldfastError, installing, message
from holdfast.base.files import read_ordinary
from holdfast.base.plugins import installed_plugins
from holdfast.base.progress import cores
from holdfast.base.text import listed, many
from holdfast.certificates.verify_certificate import MOST, UNCHECKED, RefusedError, claims_of
from holdfast.cli.output import AsJson, out, print_json

NOT_VERIFIED = 1  # exit code
AGREED = "agrees with {}: gravity, masses, centres of mass, friction and points of contact, found anew"
LOADS = "not checked: that loads and acceleration are as they really are, and the scene"
NOT_FOR_USE = ("test", "dev", "docs")  # extras for development, which users do not need
_NAME = re.compile(r"[\w.-]+")
_EXTRA = re.compile(r"extra == ['\"]([\w-]+)['\"]")


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


def doctor(as_json: AsJson = False) -> None:
    """Report what is installed, plug-ins too, and which extras are missing.

    Include the output in reports of defects.
    """
    facts = examined()
    if as_json:
        print_json(envelope("doctor", reason="what is installed", details=facts))
        return
    out.say(
        f"holdfast {facts['holdfast']}, Python {facts['python']}, {facts['system']}, {many(facts['cores'], 'core')}"
    )
    rows = [("needed for", "package", "version")]
    for extra, packages in facts["packages"].items():
        rows += [(extra, name, version or f"missing: {installing(extra)}") for name, version in packages.items()]
    rows += [("plug-in", name, f"{text}; off unless named: --plugin {name}") for name, text in facts["plugins"].items()]
    first, second = (max(len(row[k]) for row in rows) for k in range(2))
    for extra, name, version in rows:  # not as a table: one is cut at the width of the terminal
        out.print(f"{extra:{first}}  {name:{second}}  {version}", soft_wrap=True)


def examined() -> dict[str, Any]:
    """Return the versions of packages by extra (None if missing), the plug-ins, and the system."""
    return {
        "holdfast": __version__,
        "python": platform.python_version(),
        "system": f"{platform.system()} {platform.machine()}",
        "executable": sys.executable,
        "cores": cores(),
        "packages": {extra: {name: _version(name) for name in names} for extra, names in _needed().items()},
        "plugins": installed_plugins(),
    }


def _needed() -> dict[str, list[str]]:
    """Return the required packages by extra; those that holdfast always needs are under "core"."""
    try:
        lines = metadata.requires(DISTRIBUTION) or []
    except metadata.PackageNotFoundError:  # run from its sources
        lines = []
    packages: dict[str, list[str]] = {"core": []}
    for line in lines:
        name, extra = _NAME.match(line), _EXTRA.search(line)
        group = extra[1] if extra else "core"
        if name and name[0] != DISTRIBUTION and group not in NOT_FOR_USE:
            packages.setdefault(group, []).append(name[0])
    return packages


def _version(name: str) -> str | None:
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return None
