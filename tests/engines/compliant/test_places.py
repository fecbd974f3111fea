"""Places of contacts are worked out once for all springs and faces."""

from __future__ import annotations

import numpy as np
import pytest
from engine_scenes import shipped

import holdfast as hf
from holdfast.assembly.contact_nodes import ContactNodes, contact_nodes
from holdfast.contacts.interface import Patch
from holdfast.engines.compliant.elastic_model import Places, elastic_model, sheets_of
from holdfast.scene.shipped.blocks import at


def test_models_on_shared_places_are_those_on_new_ones() -> None:
    """Another stiffness leaves nothing behind in what is shared."""
    table = shipped("table")
    weight, shared = table.weight_wrench(), Places.of(table, 7)
    soft = np.linspace(1, 3, len(table.interfaces))
    for stiffness in (soft, None, soft):
        fresh = Places.at(table, contact_nodes(table, 49, "quadrature"))
        one, other = (elastic_model(places, weight, 0.5, stiffness) for places in (shared, fresh))
        for a, b in zip((*one._replace(runs=0), *one.runs), (*other._replace(runs=0), *other.runs), strict=True):
            np.testing.assert_array_equal(a, b)


@pytest.mark.parametrize("contacts", [[0], [1, 2], [0, 3], [0, 1, 2, 3]])
def test_sheets_with_more_nodes_at_some_contacts_are_those_of_all_nodes_together(contacts: list[int]) -> None:
    assembly = shipped("tall_table")
    some = Places(assembly, 7, tuple(contacts), 28)
    whole = Places.at(assembly, some.nodes)
    for name, one, other in zip(some.sheets._fields, some.sheets, whole.sheets, strict=True):
        np.testing.assert_allclose(one, other, rtol=0, atol=1e-12, err_msg=name)
        assert one.dtype == other.dtype
    numbers = np.bincount(some.nodes.interface)
    assert (numbers[contacts] > 400).all()
    assert (np.delete(numbers, contacts) < 60).all()


@pytest.mark.parametrize("contacts", [[0], [1], [0, 1]])
def test_axes_of_contacts_with_several_patches_are_their_own(contacts: list[int]) -> None:
    """Each of two cubes lies in a groove of the floor: two patches at right angles to each other."""
    slope = np.sqrt(0.5)
    bodies = [hf.Body("floor", hf.Box((4, 4, 0.1)), pose=at(0, 0, -0.5), fixed=True)]
    interfaces = []
    for name, x, size in (("one", 0.0, 1.0), ("two", 2.0, 0.7)):
        bodies.append(hf.Body(name, hf.Box((0.5, 0.5, 0.5)), mass=1.0, pose=at(x, 0, 0.5)))
        wall = size * np.array([[0.0, -0.2, 0], [slope, -0.2, slope], [slope, 0.2, slope], [0, 0.2, 0]])
        sides = [(wall, (-slope, 0, slope)), (wall[::-1] * (-1, 1, 1), (slope, 0, slope))]
        patches = [Patch(ring + np.array([x, 0.0, 0.0]), np.array(normal)) for ring, normal in sides]
        interfaces.append(hf.answers.Interface(("floor", name), patches=patches))
    assembly = hf.assemble(hf.Scene(bodies, 0.5), interfaces=interfaces)
    nodes = contact_nodes(assembly, 25, "quadrature", among=contacts)
    whole = contact_nodes(assembly, 25, "quadrature")
    kept = np.isin(whole.interface, contacts)
    for name in ("points", "axes", "mu", "weights", "interface", "a", "b"):
        np.testing.assert_array_equal(getattr(nodes, name), getattr(whole, name)[kept])
    assert np.sort(np.unique(whole.normals.round(9), axis=0)[:, 0]) == pytest.approx([-slope, slope])
    across = np.einsum("ix,ix->i", whole.points - [[2.0, 0, 0]] * whole.interface[:, None], whole.normals)
    np.testing.assert_allclose(across, 0, atol=1e-12, err_msg="nodes lie in the plane of their own normal")


def test_a_sheet_ends_where_the_contact_or_its_plane_or_its_axes_change() -> None:
    """Four nodes each: on one tread, on the next one, on its riser, and on another contact in the same plane."""
    square = np.array([(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (1.0, 1.0, 0.0)])
    up, along = np.eye(3)[[2, 0, 1]], np.eye(3)
    higher, riser = square + np.array([0, 0, 0.5]), square[:, [2, 0, 1]] + np.array([1, 0, 0.5])
    points = np.vstack([square, higher, riser, riser])
    axes = np.repeat([up, up, along, along], 4, axis=0)
    number = np.repeat([0, 0, 0, 1], 4)
    body = np.zeros(16, dtype=np.int64)
    nodes = ContactNodes(points, axes, np.full(16, 0.5), np.ones(16), number, body - 1, body, np.zeros(16))
    com, turn, size = np.array([[0.2, 0.3, 2.0]]), np.eye(3)[[1, 2, 0]], 2.0
    sheets = sheets_of(nodes, com, turn, size)
    assert sheets.first.tolist() == [0, 4, 8, 12, 16]
    assert sheets.interface.tolist() == [0, 0, 0, 1]
    np.testing.assert_allclose(sheets.x[:4], (square[:, 0] - 0.5) / size)
    np.testing.assert_allclose(sheets.y[:4], (square[:, 1] - 0.5) / size)
    np.testing.assert_allclose(sheets.axes[0], up @ turn.T, atol=1e-12)
    np.testing.assert_allclose(sheets.arm_b[1], turn @ ([0.5, 0.5, 0.5] - com[0]) / size, atol=1e-8)
    assert not sheets.arm_a.any()
