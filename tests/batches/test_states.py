"""Many states of one MuJoCo model: verdicts, equality with single calls, files, and bad input."""

from __future__ import annotations

import io
import json
import pickle
import warnings
import zipfile
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest
from start_states import BENCHMARKS, STABLE, Floats

import holdfast as hf
from holdfast.base.envelope import schema
from holdfast.batches.state_files import read_states
from holdfast.batches.states import states_of

pytest.importorskip("mujoco")

BLOCKS = """<mujoco><worldbody><geom name="floor" type="plane" size="1 1 1"/>
<body name="low" pos="0 0 .05"><freejoint name="low"/><geom type="box" size=".05 .05 .05"/></body>
<body name="high" pos="0 0 .13"><freejoint name="high"/><geom type="box" size=".03 .03 .03"/></body>
</worldbody></mujoco>"""
REST = [0, 0, 0.05, 1, 0, 0, 0, 0, 0, 0.13, 1, 0, 0, 0]
NV = 12


@pytest.fixture
def blocks(tmp_path: Path) -> Path:
    (tmp_path / "blocks.xml").write_text(BLOCKS)
    return tmp_path / "blocks.xml"


def raised(*heights: float) -> Floats:
    """States (n, 1 + nq + nv) in which the upper block hangs so high above the lower one [m]; all bodies move on."""
    states = np.hstack([np.full((len(heights), 1), 0.5), np.tile(REST, (len(heights), 1)), np.ones((len(heights), NV))])
    states[:, 1 + 9] += heights
    return states


def rows_of(model: Path, states: Any, out: Path, ask: tuple[str, ...] = ("stability",)) -> list[dict[str, Any]]:
    hf.batch({model: states}, ask, out=out, workers=1)
    return list(hf.read_batch(out).rows())


@pytest.mark.parametrize("name", BENCHMARKS)
def test_the_states_of_a_benchmark_have_the_verdicts_that_they_were_made_for(name: str, tmp_path: Path) -> None:
    made = BENCHMARKS[name]()
    (tmp_path / "model.xml").write_text(made.xml)
    rows = rows_of(tmp_path / "model.xml", made.states, tmp_path / "out")
    assert [row["status"] for row in rows] == made.verdicts
    for k in sorted({0, 1, 49, *made.words}):
        with warnings.catch_warnings(record=True) as heard:
            warnings.simplefilter("always")
            layout = states_of(tmp_path / "model.xml", made.states[k], {}).layout
            scene = hf.load_scene(tmp_path / "model.xml", qpos=made.states[k, 1 : 1 + layout.nq])
            single = hf.stability(scene)
        told = (single.status.value, single.reason, list(single.moving), list(single.notes))
        assert (rows[k]["status"], rows[k]["reason"], rows[k]["moving"], rows[k]["notes"]) == told
        assert rows[k]["warnings"] == list(dict.fromkeys(str(each.message) for each in heard))


def test_a_bowl_in_the_air_is_named_with_its_height(tmp_path: Path, blocks: Path) -> None:
    rows_of(blocks, raised(0.0, 0.11), tmp_path / "out", ("stability", "settle"))
    told = [row["details"] for row in hf.read_batch(tmp_path / "out").data()]
    assert told[0]["hovers"] == []
    (hovers,) = told[1]["hovers"]
    assert (hovers["body"], hovers["above"]) == ("high", "low")
    assert hovers["height"] == pytest.approx(0.11, abs=1e-9)
    assert told[0]["settled"]["moved"] == 0
    assert told[1]["settled"]["verdict"] == "unstable"  # beyond the travel


def test_a_group_in_the_air_is_as_high_as_its_lowest_body(tmp_path: Path, blocks: Path) -> None:
    both = np.array([REST])
    both[:, [2, 9]] += 0.2
    both[:, 0] = both[:, 7] = 0.7
    rows_of(blocks, both, tmp_path / "out")
    bodies = {row["body"]: row for row in hf.read_batch(tmp_path / "out").rows("bodies")}
    assert [bodies[name]["hovers"] for name in ("low", "high")] == pytest.approx([0.2, 0.2])
    assert {bodies[name]["above"] for name in ("low", "high")} == {"floor"}


@pytest.mark.parametrize(("width", "first"), [(14, 0), (26, 0), (27, 1)])
def test_rows_are_positions_with_or_without_velocities_and_time(blocks: Path, width: int, first: int) -> None:
    found = states_of(blocks, raised(0.0)[:, 1 - first : 1 - first + width], {})
    assert found.first == first
    assert [item.state for item in found.inputs().items] == [tuple(REST)]


def written(path: Path, states: Floats) -> None:
    """Write states in the format of the suffix, HDF5 as robomimic does: some states of later moments follow."""
    match path.suffix:
        case ".npy":
            np.save(path, states)
        case ".npz":
            np.savez(path, states=states, other=np.arange(3))
        case ".csv":
            np.savetxt(
                path, states, delimiter=",", header=",".join(f"s{k}" for k in range(states.shape[1])), comments=""
            )
        case _:
            h5py = pytest.importorskip("h5py")
            with h5py.File(path, "w") as file:
                for k, state in enumerate(states):
                    file[f"data/demo_{k}/states"] = np.vstack([state, state + 1, state + 2])
                file["data/demo_0/actions"] = np.zeros((3, 7))


