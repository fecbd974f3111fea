"""The map in portions: in the end it is the map of one question, and what was computed stays."""

from __future__ import annotations

import numpy as np
import pytest

import holdfast as hf
from holdfast.base.errors import HoldfastError, SceneError
from holdfast.base.progress import listening
from holdfast.drawing import colours
from holdfast.engines.answers import Claim
from holdfast.live import scenery, window_model
from holdfast.live.scenery import MAP
from holdfast.live.window_model import Portions, ViewModel
from holdfast.queries.request import engine_of
from holdfast.scene.shipped.blocks import box, floor

SPACING = 0.05


def cubes() -> hf.answers.Assembly:
    """A small, a large and a middle cube, the last one on the large one."""
    bodies = [
        box("small", (0.1, 0.1, 0.1), 1.0, (0.0, 0.0, 0.05)),
        box("large", (0.4, 0.4, 0.4), 9.0, (0.0, 0.5, 0.2)),
        box("middle", (0.2, 0.2, 0.2), 2.0, (0.05, 0.5, 0.5)),
    ]
    return hf.assemble(hf.Scene([floor(3.0), *bodies], friction=0.5))


@pytest.fixture
def rounds(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every map comes in rounds, also one of few points."""
    monkeypatch.setattr(window_model, "FEW", 0)


@pytest.mark.parametrize("engine", ["graph", "limit", "compliant"])
@pytest.mark.usefixtures("rounds")
def test_in_the_end_it_is_the_map_of_one_question(engine: str) -> None:
    assembly = cubes()
    found = Portions(assembly, engine_of(engine), SPACING)
    while not found.done:
        found.go_on("small")
    expected = hf.robustness_map(assembly, spacing=SPACING, engine=engine)
    assert found.map.body.tolist() == expected.body.tolist()
    np.testing.assert_array_equal(found.map.points, expected.points)
    np.testing.assert_array_equal(found.map.normals, expected.normals)
    for column in ("force", "lower", "upper"):
        np.testing.assert_allclose(getattr(found.map, column), getattr(expected, column), rtol=1e-6, atol=1e-6)
    assert found.map.status.tolist() == expected.status.tolist()
    assert found.map.moving.tolist() == expected.moving.tolist()
    assert found.map.verdict.status is expected.verdict.status
    assert {name: len(c.points) for name, c in found.map.hidden.items()} == {
        name: len(c.points) for name, c in expected.hidden.items()
    }


@pytest.mark.parametrize(
    ("first", "order"), [(None, ["large", "middle", "small"]), ("small", ["small", "large", "middle"])]
)
@pytest.mark.usefixtures("rounds")
def test_every_round_goes_from_the_chosen_body_and_the_largest_to_the_smallest(
    first: str | None, order: list[str]
) -> None:
    found = Portions(cubes(), engine_of("graph"), SPACING)
    asked = []
    while not found.done:
        before = dict(found._parts)
        found.go_on(first)
        asked += [(part.spacing, name) for name, part in found._parts.items() if before.get(name) is not part]
    assert asked == [(pytest.approx(multiple * SPACING), name) for multiple in (4, 2, 1) for name in order]


def test_few_points_come_in_one_round() -> None:
    found = Portions(cubes(), engine_of("graph"), SPACING)
    for _ in cubes().movable:
        assert not found.done
        found.go_on()
    assert found.done


@pytest.mark.usefixtures("rounds")
def test_what_is_stopped_loses_one_portion_alone() -> None:
    found = Portions(cubes(), engine_of("limit"), SPACING)
    found.go_on()
    found.go_on()

    def stop(*_: object) -> None:
        raise InterruptedError

    with listening(stop), pytest.raises(InterruptedError):
        found.go_on()
    assert set(found.map.cells) == {"large", "middle"}
    found.go_on()
    assert set(found.map.cells) == {"small", "large", "middle"}


@pytest.mark.usefixtures("rounds")
def test_a_part_of_a_map_is_shown_with_its_claim_and_the_rest_as_not_asked() -> None:
    model = ViewModel(cubes(), engine="limit", spacing=SPACING)
    model.ask_verdict()
    pale = scenery.group_colours(model)
    model.ask_map()
    rgb = {body.name: body.rgb for body in scenery.bodies(model, MAP)}
    assert np.unique(rgb["small"], axis=0) == pytest.approx(np.array([pale["small"]]))
    assert np.unique(rgb["floor"], axis=0) == pytest.approx(np.array([colours.FIXED]))
    assert not any(np.allclose(row, pale["large"]) for row in rgb["large"])
    text = scenery.legend_html(model, MAP)
    assert f"engine limit ({Claim.EXISTS.words})" in text
    assert "1 of 3 bodies at points 0.2 m apart, 2 pale ones not asked yet" in text
    while not model.mapped:
        model.ask_map()
    text = scenery.legend_html(model, MAP)
    assert f"engine limit ({Claim.EXISTS.words}), {len(model.map.force):,} inward pushes<" in text  # type: ignore[union-attr]


def test_too_many_points_and_nothing_to_map_are_told() -> None:
    fine = np.sqrt(1.3 / 2_000_000) / 2
    with pytest.raises(SceneError, match="points on"):
        Portions(cubes(), engine_of("graph"), fine)
    with pytest.raises(HoldfastError, match="needs a movable body"):
        Portions(hf.assemble(hf.Scene([floor()], friction=0.5)), engine_of("graph"), SPACING).go_on()
