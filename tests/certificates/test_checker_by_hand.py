"""The checker on certificates that were written by hand, with triangles of 3, 4 and 5: all borders are exact numbers.

A body of 1 kg under 4 m/s² touches the floor at its centre of mass, with a friction of 3/4: the floor can push it with
(3, 0, 4) N and not with more along x, and what slides along x rises by 3/4 of its way along the cone.
"""

from __future__ import annotations

import json
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from holdfast.certificates.verify_certificate import ExactCertificate, RefusedError, claims_of, in_cone, unbraked

FORM = {"format": "holdfast-certificate/2", "units": "m, kg, s, N, N m", "standing": [], "resting holds": []}


def point(first: str, second: str, mu: str = "3/4", at: tuple[str, str, str] = ("0", "0", "0")) -> dict[str, Any]:
    return {"between": [first, second], "mu": mu, "points": [{"at": list(at), "normal": ["0", "0", "2"]}]}


def block(name: str = "a", height: str = "0") -> dict[str, Any]:
    return {"name": name, "mass": "1", "centre": ["0", "0", height]}


def file(rest: list[list[str]], **other: Any) -> dict[str, Any]:
    plain = {
        "gravity": ["0", "0", "-4"], "acceleration": ["0", "0", "0"], "fixed": ["floor"], "bodies": [block()],
        "contacts": [point("floor", "a")], "rest": rest, "proofs": [],
    }  # fmt: skip
    return {**FORM, **plain, **other}


def wrench(*force: str, torque: tuple[str, str, str] = ("0", "0", "0")) -> dict[str, Any]:
    return {"body": "a", "force": list(force), "torque": list(torque)}


def stands(data: dict[str, Any]) -> bool:
    try:
        ExactCertificate(data).proved({"kind": "stands", "claim": ""})
    except RefusedError as why:
        if "friction cone" in str(why) or "do not balance" in str(why):
            return False
        raise
    return True


def test_the_cone_is_that_of_friction() -> None:
    pushed = {"standing": [wrench("-3", "0", "0")]}
    assert stands(file([["3", "0", "4"]], **pushed))
    for mu in ("0.749999999999", "0.5", "0.4", "0"):
        assert not stands(file([["3", "0", "4"]], contacts=[point("floor", "a", mu)], **pushed)), mu
    aslant = {"standing": [wrench("-1.8", "-2.4", "0")]}  # likewise 3 N, in another direction
    assert stands(file([["1.8", "2.4", "4"]], **aslant))
    assert not stands(file([["1.8", "2.4", "4"]], contacts=[point("floor", "a", "0.749")], **aslant))


def test_contacts_do_not_pull() -> None:
    assert stands(file([["0", "0", "4"]]))
    assert not stands(file([["0", "0", "-4"]], gravity=["0", "0", "4"]))


def test_the_support_takes_what_stands_on_it_along() -> None:
    """At 3 m/s² along x the floor has to push the body along x, not back."""
    assert stands(file([["3", "0", "4"]], acceleration=["3", "0", "0"]))
    assert not stands(file([["-3", "0", "4"]], acceleration=["3", "0", "0"]))
    assert not stands(file([["3", "0", "4"]]))


@pytest.mark.parametrize(("below", "right"), [("8", True), ("4", False), ("0", False), ("12", False)])
def test_what_carries_is_pushed_down(below: str, right: bool) -> None:
    """Of two bodies on each other the lower one carries both: 8 N below it and 4 N above it."""
    two = {"bodies": [block("a"), block("b")], "contacts": [point("floor", "a"), point("a", "b")]}
    assert stands(file([["0", "0", below], ["0", "0", "4"]], **two)) == right


def test_forces_turn_about_the_centre_of_mass() -> None:
    """A floor 1 m beside and 2 m below the centre pushes with 4 N up: 4 N m about -y are left for a standing torque."""
    beside = {"contacts": [point("floor", "a", at=("1", "0", "0"))], "bodies": [block(height="2")]}
    for torque, right in (("4", True), ("-4", False), ("0", False)):
        load = {"standing": [wrench("0", "0", "0", torque=("0", torque, "0"))]} if torque != "0" else {}
        assert stands(file([["0", "0", "4"]], **beside, **load)) == right, torque


def moves(factor: str, velocity: list[str], turn: tuple[str, str, str] = ("0", "0", "0"), **other: Any) -> str:
    """The claim that a push of 1 N along x moves the body above a factor, or why it is refused."""
    motion = [{"body": "a", "velocity": velocity, "turn": list(turn)}]
    proof = {"kind": "moves", "claim": "", "load": [wrench("1", "0", "0")], "factor": factor, "motion": motion}
    try:
        return ExactCertificate(file([["0", "0", "4"]], **other)).proved(proof)[0]
    except RefusedError as why:
        return str(why)


