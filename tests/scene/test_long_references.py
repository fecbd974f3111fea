"""Files that refer to others by names longer than any file has: one told error, by every format."""

from __future__ import annotations

from pathlib import Path

import pytest

import holdfast as hf

LONG = "9" * 5000
SDF = '<sdf version="1.9"><world name="w"><include><uri>{}</uri></include></world></sdf>'
MESH = '<collision name="c"><geometry><mesh><uri>{}</uri></mesh></geometry></collision>'
LINK = '<link name="b"><inertial><mass value="1"/></inertial><collision><geometry><mesh filename="{}"/></geometry>'
CASES = {
    "included.sdf": SDF.format(LONG),
    "model.sdf": SDF.format(f"model://{LONG}"),
    "mesh.sdf": f'<sdf version="1.9"><model name="m"><link name="l">{MESH.format(LONG)}</link></model></sdf>',
    "mesh.urdf": f'<robot name="t">{LINK.format(LONG)}</collision></link></robot>',
    "package.urdf": f'<robot name="t">{LINK.format(f"package://{LONG}/x.stl")}</collision></link></robot>',
    "mesh.xml": f'<mujoco><asset><mesh name="m" file="{LONG}"/></asset><worldbody/></mujoco>',
    "include.xml": f'<mujoco><include file="{LONG}"/></mujoco>',
    "buffer.gltf": f'{{"asset": {{"version": "2.0"}}, "buffers": [{{"uri": "{LONG}", "byteLength": 4}}]}}',
    "mesh.yaml": "format: holdfast-scene/1\nfriction: 1\n"
    f'bodies: [{{name: a, fixed: true, shape: {{type: mesh, file: "{LONG}"}}}}]',
}


@pytest.mark.parametrize("name", CASES)
def test_names_that_are_too_long_are_told(name: str, tmp_path: Path) -> None:
    (tmp_path / name).write_text(CASES[name])
    options = {"friction": 0.5} if name.endswith((".sdf", ".urdf", ".gltf")) else {}
    with pytest.raises(hf.HoldfastError) as caught:
        hf.load_scene(tmp_path / name, **options)
    assert name in str(caught.value)
    assert len(str(caught.value)) < 2000
