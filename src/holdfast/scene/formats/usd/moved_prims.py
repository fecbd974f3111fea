"""Move prims of an open stage to where bodies come to rest, with opinions in its root layer alone."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np

from holdfast.base.arrays import Float
from holdfast.base.errors import SceneError, message
from holdfast.scene.formats.usd.stage import Stage

SAME = 1e-12  # largest entry of a rotation by less than which nothing is written
CLOSE = 1e-5  # relative error of a place once it is written: quaternions and vectors may be of single precision
SUFFIX = "settled"  # of the operation that is added to prims whose own operations do not take a motion


class Placement(NamedTuple):
    """The place of a prim: its path, and the 16 numbers of the matrix from its frame to the world, as USD has them."""

    path: str
    matrix: tuple[float, ...]


def placements(stage: Stage, prims: Iterable[Any], motion: Float) -> list[Placement]:
    """Return where prims come by the rigid ``motion`` (4, 4) of the world [m, z up], in units and axes of the stage.

    Raises SceneError for a prim within an instance, which no layer can move by itself.
    """
    from pxr import Usd, UsdGeom

    own = np.linalg.inv(stage.turn) @ motion @ stage.turn
    own[:3, 3] /= stage.metres
    found = []
    for prim in prims:
        if prim.IsInstanceProxy():
            raise SceneError(message(str(prim.GetPath()), "is part of an instance", "move the instance as a whole"))
        now = np.array(UsdGeom.Xformable(prim).ComputeLocalToWorldTransform(Usd.TimeCode.Default()))
        found.append(Placement(str(prim.GetPath()), tuple((now @ own.T).ravel().tolist())))
    return found


def place(whole: Any, wanted: Sequence[Placement]) -> None:  # noqa: ANN401 - a stage of USD
    """Move prims of a stage, parents first; what is there already stays as it is. Nothing is saved.

    A translation and a quaternion at the head of a prim's operations get new values; other prims get one more operation
    in front. Raises SceneError if a prim is gone, or if it stays elsewhere because of a stronger opinion.
    """
    from pxr import Gf, Usd, UsdGeom

    with Usd.EditContext(whole, Usd.EditTarget(whole.GetRootLayer())):
        for path, numbers in sorted(wanted):
            prim = whole.GetPrimAtPath(path)
            if not prim:
                raise SceneError(message(path, "is not in the stage any more", "validate it again"))
            shape, there = UsdGeom.Xformable(prim), Gf.Matrix4d(*numbers)
            _move(shape, there)
            off = np.abs(np.array(shape.ComputeLocalToWorldTransform(Usd.TimeCode.Default())) - np.array(there)).max()
            if off > CLOSE * max(1.0, float(np.abs(numbers).max())):
                raise SceneError(message(path, "stays where it is", "a layer above the root layer places it"))


def _move(shape: Any, there: Any) -> None:  # noqa: ANN401 - a UsdGeom.Xformable and a Gf.Matrix4d
    """Write that the matrix from the frame of a prim to the world is ``there``."""
    from pxr import Gf, Usd, UsdGeom

    resets, time = shape.GetResetXformStack(), Usd.TimeCode.Default()
    parent = Gf.Matrix4d(1) if resets else shape.ComputeParentToWorldTransform(time)
    now = shape.ComputeLocalToWorldTransform(time)
    change = parent * now.GetInverse() * there * parent.GetInverse()  # after all that the prim does, in its parent
    turned = np.abs(np.array(change)[:3, :3] - np.eye(3)).max() > SAME
    if not turned and np.abs(np.array(change)[3, :3]).max() == 0:
        return
    ops = shape.GetOrderedXformOps()
    kinds = [None if op.IsInverseOp() else op.GetOpType() for op in ops]
    moves = kinds[:1] == [UsdGeom.XformOp.TypeTranslate]
    orients = kinds[1:2] == [UsdGeom.XformOp.TypeOrient]
    rigid = np.allclose(np.array(change)[:3, :3] @ np.array(change)[:3, :3].T, np.eye(3), atol=1e-9)
    if moves and (not turned or (orients and rigid)):
        at = ops[0].Get()
        ops[0].Set(type(at)(change.Transform(Gf.Vec3d(at))))
        if turned:
            old = ops[1].Get()
            ops[1].Set(type(old)((Gf.Matrix4d().SetRotate(Gf.Quatd(old)) * change).ExtractRotationQuat()))
        return
    front = ops[0] if ops and ops[0].GetOpName() == f"xformOp:transform:{SUFFIX}" else None
    if front is None:
        front = shape.AddTransformOp(UsdGeom.XformOp.PrecisionDouble, SUFFIX)
        front.Set(change)
        shape.SetXformOpOrder([front, *ops], resets)
    else:
        front.Set(front.Get() * change)
