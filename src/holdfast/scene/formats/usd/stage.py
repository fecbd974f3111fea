"""Opening of USD stages: all layers must be in the folder of the stage, and its size is limited."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from holdfast.base.arrays import Float, checked_number
from holdfast.base.borders.foreign import foreign
from holdfast.base.errors import SceneError, message
from holdfast.base.files import check_ordinary
from holdfast.base.ranges import SCALE
from holdfast.base.rigid import Y_TO_Z
from holdfast.base.text import quoted
from holdfast.scene.formats.references import Packages, References
from holdfast.scene.formats.usd.usd_guard import check_lengths

MOST_LAYERS = 1_000  # largest number of files of a stage
MOST_PRIMS = 200_000  # largest number of prims of a stage, with each instance
MOST_DEEP = 200  # largest number of prims within and referring to each other
LOOKS = ".mtlx"  # suffix of layers that only look: USD does without those that are not there


class Stage(NamedTuple):
    """An open stage: its prims, its units in metres and kilograms, and the rotation (4, 4) after which z is up.

    ``whole`` keeps the stage alive, because prims expire with it. The types of USD objects are not checked.
    """

    whole: Any
    prims: list[Any]
    metres: float
    kilograms: float
    turn: Float

    def placed(self, prim: Any) -> Float:  # noqa: ANN401
        """Return the matrix (4, 4) from the frame of a prim, in units of the stage, to the world [m]."""
        from pxr import Usd, UsdGeom

        rows = UsdGeom.Xformable(prim).ComputeLocalToWorldTransform(Usd.TimeCode.Default())
        matrix = np.array(rows, dtype=np.float64).T
        with np.errstate(over="ignore", invalid="ignore"):  # infinite numbers raise an error that names the prim
            matrix[:3] *= self.metres
            return np.asarray(self.turn @ matrix)


def opened(path: Path, packages: Packages | None, notes: list[str]) -> Stage:
    """Open a stage after checking all of its layers.

    Raises SceneError if it cannot be read, names a layer elsewhere, or has too many layers or prims.
    """
    from pxr import Usd, UsdGeom, UsdPhysics

    _check_layers(path, packages)
    _check_composed(path)
    stage: Any = _opened(path, Usd.Stage.Open)
    metres = checked_number(UsdGeom.GetStageMetersPerUnit(stage), f"{path}: metersPerUnit", above=0, within=SCALE)
    kilograms = UsdPhysics.GetStageKilogramsPerUnit(stage)
    kilograms = checked_number(kilograms, f"{path}: kilogramsPerUnit", above=0, within=SCALE)
    if not UsdGeom.StageHasAuthoredMetersPerUnit(stage):
        notes.append(f"metersPerUnit is not given: {metres:g}, which USD says then")
    turn = np.eye(4)
    if str(UsdGeom.GetStageUpAxis(stage)) == "Y":
        turn = Y_TO_Z
        notes.append("y is up in the file: turned about x so that z is up")
    prims = []
    for prim in stage.Traverse(Usd.TraverseInstanceProxies()):
        prims.append(prim)
        if len(prims) > MOST_PRIMS:
            remedy = f"the limit is {MOST_PRIMS:,}, instances counted"
            raise SceneError(message(str(path), "has too many prims", remedy))
    return Stage(stage, prims, metres, kilograms, turn)


def _check_layers(path: Path, packages: Packages | None) -> None:
    """Open all layers one by one and refuse those outside the folder, before the stage is composed."""
    from pxr import Sdf

    references = References(path, packages)
    waiting, seen = [path], {path.resolve()}
    while waiting:
        here = waiting.pop()
        layer: Any = _opened(here, Sdf.Layer.FindOrOpen)
        _check_specs(layer)
        if here.suffix.lower() == ".usdz":
            _check_package(here, layer)
            continue
        for name in layer.GetCompositionAssetDependencies():
            if not name or (name.endswith(LOOKS) and not (here.parent / name).exists()):
                continue
            # absolute, as the folder of a stage with a relative path would otherwise be repeated
            found = references.file(os.path.abspath(here.parent / name) if "://" not in name else name, str(here))
            if found.resolve() not in seen:
                seen.add(found.resolve())
                waiting.append(found)
            if len(seen) > MOST_LAYERS:
                raise SceneError(message(str(path), "has too many layers", f"the limit is {MOST_LAYERS:,}"))


def _check_composed(path: Path) -> None:
    """Raise SceneError if the stage would have too many prims: references to references multiply.

    Each prim of a layer and of those below it is counted once, with all that it refers to; variants count as the
    largest one.
    """
    from pxr import Sdf

    known: dict[tuple[str, str], int] = {}

    def stack(layer: Any) -> list[Any]:  # noqa: ANN401
        found = [layer]
        for each in found:
            below = [Sdf.Layer.FindOrOpenRelativeToLayer(each, name) for name in each.subLayerPaths]
            found += [one for one in below if one and one not in found]
        return found

    def total(root: Any, at: Any, depth: int) -> int:  # noqa: ANN401
        key = root.identifier, str(at)
        if key not in known:
            if depth > MOST_DEEP:
                raise SceneError(message(str(path), "is nested too deeply", f"the limit is {MOST_DEEP} references"))
            known[key] = 0  # what refers to itself is an error of USD
            specs = [spec for spec in (layer.GetPrimAtPath(at) for layer in stack(root)) if spec]
            known[key] = sum(1 + of(spec, root, depth + 1) for spec in specs)
            if known[key] > MOST_PRIMS:
                raise SceneError(message(str(path), "has too many prims", f"the limit is {MOST_PRIMS:,}"))
        return known[key]

    def of(spec: Any, root: Any, depth: int) -> int:  # noqa: ANN401
        count = sum(total(root, child, depth) for child in {each.path for each in spec.nameChildren})
        for arc in (*spec.referenceList.GetAddedOrExplicitItems(), *spec.payloadList.GetAddedOrExplicitItems()):
            layer = Sdf.Layer.FindOrOpenRelativeToLayer(spec.layer, arc.assetPath) if arc.assetPath else root
            if layer:
                count += total(layer, arc.primPath or Sdf.Path(f"/{layer.defaultPrim}"), depth)
        for other in (*spec.inheritPathList.GetAddedOrExplicitItems(), *spec.specializesList.GetAddedOrExplicitItems()):
            count += total(root, other, depth)
        for variants in spec.variantSets.values():
            count += max((of(each.primSpec, root, depth) for each in variants.variants.values()), default=0)
        return count

    with foreign(str(path), "is no USD"):
        layer: Any = Sdf.Layer.FindOrOpen(str(path))
        for child in {each.path for one in stack(layer) for each in one.rootPrims}:
            total(layer, child, 0)


def _check_specs(layer: Any) -> None:  # noqa: ANN401
    """Raise SceneError if a binary layer names a child that it lacks; composing it would crash the process."""
    from pxr import Sdf

    if layer.GetFileFormat().formatId == "usda":  # the text parser creates all children that it names
        return

    def look(path: Any) -> None:  # noqa: ANN401
        if path.isEmpty or (not path.IsTargetPath() and layer.GetObjectAtPath(path) is None):
            lost.append(str(path))

    lost: list[str] = []
    layer.Traverse(Sdf.Path.absoluteRootPath, look)
    if lost:
        problem = f"is damaged: it names {quoted(lost[0])}, and does not hold it"
        raise SceneError(message(layer.identifier, problem, "check the file"))


def _check_package(package: Path, root: Any) -> None:  # noqa: ANN401
    """Open all layers in a package one by one; raise SceneError if one names what is not in the package.

    USD would search it at its absolute path, or in the current folder.
    """
    from pxr import Ar, Sdf

    waiting, seen = [root], {root.identifier}
    while waiting:
        layer = waiting.pop()
        for name in filter(None, layer.GetCompositionAssetDependencies()):
            found = Sdf.ComputeAssetPathRelativeToLayer(layer, name)
            outer = Ar.SplitPackageRelativePathOuter(found)[0] if Ar.IsPackageRelativePath(found) else ""
            if not outer or Path(outer).resolve() != package.resolve():
                problem = f"names {quoted(name)}, which is not in the package"
                raise SceneError(message(layer.identifier, problem, "put it into the package"))
            if found not in seen:
                seen.add(found)
                with foreign(str(package), "is no USD"):
                    waiting.append(Sdf.Layer.FindOrOpen(found))
                if waiting[-1] is None:
                    raise SceneError(message(found, "is no USD", "check the package"))
                _check_specs(waiting[-1])
            if len(seen) > MOST_LAYERS:
                raise SceneError(message(str(package), "has too many layers", f"the limit is {MOST_LAYERS:,}"))


def _opened(path: Path, open_: Callable[[str], Any]) -> Any:  # noqa: ANN401
    """Return the result of ``open_`` for a file; raise SceneError if there is no such file, or if it is not USD."""
    check_ordinary(path, "layer", remedy="check the paths in the file")
    check_lengths(path)
    with foreign(str(path), "is no USD"):
        found = open_(str(path))
    if not found:
        raise SceneError(message(str(path), "is no USD", "check the file"))
    return found