@pytest.mark.parametrize("suffix", [".npy", ".npz", ".csv", ".hdf5"])
def test_settled_states_are_written_in_the_same_layout(tmp_path: Path, blocks: Path, suffix: str) -> None:
    states = raised(*[0.0] * 9, 0.01, 0.4)
    source, target = tmp_path / f"states{suffix}", tmp_path / f"settled{suffix}"
    written(source, states)
    given = states_of(blocks, source, {})
    hf.batch({blocks: source}, ("stability", "settle"), out=tmp_path / "out", workers=1)
    settled, left = given.fix(hf.read_batch(tmp_path / "out"), target)
    prefix = "demo_" if suffix == ".hdf5" else ""
    assert (settled, left) == ([f"{prefix}9"], [f"{prefix}10"])
    found = read_states(target)
    assert found.names == given.rows.names
    others = [0, 8, 10]
    np.testing.assert_array_equal(found.values[others], states[others])
    assert found.values[9, 1 + 9] == pytest.approx(0.13, abs=1e-5)
    assert found.values[9, 0] == 0.5
    assert found.values[9, -6:].tolist() == [0.0] * 6
    again = rows_of(blocks, target, tmp_path / "again")
    assert [row["status"] for row in again] == [STABLE] * 10 + ["unstable"]
    if suffix == ".hdf5":
        every = read_states(target, every=True)
        assert len(every.values) == 33
        assert every.names[3] == "demo_1/0"
        np.testing.assert_array_equal(every.values[28], states[9] + 1)
        assert (found.later, every.later) == (22, 0)


def test_bodies_of_other_joints_are_refused_when_settled_states_are_written(tmp_path: Path) -> None:
    slides = "".join(f'<joint type="slide" axis="{axis}"/>' for axis in ("1 0 0", "0 1 0", "0 0 1"))
    world = f'<geom name="floor" type="plane" size="1 1 1"/><body name="a" pos="0 0 .1">{slides}<joint type="ball"/>'
    text = f'<mujoco><worldbody>{world}<geom type="box" size=".1 .1 .1"/></body></worldbody></mujoco>'
    (tmp_path / "a.xml").write_text(text)
    np.save(tmp_path / "s.npy", [[0, 0, 0.01, 1, 0, 0, 0.0]])
    hf.batch({tmp_path / "a.xml": tmp_path / "s.npy"}, ("stability", "settle"), out=tmp_path / "out", workers=1)
    given = states_of(tmp_path / "a.xml", tmp_path / "s.npy", {})
    with pytest.raises(hf.HoldfastError, match="'a' moves by other joints than a free one"):
        given.fix(hf.read_batch(tmp_path / "out"), tmp_path / "f.npy")
    assert not (tmp_path / "f.npy").exists()


def test_states_that_were_answered_are_kept_and_a_changed_one_is_asked_again(tmp_path: Path, blocks: Path) -> None:
    assert hf.batch({blocks: raised(0.0, 0.11)}, out=tmp_path / "out", workers=1).asked == 2
    again = hf.batch({blocks: raised(0.0, 0.12)}, out=tmp_path / "out", workers=1)
    assert (again.asked, again.kept) == (1, 1)


def object_npy(path: Path) -> None:
    np.save(path, np.array([{"a": 1}], dtype=object), allow_pickle=True)


def torch_like(path: Path) -> None:
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("archive/data.pkl", pickle.dumps([1.0]))


def bomb(path: Path) -> None:
    """Write the header of a table of 8 TB."""
    with path.open("wb") as stream:
        header = {"descr": "<f8", "fortran_order": False, "shape": (10**6, 10**6)}
        np.lib.format.write_array_header_2_0(stream, header)


def changed(row: int, column: int, value: float) -> Floats:
    states = raised(0.0, 0.0, 0.0)
    states[row, column] = value
    return states


BAD: list[tuple[str, Any, str]] = [
    ("s.npy", raised(0.0)[:, :20], "states have 20 numbers; this model needs qpos 14, with qvel 26, with time 27"),
    ("s.npy", changed(1, 3, np.nan), "number 3 of row 1 is nan"),
    ("s.npy", changed(2, 4, 0.5), "quaternion of joint 'low' in row 2 has length 0.5"),
    ("s.npy", changed(0, 4, 0.0), "has length 0"),
    ("s.npy", np.empty((0, 27)), "is empty"),
    ("s.npy", np.empty((2, 3, 27)), r"has shape \(2, 3, 27\)"),
    ("s.npy", np.array([["a"]]), "needs numbers"),
    ("s.npy", object_npy, "holds objects, which are pickled"),
    ("s.npy", bomb, "the limit is 50,000,000"),
    ("s.npy", b"\x93NUMPY\x01\x00", "is no table of states"),
    ("s.npy", b"", "is no table of states"),
    ("s.npz", torch_like, "is a pickle"),
    ("s.npz", b"PK\x03\x04broken", "is no table of states"),
    ("s.csv", b"1,2,x\n1,2,3\n4,y,6\n", "line 3: is '4,y,6'"),
    ("s.csv", b"1,2,3\n4,5\n", "line 2: has 2 numbers, the first row 3"),
    ("s.csv", b"", "is empty"),
    ("s.csv", b"\xff\xfe", "is no table of states"),
    ("s.pruned_init", b"x", "is a pickle; pickles may run code"),
    ("s.mat", b"x", "suffix '.mat'"),
    ("missing.npy", None, "no such file of states"),
]


