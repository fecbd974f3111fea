"""No array that a scene, an assembly or its contact nodes hold or hand out can be written to."""

from __future__ import annotations

import numpy as np
import pytest
from reachable import arrays, writable

import holdfast as hf
from holdfast.assembly.contact_nodes import contact_nodes
from holdfast.contacts.clipping import Piece
from holdfast.contacts.search_mesh import SearchMesh
from holdfast.geometry.cells import surface_cells
from holdfast.geometry.sweep import Swept
from holdfast.scene.shipped import shipped_scene

SCENES = ("cube", "table", "arch", "v_groove", "wedged", "tabletop")


@pytest.fixture(scope="module", params=SCENES)
def assembly(request: pytest.FixtureRequest) -> hf.answers.Assembly:
    return hf.assemble(shipped_scene(request.param))


def test_no_array_of_a_scene_or_an_assembly_takes_a_value(assembly: hf.answers.Assembly) -> None:
    assert writable(assembly, "assembly") == []
    found = [array for _, array in arrays(assembly, "assembly") if array.size]
    assert len(found) > 50
    for array in found:
        with pytest.raises(ValueError, match="read-only"):
            array[...] = array.flat[0]


def test_contact_nodes_are_read_only(assembly: hf.answers.Assembly) -> None:
    for sampling in ("hull", "quadrature"):
        nodes = contact_nodes(assembly, 12, sampling)
        assert writable(nodes, "nodes") == []
        assert writable(nodes.chosen(nodes.interface == 0), "nodes") == []


def test_what_is_made_of_a_surface_is_read_only(assembly: hf.answers.Assembly) -> None:
    body = assembly.movable[0]
    surface = body.surface_world
    cells = surface_cells(surface, body.size / 5)
    swept = Swept(surface, assembly.scene.up)
    made = (cells, cells.chosen(cells.normals[:, 2] > 0), swept, swept.front, swept.back, SearchMesh.of(body))
    assert writable(made, "made") == []


def test_patches_seen_from_the_other_body_are_read_only(assembly: hf.answers.Assembly) -> None:
    assert writable([patch.flipped() for i in assembly.interfaces for patch in i.patches], "flipped") == []


def test_what_a_caller_keeps_stays_writable_and_changes_nothing() -> None:
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    normal = np.array([0.0, 0, 1])
    patch = hf.answers.Patch(corners, normal)
    body = hf.Body("slab", hf.Box((1, 1, 1)), mass=1.0, pose=np.eye(4))
    interface = hf.answers.Interface(("slab", "floor"), corners, normal)
    corners += 5
    normal *= 0
    assert patch.area == pytest.approx(1)
    assert patch.polygon.max() == 1
    assert interface.patches[0].polygon.max() == 1
    assert body.pose is not None
    assert not body.pose.flags.writeable


def test_a_planted_writable_array_is_found() -> None:
    piece = Piece((np.zeros((3, 3)),), np.zeros(3), (0.0, 0.0))
    object.__setattr__(piece, "normal", np.zeros(3))
    assert writable({"a": [piece]}, "planted") == ["planted['a'][0].normal"]
