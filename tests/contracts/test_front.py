"""One small front: which names ``holdfast`` shows, where the others are, and what is said of a name that moved."""

from __future__ import annotations

from types import ModuleType

import pytest
from public_api import MODULES

import holdfast as hf

MOST = 60  # of the third plan, when all of it is there
PLANNED = """
    Scene Body Friction Box Cylinder Sphere Capsule Ellipsoid HalfSpace Mesh Compound Part Load Imperfect Strap Profile
    pose Status HoldfastError Compliant Limit Graph
    load_scene save_scene from_mujoco from_newton from_pybullet from_trimesh shipped_scene
    assemble settle stability robustness robustness_map robustness_under friction_from
    stability_of_poses robustness_of_poses load_factor transport_limits transport_under carry
    plan_placement place_all Where Search can_remove disassembly_order build_order safe_pushes
    resting_poses firmer Monitor batch read_batch load_answer view log_to_rerun Hold Grip
"""  # of the third plan, what can be done today


def test_holdfast_shows_what_is_planned_and_nothing_else() -> None:
    assert sorted(PLANNED.split()) == sorted(hf.__all__)
    assert len(hf.__all__) <= MOST


@pytest.mark.parametrize("module", MODULES, ids=lambda module: module.__name__)
def test_every_name_is_found_and_listed(module: ModuleType) -> None:
    assert set(module.__all__) <= set(dir(module))
    for name in module.__all__:
        assert getattr(module, name) is not None


def test_every_name_is_in_one_module() -> None:
    names = [name for module in MODULES for name in module.__all__]
    assert sorted(set(names)) == sorted(names)


@pytest.mark.parametrize(
    ("name", "place"),
    [
        ("Assembly", "holdfast.answers.Assembly"),
        ("SceneError", "holdfast.errors.SceneError"),
        ("worst_case", "holdfast.sets.worst_case"),
        ("register_engine", "holdfast.plugins.register_engine"),
        ("Uncertain", "holdfast.sets.Uncertain"),
        ("from_sapien", "holdfast.readers.from_sapien"),
        ("tilted", "holdfast.Scene.tilted"),
        ("horizontal_directions", "holdfast.Scene.horizontal_directions"),
        ("tied", "holdfast.Strap.tied"),
    ],
)
def test_a_name_that_moved_is_told_with_its_place(name: str, place: str) -> None:
    with pytest.raises(AttributeError, match=rf"module 'holdfast' has no attribute '{name}'; it is {place}$"):
        getattr(hf, name)


def test_a_misspelt_name_is_told_with_the_nearest_one() -> None:
    with pytest.raises(AttributeError, match="'holdfast' has no attribute 'asemble'; did you mean 'assemble'"):
        hf.asemble  # noqa: B018
    with pytest.raises(AttributeError, match=r"'holdfast\.answers' has no attribute 'Robustnes'; did you mean 'Robust"):
        hf.answers.Robustnes  # noqa: B018
