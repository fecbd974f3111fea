"""Every amendment, and every rule of one, has a case whose answers change without it; what no case needs goes."""

from __future__ import annotations

from pathlib import Path

import pytest

from bench.checkout import CASES
from bench.suites.amendments import NEEDED_BY, rules, sources, without
from holdfast.engines.compliant.engine import AMENDMENTS

ROOT = Path(__file__).parents[2]
TESTS = {rule: place for rule, place in NEEDED_BY.items() if place.startswith("tests/")}


def test_every_rule_names_what_needs_it() -> None:
    assert set(NEEDED_BY) == set(rules())
    assert {kind.name for kind in AMENDMENTS} <= set(rules())
    shared = {place for place in NEEDED_BY.values() if place.startswith("jam ")}  # not in every checkout
    assert {place for rule, place in NEEDED_BY.items() if rule not in TESTS} - shared <= set(sources())


@pytest.mark.parametrize("place", TESTS.values(), ids=TESTS)
def test_a_rule_that_a_test_needs_has_that_test(place: str) -> None:
    path, name = place.split("::")
    assert f"def {name}(" in (ROOT / path).read_text(encoding="utf-8")


@pytest.mark.parametrize("case", sorted({place for rule, place in NEEDED_BY.items() if rule not in TESTS}))
def test_a_case_needs_its_rules(case: str) -> None:
    if case.startswith("jam") and not (CASES / "jams").is_dir():
        pytest.skip("the shared cases are not here")
    wanted = [rule for rule, place in NEEDED_BY.items() if place == case]
    assert [rule for rule, changed in without(case, wanted).items() if not changed] == []
