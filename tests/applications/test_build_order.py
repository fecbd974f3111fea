"""Orders in which everything stands after each step, beside all orders there are; and what each state withstands."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

import holdfast as hf
from holdfast.applications.disassembly.removal import Exits
from holdfast.scene.shipped import shipped_scene
from holdfast.scene.shipped.blocks import box, floor

UP = np.array([0, 0, 1.0])


def possible(assembly: hf.answers.Assembly) -> set[tuple[str, ...]]:
    """All orders whose states stand and in which nothing is in the way down, by brute force."""
    names = [body.name for body in assembly.movable]
    exits = Exits(assembly, UP)
    stands: dict[frozenset[str], bool] = {}

    def standing(there: frozenset[str]) -> bool:
        if there not in stands:
            gone = [name for name in names if name not in there]
            stands[there] = hf.stability(assembly.without(gone)).status is hf.Status.STABLE
        return stands[there]

    found = set()
    for order in itertools.permutations(names):
        prefixes = [frozenset(order[: k + 1]) for k in range(len(order))]
        if all(not exits.blockers(name, there) for name, there in zip(order, prefixes, strict=True)) and all(
            standing(there) for there in prefixes
        ):
            found.add(order)
    return found


@pytest.mark.parametrize("name", ["stack", "table", "wall2x2", "slope_two", "cantilever", "arch", "wedged_floor"])
def test_an_order_is_one_of_all_and_none_means_that_there_is_none(name: str) -> None:
    assembly = hf.assemble(shipped_scene(name))
    found, orders = hf.build_order(assembly, pushes=0), possible(assembly)
    assert found.reached == bool(orders)
    assert found.proven
    if found.reached:
        assert found.order in orders
        assert (found.first, found.stuck) == ((), ())


def test_an_arch_needs_centering() -> None:
    found = hf.build_order(shipped_scene("arch"), pushes=0)
    assert found.order == ()
    assert found.first == tuple(f"v{k}" for k in range(1, 6))
    assert {removal.body for removal in found.stuck} == set(found.first)
    assert all("would move" in removal.reason for removal in found.stuck)


def test_what_stands_on_the_arch_is_built_on_it_later() -> None:
    scene = shipped_scene("arch")
    low = scene.body("v3").surface_world.vertices[:, 2].max()
    crate = box("crate", (0.05, 0.05, 0.05), 0.1, (0, 0, low + 0.025))
    found = hf.build_order(hf.Scene([*scene.bodies, crate], scene.friction), pushes=0)
    assert (found.order, found.reached) == (("crate",), False)
    assert "crate" not in found.first


def test_what_could_be_clamped_can_still_be_put_in() -> None:
    """Between two walls: engine limit cannot tell whether they let go of it, but nothing clamps what is set down."""
    scene = shipped_scene("wedged_floor")
    assert not hf.disassembly_order(scene, engine="limit").reached
    assert hf.build_order(scene, engine="limit", pushes=0).order == ("cube",)


def test_a_way_in_from_the_side_is_pulled_as_a_way_out() -> None:
    """Pushed in sideways over a loose plate the block might drag it: sideways, a building is a removal reversed."""
    scene = hf.Scene(
        [floor(), box("plate", (0.3, 0.3, 0.01), 0.5, (0, 0, 0.005)), box("block", (0.1, 0.1, 0.1), 1, (0, 0, 0.06))],
        0.5,
    )
    found = hf.build_order(scene, lift=(1, 0, 0), pushes=0)
    assert found.order == hf.disassembly_order(scene, lift=(1, 0, 0)).assembly_order


def test_every_state_is_pushed_where_it_is_weakest() -> None:
    """A column of 3: no point of a map of the body put in and of what it touches is much weaker, at the same spacing.

    What lies further below was pushed when it was touched last.
    """
    assembly = hf.assemble(shipped_scene("stack"))
    found = hf.build_order(assembly, pushes=100)
    assert found.order == ("cube1", "cube2", "cube3")
    for k, step in enumerate(found.steps):
        state = assembly.without(list(found.order[k + 1 :]))
        near = found.order[max(k - 1, 0) : k + 1]
        spacing = np.sqrt(sum(body.surface_world.area for body in state.movable) / 100)
        told = hf.robustness_map(state, near, spacing=spacing, accuracy=0).weakest()
        assert step.weakest is not None
        assert 0.97 * step.weakest.force <= told.force
        if step.weakest.body in near:
            assert told.force <= step.weakest.force * (1 + 1e-3)
    assert found.least is found.steps[int(np.argmin(found.force))]
    assert found.force[0] == pytest.approx(9.81 * 0.05 / 0.1 * 0.6, rel=0.1)  # tips or slides near its upper edge


def test_what_does_not_stand_is_not_built() -> None:
    with pytest.raises(hf.errors.UnstableError, match="does not stand"):
        hf.build_order(hf.Scene([floor(), box("cube", (0.1, 0.1, 0.1), 1, (0, 0, 0.5))], 0.5))


def test_a_weak_body_is_told_until_something_beside_it_changes() -> None:
    """A thin post beside a stack: it is the weakest of every state, though what is put in does not touch it."""
    post = box("post", (0.02, 0.02, 0.2), 0.1, (0.4, 0, 0.1))
    scene = shipped_scene("stack")
    found = hf.build_order(hf.Scene([*scene.bodies, post], scene.friction), pushes=40)
    since = found.order.index("post")
    assert all(step.weakest is not None and step.weakest.body == "post" for step in found.steps[since:])
    assert found.force[since:] == pytest.approx(0.1 * 9.81 * 0.01 / 0.2, rel=0.2)  # tips about its foot
