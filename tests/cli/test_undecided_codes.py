"""Exit codes, tables and JSON where answers are undecided although the scene stands."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest
from calling import called
from retold import REASON, retold, unknown

import holdfast as hf
from holdfast.applications import transport as transports
from holdfast.base.envelope import EXIT, verdict_of
from holdfast.cli import carrier_commands, push_commands
from holdfast.queries import map as maps

UNDECIDED, UNSTABLE, FINITE = hf.Status.UNDECIDED, hf.Status.UNSTABLE, hf.Status.FINITE
MAP = ("map", "table", "--spacing", "0.1", "--engine", "graph")
BODIES = (("leg_left", "0 "), ("leg_right", "0 ("), ("slab", "?"))
CARRIED = ("transport", "cube", "--count", "8", "--engine", "graph")


@pytest.fixture
def holdfast(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Any:
    """Call the command with the answers of maps and transport limits changed by ``change``."""

    def call(*arguments: str, change: Callable[[Any], Any] = lambda found: found) -> tuple[int, str, str]:
        monkeypatch.setattr(push_commands, "robustness_map", lambda *a, **k: change(maps.robustness_map(*a, **k)))
        monkeypatch.setattr(
            carrier_commands, "transport_limits", lambda *a, **k: change(transports.transport_limits(*a, **k))
        )
        return called(monkeypatch, capsys, *arguments)

    return call


def some(found: Any) -> Any:
    return retold(found, slice(0, 3), UNDECIDED, notes=(REASON,))


@pytest.mark.parametrize("as_json", [(), ("--json",)])
@pytest.mark.parametrize("command", [MAP, CARRIED], ids=["map", "transport"])
@pytest.mark.parametrize(("change", "code"), [(lambda found: found, 0), (some, 0), (unknown, 3)])
def test_all_undecided_is_3_although_it_stands(
    change: Any, code: int, command: tuple[str, ...], as_json: tuple[str, ...], holdfast: Any
) -> None:
    got, out, _ = holdfast(*command, *as_json, change=change)
    assert got == code
    if as_json:
        data = json.loads(out)
        undecided = data["details"]["undecided"]
        assert (data["verdict"], data["details"]["at_rest"]["status"]) == ("undecided" if code else "stable", "stable")
        assert undecided["count"] == sum(row["status"] == "undecided" for row in data["rows"])
        assert undecided["reasons"] == ([] if undecided["count"] == 0 else [REASON])
        assert (REASON in data["reason"]) == (code == 3)
    else:
        assert ("undecided (" in out) == (change in (some, unknown))


@pytest.mark.parametrize(("status", "code"), [(UNSTABLE, 1), (UNDECIDED, 3), (hf.Status.STABLE, 0)])
def test_the_verdict_comes_first(status: hf.Status, code: int) -> None:
    found = hf.robustness_map(hf.assemble(hf.shipped_scene("cube")), spacing=0.1, engine="graph")

    def ends(answers: Any, status: hf.Status) -> int:
        verdict = replace(answers.verdict, status=status)
        return EXIT[verdict_of(replace(found, answers=replace(answers, verdict=verdict)))]

    assert ends(found.answers, status) == code
    assert ends(found.answers.rows(slice(0, 0)), status) == code
    assert ends(unknown(found).answers, UNSTABLE) == 1


@pytest.mark.parametrize(
    ("reached", "proven", "code"), [(True, True, 0), (True, False, 0), (False, True, 1), (False, False, 3)]
)
def test_a_search_that_gave_up_proves_nothing(reached: bool, proven: bool, code: int) -> None:
    order = hf.disassembly_order(hf.shipped_scene("cube"), engine="graph")
    assert EXIT[verdict_of(replace(order, reached=reached, proven=proven))] == code


def test_the_table_of_a_map_tells_the_kinds_apart(holdfast: Any) -> None:
    def change(found: Any) -> Any:
        found = retold(found, found.body == "slab", UNDECIDED, notes=(REASON,))
        found = retold(found, found.body == "leg_left", UNSTABLE)
        return retold(found, found.body == "leg_right", FINITE)

    code, out, _ = holdfast(*MAP, change=change)
    assert code == 1, "something falls without a push"
    whole = " ".join(out.split())
    assert REASON in whole
    left, right, slab = (whole.index(f"{name} {shown}") for name, shown in BODIES)
    assert left < right < slab, "what is not known comes last"
    assert "falls without a push" in whole[left:right]
    assert "only balanced" in whole[right:slab]
    assert "undecided" in whole[slab:]


def test_the_table_counts_undecided_points_of_a_body(holdfast: Any) -> None:
    _, out, _ = holdfast(*MAP, change=some)
    assert "; 3 of " in " ".join(out.split())


def test_the_table_of_limits_has_no_zero_where_nothing_is_known(holdfast: Any) -> None:
    _, out, _ = holdfast(*CARRIED, change=some)
    rows = [line.split() for line in out.splitlines() if "°" in line]
    assert [row[2] for row in rows].count("?") == 1
    assert not any(row[2] == "0" for row in rows)
    whole = " ".join(out.split())
    assert f"3 of 8 undecided (37.5 %) note: {REASON}" in whole


def test_help_lists_the_exit_codes(holdfast: Any) -> None:
    code, out, _ = holdfast("--help")
    assert code == 0
    whole = " ".join(out.replace("│", " ").split())
    assert "3 undecided" in whole
    assert "130" in whole