@pytest.mark.parametrize(("name", "content", "words"), BAD)
def test_a_bad_file_is_one_clear_error(tmp_path: Path, blocks: Path, name: str, content: Any, words: str) -> None:
    path = tmp_path / name
    if isinstance(content, np.ndarray):
        np.save(path, content)
    elif isinstance(content, bytes):
        path.write_bytes(content)
    elif content is not None:
        content(path)
    with pytest.raises(hf.HoldfastError, match=words) as told:
        hf.batch({blocks: path}, out=tmp_path / "out", workers=1)
    assert "\n" not in str(told.value)
    assert not (tmp_path / "out" / "scenes").exists()


def test_several_arrays_need_a_known_name(tmp_path: Path, blocks: Path) -> None:
    np.savez(tmp_path / "s.npz", a=raised(0.0), b=raised(0.0))
    with pytest.raises(hf.HoldfastError, match="its arrays are a, b; needs one of states, qpos, init_states"):
        states_of(blocks, tmp_path / "s.npz", {})


@pytest.mark.parametrize(
    ("scenes", "load", "words"),
    [
        (["a.xml", "b.xml"], {}, "got 2 scenes; needs the path of one MuJoCo model"),
        ("cube.yaml", {}, "needs a MuJoCo model"),
        ("blocks.xml", {"qpos": REST}, "load has 'qpos'"),
        ("none.xml", {}, "no such scene file"),
    ],
)
def test_states_need_one_model(tmp_path: Path, blocks: Path, scenes: Any, load: dict[str, Any], words: str) -> None:
    hf.save_scene(hf.shipped_scene("cube"), tmp_path / "cube.yaml")
    models = [tmp_path / each for each in scenes] if isinstance(scenes, list) else [tmp_path / scenes]
    with pytest.raises(hf.HoldfastError, match=words):
        hf.batch(dict.fromkeys(models, raised(0.0)), out=tmp_path / "out", options={"load": load}, workers=1)


def test_hostile_hdf5_is_refused(tmp_path: Path) -> None:
    h5py = pytest.importorskip("h5py")
    secret = tmp_path / "secret.hdf5"
    written(secret, raised(0.0))
    cases: dict[str, Any] = {
        "is a link": lambda file: file.create_group("data").__setitem__(
            "demo_0", h5py.ExternalLink(str(secret), "/data/demo_0")
        ),
        "lies in another file": lambda file: file.create_dataset(
            "data/demo_0/states", (1, 27), dtype="f8", external=[(str(secret), 0, 216)]
        ),
        "holds objects": lambda file: file.create_dataset("states", (1,), dtype=h5py.string_dtype()),
        "the limit is": lambda file: file.create_dataset("states", (10**7, 10**6), dtype="f8", chunks=(1, 1000)),
        "has no states": lambda file: file.create_group("other"),
        "data is empty": lambda file: file.create_group("data"),
        "has no dataset states": lambda file: file.create_group("data/demo_0"),
    }
    for words, fill in cases.items():
        path = tmp_path / "s.hdf5"
        with h5py.File(path, "w") as file:
            fill(file)
        with pytest.raises(hf.HoldfastError, match=words):
            read_states(path)
    path.write_bytes(b"\x89HDF\r\n\x1a\n" + bytes(100))
    with pytest.raises(hf.HoldfastError, match="is no HDF5 file with states"):
        read_states(path)


def test_demonstrations_are_in_the_order_of_their_numbers(tmp_path: Path) -> None:
    pytest.importorskip("h5py")
    written(tmp_path / "s.hdf5", raised(*[0.0] * 12))
    assert read_states(tmp_path / "s.hdf5").names == tuple(f"demo_{k}" for k in range(12))


def test_rows_are_told_as_the_schema_says(tmp_path: Path, blocks: Path) -> None:
    rows_of(blocks, raised(0.0, 0.11, -0.002), tmp_path / "out", ("stability", "settle"))
    whole = schema()
    for row in hf.read_batch(tmp_path / "out").data():
        jsonschema.validate(json.loads(json.dumps(row)), whole)


def test_a_single_row_is_one_state(blocks: Path) -> None:
    stream = io.BytesIO()
    np.save(stream, raised(0.0)[0])
    (blocks.parent / "s.npy").write_bytes(stream.getvalue())
    assert states_of(blocks, blocks.parent / "s.npy", {}).rows.names == ("0",)
