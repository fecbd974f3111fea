"""Small files that ask for much: each ends in one clear error, or is read, in a worker with 30 s and 3 GB."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import holdfast as hf
from holdfast.base.borders.supervisor import Limits, Supervisor
from holdfast.base.borders.worker import DONE

PART = (
    '<?xml version="1.0"?><sdf version="1.9"><model name="m"><link name="l">{}<inertial><mass>1</mass></inertial>'
    '<collision name="c"><geometry>{}</geometry></collision></link>{}</model></sdf>'
)
BOX = "<box><size>.1 .1 .1</size></box>"
MODEL = '<mujoco>{}<worldbody><geom type="plane" size="1 1 1"/>{}</worldbody></mujoco>'
MADE = MODEL.format(
    '<asset><mesh name="m" builtin="{}" params="{}"/></asset>', '<body><freejoint/><geom type="mesh" mesh="m"/></body>'
)
GRID = '<flexcomp name="f" type="{}" count="{}" spacing=".1 .1 .1" mass="1" dim="3"/>'
CROSSING = "".join(f"<point>{(i * 7919) % 1000} {(i * 104729) % 1000}</point>" for i in range(20_000))
STAR = f"<polyline><height>1</height>{CROSSING}</polyline>"
FRAMES = "".join(
    f'<frame name="f{k}" attached_to="{f"f{k - 1}" if k else "__model__"}"><pose>0 0 .1 0 0 0</pose></frame>'
    for k in range(10_000)
)
LAST = '<pose relative_to="f9999"/>'


def directives(*lines: str) -> str:
    return "directives:\n" + "".join(f"- {line}\n" for line in lines)


def laughing(levels: int) -> str:
    """Ten references to ten references ...: 10 ** levels cubes."""
    prims = "".join(
        f'def Xform "p{k}"\n{{\n' + "".join(f'def "x{j}" (references=</p{k + 1}>)\n{{\n}}\n' for j in range(10)) + "}\n"
        for k in range(levels)
    )
    return f'#usda 1.0\n(\ndefaultPrim="p0"\n)\n{prims}def Cube "p{levels}"\n{{\n}}\n'


def referring(count: int) -> str:
    return "#usda 1.0\n(\n)\n" + "".join(f'def "a{k}" (references=</a{k + 1}>)\n{{\n}}\n' for k in range(count))


OPTIONS: dict[str, dict[str, Any]] = {
    ".csv": {"friction": 0.5},
    ".scene": {"friction": 0.5, "density": 100, "floor": True},
    ".mcap": {"friction": 0.5, "density": 100},
    ".sdf": {"floor": True},
    ".yaml": {"floor": True},
    ".usda": {"friction": 0.5, "floor": True},
}
HOSTILE: dict[str, tuple[str, str, str]] = {  # the name of the file, its content, and what is said
    "cone": ("a.xml", MADE.format("cone", "20000000 1"), "more than 20,000 corners of meshes and grids"),
    "supersphere": ("a.xml", MADE.format("supersphere", "30000 1 1"), "more than 20,000 corners"),
    "plate": ("a.xml", MADE.format("plate", "3000 3000"), "more than 20,000 corners"),
    "grid": ("a.xml", MODEL.format("", GRID.format("grid", "2000 2000 2000")), "more than 20,000 corners"),
    "box": ("a.xml", MODEL.format("", GRID.format("box", "3000 3000 3000")), "more than 20,000 corners"),
    "bodies": ("a.xml", MODEL.format("", "<body>" * 10_000 + "</body>" * 10_000), "nested too deeply"),
    "laughs": ("a.usda", laughing(7), "too many prims; the limit is 200,000"),
    "references": ("a.usda", referring(10_000), "nested too deeply; the limit is 200 references"),
    "prims": ("a.usda", "#usda 1.0\n" + 'def "a" {\n' * 10_000 + "}" * 10_000, "a.usda"),
    "outline": ("a.sdf", PART.format("", STAR, ""), "has 20,000 points; needs three and more, up to 1,000"),
    "frames": ("a.sdf", PART.format(LAST, BOX, FRAMES), "a pose behind too many frames"),
    "columns": ("a.csv", ",".join(f"c{k}" for k in range(500_000)) + "\n", "too many columns; the limit is 1,000"),
    "digits": ("a.scene", f"n\n* a\n0 0 0\n0 0 0 1\n{'9' * 5000}\n", "needs a whole number"),
    "no directive": ("a.dmd.yaml", directives(*["add_model_instance: {name: f}"] * 140_000), "characters of YAML; the"),
    "added": ("a.dmd.yaml", directives(*["add_directives: {file: big.dmd.yaml}"] * 900), "bytes of YAML in all"),
    "bag": ("a.mcap", "\x89MCAP0\r\n" + "\x03" + "\xff" * 200, "a.mcap: cannot be read"),
}


def tried(given: tuple[str, dict[str, Any]], tell: object) -> str:
    path, options = given
    try:
        scene = hf.load_scene(path, **options)
    except hf.HoldfastError as error:
        return str(error)
    return f"{len(scene.bodies)} bodies"


@pytest.fixture(scope="module")
def asked() -> Iterator[Callable[[Path], str]]:
    here = [str(Path(__file__).parent)]
    with Supervisor("test_hostile_inputs:tried", limits=Limits(30, 3000), folders=here) as supervisor:

        def ask(path: Path) -> str:
            reply = supervisor.ask((str(path), OPTIONS.get(path.suffix, {})))
            assert reply.outcome == DONE, reply.problem
            return str(reply.value)

        yield ask


@pytest.mark.parametrize("name", HOSTILE)
def test_what_asks_for_much_is_one_clear_error(name: str, asked: Callable[[Path], str], tmp_path: Path) -> None:
    file, content, said = HOSTILE[name]
    needs = {".xml": "mujoco", ".usda": "pxr", ".mcap": "rosbags"}.get(Path(file).suffix)
    if needs is not None:
        pytest.importorskip(needs)
    (tmp_path / "big.dmd.yaml").write_text(directives(*["add_model_instance: {name: f}"] * 50_000))
    (tmp_path / file).write_text(content, encoding="latin-1")
    found = asked(tmp_path / file)
    assert said in found
    assert file in found
    assert "\n" not in found


def chained(count: int, order: list[int]) -> str:
    """Models m0, m1, ... each 0.2 m above the next, the last one above the world, written in this order."""
    above = [f"m{k + 1}::l" if k < count - 1 else "world" for k in range(count)]
    return directives(
        *(
            f"add_model: {{name: m{k}, file: part.sdf, default_free_body_pose: "
            f"{{l: {{base_frame: '{above[k]}', translation: [0, 0, 0.2]}}}}}}"
            for k in order
        )
    )


def test_a_chain_of_poses_is_read_in_any_order(asked: Callable[[Path], str], tmp_path: Path) -> None:
    (tmp_path / "part.sdf").write_text(PART.format("", BOX, ""))
    (tmp_path / "long.dmd.yaml").write_text(chained(1300, list(range(1300))))
    assert asked(tmp_path / "long.dmd.yaml") == "1301 bodies"
    for order in (list(range(9)), list(range(9))[::-1], [4, 7, 0, 1, 8, 6, 2, 5, 3]):
        (tmp_path / "short.dmd.yaml").write_text(chained(9, order))
        scene = hf.load_scene(tmp_path / "short.dmd.yaml", floor=True)
        heights = [scene.body(f"m{k}").pose[2, 3] for k in range(9)]
        np.testing.assert_allclose(heights, 0.2 * np.arange(9, 0, -1), atol=1e-12)


def test_what_a_library_makes_is_read_in_a_process_with_limits(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A small one is read; where the limit is too low for it, that is the error, and this process lives on."""
    pytest.importorskip("mujoco")
    from holdfast.scene.formats.mjcf import mjcf_guard

    (tmp_path / "a.xml").write_text(MADE.format("supersphere", "10 1 1"))
    scene = hf.load_scene(tmp_path / "a.xml")
    size = np.ptp(scene.movable[0].surface_world.vertices, axis=0)
    assert (size <= 2 + 1e-9).all()
    assert (size > 1.5).all()
    with pytest.raises(hf.HoldfastError, match="qpos"):
        hf.load_scene(tmp_path / "a.xml", qpos=[1.0])
    monkeypatch.setattr(mjcf_guard, "LIMITS", Limits(seconds=30, megabytes=0.01))
    with pytest.raises(hf.errors.SceneError, match=r"a\.xml: cannot be read with 0 MB and 30 s"):
        hf.load_scene(tmp_path / "a.xml")


def test_a_grip_of_very_many_points_is_refused() -> None:
    points, normals = np.zeros((200_000, 3)), np.tile([1.0, 0, 0], (200_000, 1))
    with pytest.raises(hf.errors.SceneError, match=r"grip of 'b': has 200,000 points; the limit is 10,000"):
        hf.Grip("b", points, normals, 0.5)
