"""What the numbers of a saved state of a MuJoCo model mean: which are positions, which of them quaternions."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from holdfast.base.arrays import Float
from holdfast.base.errors import HoldfastError, message
from holdfast.base.rigid import pose_from, quaternion_of
from holdfast.base.text import listed, quoted
from holdfast.scene.formats.mjcf.live import free_joints
from holdfast.scene.formats.mjcf.mjcf_guard import read_apart
from holdfast.scene.formats.mjcf.mobility import BALL, FREE
from holdfast.scene.formats.mjcf.reader import CompiledModel, files_named, to_be_read_apart
from holdfast.scene.formats.mjcf.rules import entries
from holdfast.scene.formats.source import Source

UNIT = 1e-3  # by how much the length of a quaternion may differ from 1: files round


class StateLayout(NamedTuple):
    """The numbers of a state: time if there is one, ``nq`` positions, then ``nv`` velocities and ``na`` activations.

    ``quaternions`` are the names of joints with the place of their quaternion among the positions; ``free`` are by the
    names of bodies of the scene the places of the positions and velocities of the free joints that move with them.
    """

    nq: int
    nv: int
    na: int
    quaternions: tuple[tuple[str, int], ...]
    free: Mapping[str, tuple[tuple[int, int], ...]]

    def first(self, values: Float, where: str) -> int:
        """Return where positions begin in rows of states (n, w); raise HoldfastError unless they fit the model.

        They are ``nq``, ``nq + nv`` or ``1 + nq + nv`` finite numbers, or also ``na`` more, with quaternions of unit
        length.
        """
        whole, width = 1 + self.nq + self.nv, values.shape[1]
        known = {self.nq: 0, self.nq + self.nv: 0, whole: 1, whole + self.na: 1}
        if width not in known:
            problem = f"states have {width} numbers"
            wanted = f"qpos {self.nq}, with qvel {self.nq + self.nv}, with time {whole}"
            raise HoldfastError(message(where, problem, f"this model needs {wanted}: is it another model?"))
        bad = np.argwhere(~np.isfinite(values))
        if len(bad):
            row, k = bad[0].tolist()
            more = f", and {len(bad) - 1:,} more" if len(bad) > 1 else ""
            problem = f"number {k} of row {row} is {values[row, k]}{more}"
            raise HoldfastError(message(where, problem, "needs finite numbers"))
        first = known[width]
        for name, at in self.quaternions:
            lengths = np.linalg.norm(values[:, first + at : first + at + 4], axis=1)
            wrong = np.flatnonzero(np.abs(lengths - 1) > UNIT)
            if len(wrong):
                problem = f"the quaternion of joint {quoted(name)} in row {wrong[0]} has length {lengths[wrong[0]]:.4g}"
                problem += f", and {len(wrong) - 1:,} more" if len(wrong) > 1 else ""
                remedy = "needs w, x, y, z of length 1: is it another model, or another order of joints?"
                raise HoldfastError(message(where, problem, remedy))
        return first

    def moved(self, row: Float, first: int, body: str, old: Float, new: Float) -> None:
        """Move a body in a state (w,), in place, by what brings its pose from ``old`` to ``new`` (4, 4); it is at rest.

        Raises HoldfastError for a body that moves by other joints than a free one.
        """
        if not self.free.get(body):
            problem = f"{quoted(body)} moves by other joints than a free one"
            raise HoldfastError(message("fix", problem, f"can move {listed(list(self.free)) or 'no body'}"))
        shift = new @ np.linalg.inv(old)
        for at, dof in self.free[body]:
            own = row[first + at : first + at + 7]
            pose = shift @ pose_from(own[:3], own[3:] / np.linalg.norm(own[3:]))
            own[:3], turned = pose[:3, 3], quaternion_of(pose[:3, :3])
            own[3:] = turned if turned @ own[3:] >= 0 else -np.asarray(turned)
            if len(row) > first + self.nq:
                row[first + self.nq + dof : first + self.nq + dof + 6] = 0.0


def layout_of(source: Source, **options: Any) -> StateLayout:  # noqa: ANN401 - those of the reader
    """Return what the numbers of a state of this model mean; ``options`` are those of its reader, without key and qpos.

    Raises SceneError for a model that cannot be read.
    """
    within: str | os.PathLike[str] | None = options.get("within")
    files = files_named(source, within)
    if to_be_read_apart(source, files):
        return read_apart(layout_of, source, options)
    known = CompiledModel(source, files, **{name: value for name, value in options.items() if name != "within"})
    known.scene()
    model, names = known.model, entries(known.model, "jnt", int(known.model.njnt))
    turned = {FREE: 3, BALL: 0}
    quaternions = [
        (names[j] or str(j), int(model.jnt_qposadr[j]) + turned[int(model.jnt_type[j])])
        for j in range(int(model.njnt))
        if int(model.jnt_type[j]) in turned
    ]
    free = {}
    if options.get("hold_torques", False) is False:
        for name, joints in free_joints(model, known.data, rigid=bool(options.get("rigid", False))).items():
            places = [(int(model.jnt_qposadr[j]), int(model.jnt_dofadr[j])) for j in joints]
            free[known.renamed.get(name, name)] = tuple(places)
    return StateLayout(int(model.nq), int(model.nv), int(model.na), tuple(quaternions), free)
