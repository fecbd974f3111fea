"""The command ``rest``."""

from __future__ import annotations

from typing import Any

from calling import command

rest = command("rest")


def test_a_mass_of_zero_is_refused(rest: Any) -> None:
    code, _, err = rest("cube", "--mass", "0")
    assert code == 2
    assert "mass: is 0; needs a finite number > 0" in " ".join(err.split())
