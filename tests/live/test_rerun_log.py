"""What is logged to Rerun: by a recorder in its place, so that rerun-sdk need not be installed, and once by itself."""

from __future__ import annotations

import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import holdfast as hf
from holdfast.scene.shipped.blocks import at

ARCHETYPES = ["TextDocument", "LineStrips3D", "Points3D", "Arrows3D", "Scalars", "Clear", "Transform3D", "Mesh3D"]


class Recorder(SimpleNamespace):
    """Stands in for the module ``rerun`` and keeps every record as (path, kind, static, time, content)."""

    def __init__(self) -> None:
        made = {kind: lambda *a, _kind=kind, **k: SimpleNamespace(kind=_kind, positional=a, **k) for kind in ARCHETYPES}
        super().__init__(**made, records=[], now={})

    def get_data_recording(self, recording: Any) -> Any:
        return recording or "current"

    def set_time(self, timeline: str, *, recording: Any, **when: float) -> None:
        self.now = {timeline: next(iter(when.items()))}

    def disable_timeline(self, timeline: str, *, recording: Any) -> None:
        del self.now[timeline]

    def log(self, path: list[str], content: Any, *, static: bool, recording: Any) -> None:
        self.records.append(("/".join(path), content, static, dict(self.now)))

    def at(self, path: str) -> list[tuple[str, Any, bool, dict[str, Any]]]:
        return [record for record in self.records if record[0] == path]


@pytest.fixture
def recorder(monkeypatch: pytest.MonkeyPatch) -> Recorder:
    found = Recorder()
    monkeypatch.setitem(sys.modules, "rerun", found)  # type: ignore[arg-type]
    return found


def tall() -> hf.Scene:
    """A tall box 0.1 x 0.1 x 0.4 m of 1 kg on a fixed plate, μ 1: it topples."""
    plate = hf.Body("plate", hf.Box((1, 1, 0.1)), pose=at(0, 0, -0.05), fixed=True)
    return hf.Scene([plate, hf.Body("tall", hf.Box((0.1, 0.1, 0.4)), mass=1, pose=at(0, 0, 0.2))], 1.0, name="tall")


def transforms(recorder: Recorder, body: str) -> list[np.ndarray]:
    """The transforms (4, 4) of a body along the timeline."""
    found = []
    for _, content, static, now in recorder.at(f"holdfast/bodies/{body}"):
        if content.kind == "Transform3D":
            assert not static
            assert now
            place = np.eye(4)
            place[:3, :3], place[:3, 3] = content.mat3x3, content.translation
            found.append(place)
    return found


def test_a_map_brings_bodies_contacts_forces_points_and_the_mechanism_of_its_weakest_push(recorder: Recorder) -> None:
    found = hf.robustness_map(tall(), spacing=0.05)
    hf.log_to_rerun(found)
    (mesh,) = [content for _, content, static, _ in recorder.at("holdfast/bodies/tall") if static]
    corners = mesh.vertex_positions[mesh.triangle_indices]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1).sum() / 2
    assert area == pytest.approx(2 * 0.01 + 4 * 0.04)
    assert mesh.vertex_colors.dtype == np.uint8
    assert len(mesh.vertex_colors) == len(mesh.vertex_positions)
    ((_, forces, _, _),) = recorder.at("holdfast/forces")
    assert forces.labels == ["plate on tall: 9.81 N"]
    np.testing.assert_allclose(forces.origins + forces.vectors, [[0, 0, 0]], atol=1e-6)
    ((_, patches, _, _),) = recorder.at("holdfast/contacts/patches")
    np.testing.assert_array_equal(patches.positional[0][0][0], patches.positional[0][0][-1])  # closed
    ((_, points, _, _),) = recorder.at("holdfast/points")
    assert len(points.labels) == len(points.positional[0]) == len(found.force)
    weak = found.weakest()
    assert f"{weak.force:.4g} N" in points.labels
    ((_, pushes, _, _),) = recorder.at("holdfast/pushes")
    np.testing.assert_allclose(pushes.origins + pushes.vectors, [weak.point])
    places = transforms(recorder, "tall")
    assert len(places) == 11
    np.testing.assert_array_equal(places[0], np.eye(4))
    turned = places[-1] @ [0, 0, 0.4, 1]
    assert turned[2] > 0.4 - 0.01  # it turns about an edge, so that its top goes sideways and does not sink
    assert np.linalg.norm(turned[:2]) > 0.02
    assert recorder.now == {}  # later records of the caller are not on the timeline


def test_the_answer_is_there_in_words(recorder: Recorder) -> None:
    hf.log_to_rerun(hf.stability(tall()), entity="verdict")
    ((_, words, static, _),) = recorder.at("verdict/answer")
    assert static
    assert "stable" in words.positional[0]
    assert {path.split("/")[0] for path, *_ in recorder.records} == {"verdict"}


