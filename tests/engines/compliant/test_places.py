"""Places of contacts are worked out once for all springs and faces."""

from __future__ import annotations

import numpy as np
import pytest
from compliant_scenes import shipped

import holdfast as hf
from holdfast.assembly.nodes import contact_nodes
from holdfast.engines.compliant.model import elastic_model
from holdfast.engines.compliant.places import Places
from holdfast.queries.request import push_columns


def test_they_are_kept_with_the_assembly() -> None:
    table = shipped("table")
    known = Places.of(table, 7)
    assert Places.of(table, 7) is known
    assert len(Places.of(table, 14).nodes) > 3 * len(known.nodes)
    edited = table.without("slab")
    assert {*np.unique(Places.of(edited, 7).nodes.interface).tolist()} == set(range(len(edited.interfaces)))
    assert Places.of(table, 7) is known


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
    some = Places.with_more(assembly, 7, np.array(contacts), 28)
    whole = Places.at(assembly, some.nodes)
    for name, one, other in zip(some.sheets._fields, some.sheets, whole.sheets, strict=True):
        np.testing.assert_allclose(one, other, rtol=0, atol=1e-12, err_msg=name)
        assert one.dtype == other.dtype
    numbers = np.bincount(some.nodes.interface)
    assert (numbers[contacts] > 400).all()
    assert (np.delete(numbers, contacts) < 60).all()


def test_a_grid_that_only_tells_the_error_is_not_brought_to_rest() -> None:
    """Its load at the displacement of a peak does not depend on how it rests; a path there begins at rest."""
    cube = shipped("cube")
    state = hf.Compliant().prepare(cube)
    side = cube.com - [[0.05, 0.0, 0.0]]
    W = push_columns(cube, 0, side, np.array([[1.0, 0.0, 0.0]]))
    found = state.load_factor(W)
    assert 0 < found.lower[0] < found.force[0] < np.inf
    finer = state.grid.finer
    assert not finer._rest
    paths = finer.paths(W)
    assert len(finer._rest) == 1
    assert paths.peak[0] == pytest.approx(found.force[0], rel=0.02)
    assert finer.settled is finer.settled