def test_what_slides_rises_along_the_cone() -> None:
    """Friction of 3/4 under 4 N gives way above 3 N: the power of the push 4 F is that of the weight, 12."""
    assert moves("3", ["4", "0", "3"]).endswith("above 3")
    assert "does not prove" in moves("2.999999999", ["4", "0", "3"])
    assert "does not prove" in moves("1.5", ["4", "0", "3"])
    assert "does not prove" in moves("3", ["-4", "0", "3"]), "the load has no power"
    for velocity in (["4", "0", "2.999999999"], ["4", "0", "0"], ["4", "0", "-3"], ["0", "0", "-1"]):
        assert "can brake" in moves("9", velocity), velocity
    assert "can brake" in moves("9", ["4", "0", "3"], contacts=[point("floor", "a", "0.750000001")])


def test_what_turns_moves_by_its_lever() -> None:
    """About an axis through a centre 3 m above and 4 m beside a contact, it moves there along the border of the cone.

    The velocity there is turn x lever = (0, 1, 0) x (-4, 0, -3) = (-3, 0, 4): the border at a friction of 4/3.
    """
    beside = {"bodies": [{"name": "a", "mass": "1", "centre": ["4", "0", "3"]}]}
    drift = ["1e-9", "0", "0"]  # a push at the centre needs some way
    easy, hard = ({**beside, "contacts": [point("floor", "a", mu)]} for mu in ("1.33", "1.34"))
    assert "above 1" in moves("1", drift, ("0", "1", "0"), **easy)
    assert "can brake" in moves("1", drift, ("0", "1", "0"), **hard)
    assert "can brake" in moves("1", drift, ("0", "-1", "0"), **easy)


def held(factor: str, force: list[str], **other: Any) -> str:
    proof = {
        "kind": "holds", "claim": "", "load": [wrench("-1", "0", "0")], "factor": factor, "forces": [force],
        "holds": [],
    }  # fmt: skip
    try:
        return "".join(ExactCertificate(file([["0", "0", "4"]], **other)).proved(proof))
    except RefusedError as why:
        return str(why)


def test_what_holds_is_told_in_newtons_rounded_down() -> None:
    assert "up to 3 N along (-1, 0, 0)" in held("3", ["3", "0", "4"])
    assert "do not balance" in held("3", ["2.999999", "0", "4"])
    assert "friction cone" in held("3.000001", ["3.000001", "0", "4"])
    below = held("2/3", ["2/3", "0", "4"])
    assert "up to 0.66666666" in below
    assert "7 N" not in below


def test_words_are_no_proof() -> None:
    """A file whose numbers prove 2 N, and whose words say 3."""
    said = held("2", ["2", "0", "4"])
    proof = {
        "kind": "holds", "load": [wrench("-1", "0", "0")], "factor": "2", "forces": [["2", "0", "4"]], "holds": [],
    }  # fmt: skip
    assert claims_of(json.dumps(file([["0", "0", "4"]], proofs=[{**proof, "claim": said}]))) == [said]
    with pytest.raises(RefusedError, match="what it claims is not what it proves"):
        claims_of(json.dumps(file([["0", "0", "4"]], proofs=[{**proof, "claim": said.replace("2", "3")}])))


def test_a_body_is_held_by_its_rounding_alone() -> None:
    """1 kg weighs 4 N here, so it may be held with 4e-9 N, and at a lever of 2 m with 8e-9 N m."""
    low = {"bodies": [block(height="2")]}
    held_up = file([["0", "0", "3.999999996"]], **low)
    assert stands({**held_up, "resting holds": [wrench("0", "0", "4e-9")]})
    assert not stands(held_up)
    ExactCertificate({**held_up, "resting holds": [wrench("0", "0", "0", torque=("0", "8e-9", "0"))]})
    for hold in (wrench("0", "0", "4.1e-9"), wrench("0", "0", "0", torque=("0", "8.1e-9", "0"))):
        with pytest.raises(RefusedError, match="'a' is held with more than"):
            ExactCertificate({**held_up, "resting holds": [hold]})


def test_cones_are_those_of_angles() -> None:
    """By angles to the normal: a force within the angle of friction; a velocity that rises at least at that angle."""
    rng = np.random.default_rng(5)
    for force, normal, mu in zip(
        rng.normal(size=(400, 3)), rng.normal(size=(400, 3)), rng.uniform(0, 2, 400), strict=True
    ):
        cosine = force @ normal / np.linalg.norm(force) / np.linalg.norm(normal)
        angle, friction = np.arccos(cosine), np.arctan(mu)
        exact = [tuple(Fraction(float(x)) for x in values) for values in (force, normal)]
        assert in_cone(*exact, Fraction(float(mu))) == (angle < friction)
        assert unbraked(*exact, Fraction(float(mu))) == (angle < np.pi / 2 - friction)