def test_a_verdict_that_it_falls_moves_what_falls(recorder: Recorder) -> None:
    scene = hf.Scene([*tall().bodies, hf.Body("air", hf.Box((0.1, 0.1, 0.1)), mass=1, pose=at(0.3, 0, 0.5))], 1.0)
    hf.log_to_rerun(hf.stability(scene))
    assert transforms(recorder, "air")[-1][2, 3] < -0.01
    assert transforms(recorder, "tall") == []


def test_transport_and_a_drive_are_plots_along_their_timelines(recorder: Recorder) -> None:
    assembly = hf.assemble(tall())
    limits = hf.transport_limits(assembly, assembly.scene.horizontal_directions(4))
    hf.log_to_rerun(limits)
    logged = [(now["step"][1], content.positional[0]) for _, content, _, now in recorder.at("holdfast/lower")]
    assert logged == list(enumerate(limits.lower.tolist()))
    assert len(transforms(recorder, "tall")) == 4
    recorder.records.clear()
    drive = hf.carry(assembly, hf.Profile([0.0, 0.5, 1.0], [(1.0, 0, 0), (2.0, 0, 0), (3.0, 0, 0)]))
    hf.log_to_rerun(drive)
    assert [now["time"] for *_, now in recorder.at("holdfast/factor")] == [("duration", t) for t in (0.0, 0.5, 1.0)]
    still = [np.array_equal(place, np.eye(4)) for place in transforms(recorder, "tall")]
    assert still == (drive.factor >= 1).tolist() == [True, True, False]


@pytest.mark.filterwarnings("ignore::holdfast.errors.HoldfastWarning")
def test_what_is_undecided_is_not_plotted_as_0(recorder: Recorder) -> None:
    """A block 3 mm inside the plate: what carries it is not known."""
    sunk = hf.Body("sunk", hf.Box((0.1, 0.1, 0.1)), mass=1, pose=at(0, 0, 0.047))
    limits = hf.transport_limits(hf.Scene([tall().bodies[0], sunk], 1.0), [(1, 0, 0), (0, 1, 0)])
    assert limits.lower.tolist() == [0, 0]
    assert not limits.answers.decided.any()
    hf.log_to_rerun(limits)
    assert recorder.at("holdfast/lower") == []


def test_bodies_that_are_taken_out_vanish_at_their_step(recorder: Recorder) -> None:
    order = hf.disassembly_order(hf.shipped_scene("stack"))
    hf.log_to_rerun(order)
    for number, name in enumerate(order.order):
        kinds = [(content.kind, now["step"][1]) for _, content, _, now in recorder.at(f"holdfast/bodies/{name}")]
        assert kinds[0] == ("Mesh3D", 0)
        assert kinds[-1] == ("Clear", number + 1)


def test_objects_that_are_put_down_and_resting_poses_are_states(recorder: Recorder) -> None:
    poses = hf.resting_poses(hf.Box((0.1, 0.2, 0.3)))
    hf.log_to_rerun(poses)
    places = transforms(recorder, poses.body.name)
    for place, pose in zip(places, poses, strict=True):
        np.testing.assert_allclose(place @ poses.body.pose, pose.pose, atol=1e-12)


def test_what_is_wrong_is_told(recorder: Recorder, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    with pytest.raises(hf.HoldfastError, match="answer is a int; needs a scene, an assembly or an answer"):
        hf.log_to_rerun(3)  # type: ignore[arg-type]
    recorder.get_data_recording = lambda _: None
    with pytest.raises(hf.HoldfastError, match=r"there is no recording; call rerun\.init"):
        hf.log_to_rerun(tall())
    monkeypatch.setitem(sys.modules, "rerun", None)
    with pytest.raises(hf.HoldfastError, match=r"needs rerun-sdk.*holdfast-robotics\[rerun\]"):
        hf.log_to_rerun(tall())


def test_rerun_itself_takes_the_records(tmp_path: Path) -> None:
    chunk = pytest.importorskip("rerun.chunk", reason="needs rerun-sdk: pip install 'holdfast-robotics[rerun]'")
    import rerun

    stream = rerun.RecordingStream("holdfast")
    stream.save(tmp_path / "map.rrd")
    hf.log_to_rerun(hf.robustness_map(tall(), spacing=0.05), recording=stream)
    stream.disconnect()
    paths = {each.entity_path for each in chunk.RrdReader(tmp_path / "map.rrd").stream().to_chunks()}
    below = {path.removeprefix("/holdfast/") for path in paths if path.startswith("/holdfast/")}
    contacts = {"contacts/nodes", "contacts/patches"}
    assert below == {"answer", "bodies/plate", "bodies/tall", "forces", "points", "pushes", "step"} | contacts
