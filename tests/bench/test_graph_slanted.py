"""The suite that compares ``graph`` with the certain bound of ``limit``: its counting, and the push that began it."""

from __future__ import annotations

import io
import math

import numpy as np
import pytest

import holdfast as hf
from bench.scenes.random_assemblies import FAMILIES, standing
from bench.scenes.random_pushes import columns, random_pushes
from bench.suites import graph_slanted
from holdfast.scene.shipped import shipped_scene

INF = math.inf


def test_graph_promises_six_times_what_can_hold_on_a_slanted_push() -> None:
    """Both legs turn about their feet at rate w: the slab moves by 0.2 w along x and rises by 0.05 w."""
    along, up = 0.3642, -0.9231
    racking = (2 * 9.81 * 0.05 + 2 * 9.81 * 0.025) / (0.2 * along + 0.05 * up)
    assembly = hf.assemble(shipped_scene("table"))
    push = (assembly, "slab", (0.075, 0.025, 0.25), (along, 0.1233, up))
    graph, limit = (hf.robustness(*push, engine=engine) for engine in ("graph", "limit"))
    assert limit.upper_bound is hf.answers.Bound.PROVED
    assert limit.upper[0] == pytest.approx(racking, rel=1e-4)
    assert graph.force[0] > 5 * limit.upper[0]


def test_where_graph_is_worst_the_load_path_ends_at_the_bound() -> None:
    """Engine ``compliant`` follows a load path and knows no bound: it decides which of the two is wrong."""
    rng = np.random.default_rng(0)
    assembly = standing(FAMILIES["leaning"], rng)
    pushes = random_pushes(assembly, rng, 60, slant=60)
    W = columns(assembly, pushes)
    upper = hf.Limit().prepare(assembly).load_factor(W).upper
    ratio = hf.Graph().prepare(assembly).load_factor(W).force / upper
    worst = int(np.argmax(ratio))
    held = hf.robustness(assembly, *pushes[worst])
    assert ratio[worst] > 100
    assert held.force[0] == pytest.approx(upper[worst], rel=0.01)


def test_answers_are_counted_against_the_bounds() -> None:
    force = np.array([10.0, 10.5, 40.0, 4.0, INF, INF, 9.0, 10.0 * (1 + 1e-9)])
    lower = np.array([9.9, 9.9, 9.9, 9.9, 9.9, INF, INF, 9.9])
    upper = np.array([10.0, 10.0, 10.0, 10.0, 10.0, INF, INF, 10.0])
    row = graph_slanted.counted("try", force, lower, upper)
    assert row["pushes"] == 8
    assert row["bounded"] == 6
    assert row["above"] == 3  # 10.5, 40 and inf
    assert row["above by a tenth"] == 2
    assert row["infinite"] == 1
    assert row["below half"] == 1  # 4 < 9.9 / 2
    assert graph_slanted.share(row, "above") == pytest.approx(50)
    assert row["finite where limit is infinite"] == 1
    assert row["worst"] == pytest.approx(4)
    assert (row["5 %"], row["95 %"]) == (pytest.approx(0.4), INF)


def test_without_a_bounded_push_there_is_nothing_to_compare() -> None:
    row = graph_slanted.counted("try", np.array([INF]), np.array([INF]), np.array([INF]))
    assert (row["pushes"], row["bounded"], row["above"], row["below half"]) == (1, 0, 0, 0)
    assert "worst" not in row


def test_families_are_summed_up_by_the_number_of_their_bounded_pushes() -> None:
    one, two = (np.full(n, 10.0) for n in (8, 2))
    rows = [
        graph_slanted.counted("a, slanted", np.where(np.arange(8) < 2, 30.0, 10.0), one, one),
        graph_slanted.counted("b, slanted", 1.5 * two, two, two),
        graph_slanted.counted("b, straight", 50 * two, two, two),
        graph_slanted.counted("c, slanted", np.array([INF]), np.array([INF]), np.array([INF])),
    ]
    found = graph_slanted.total(rows, "slanted")
    assert (found["pushes"], found["bounded"], found["above"], found["worst"]) == (11, 10, 4, 3.0)
    assert graph_slanted.share(found, "above") == pytest.approx(40)
    assert "| all, slanted | 11 | 10 | " in graph_slanted.written(rows)


def test_a_family_is_asked_drawn_and_written(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(graph_slanted, "ASSEMBLIES", 2)
    monkeypatch.setattr(graph_slanted, "PUSHES", 4)
    rows = graph_slanted.family_rows("table")
    assert [row["case"] for row in rows] == ["table, straight", "table, slanted"]
    assert all(row["pushes"] + row["undecided"] == 8 for row in rows)
    assert rows == graph_slanted.family_rows("table")  # seeded
    picture = io.BytesIO()
    graph_slanted.plot(rows, picture)
    assert picture.getvalue().startswith(b"\x89PNG")
