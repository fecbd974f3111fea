"""Certificates: what they claim, that a stranger's Python can check them, and that altered ones are refused."""

from __future__ import annotations

import copy
import json
import pickle
import subprocess
import sys
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest

import holdfast as hf
from bench.scenes.random_assemblies import Family, arch, leaning, standing
from bench.suites.certificates import places
from holdfast.certificates import verify_certificate
from holdfast.certificates.beside_scene import differences, left_out
from holdfast.certificates.schema import schema
from holdfast.certificates.verify_certificate import RefusedError, claims_of
from holdfast.scene.shipped import shipped_scene
from holdfast.scene.shipped.blocks import at, box, floor

CHECKER = Path(__file__).parents[2] / "tools" / "verify_certificate.py"
SIDE, MASS, MU, G = 0.1, 2.0, 0.4, 9.81
RESTS = "contact forces balance every body under weight and standing loads"


def cube(mu: float = MU, **more: Any) -> hf.answers.Assembly:
    return hf.assemble(hf.Scene([floor(), box("cube", (SIDE,) * 3, MASS, (0, 0, SIDE / 2))], mu, **more))


def written(answer: Any, path: Path, **how: Any) -> dict[str, Any]:
    answer.save_certificate(path, **how)
    claims_of(path.read_text())
    data: dict[str, Any] = json.loads(path.read_text())
    jsonschema.validate(data, schema())
    return data


def factors(data: dict[str, Any]) -> dict[str, float]:
    return {proof["kind"]: float(proof["factor"]) for proof in data["proofs"] if "factor" in proof}


def test_a_level_push_on_a_cube_is_proved_from_both_sides(tmp_path: Path) -> None:
    push = hf.robustness(cube(), "cube", (-SIDE / 2, 0, 0.01), (1, 0, 0))
    found = factors(written(push, tmp_path / "push.json"))
    assert found["holds"] == pytest.approx(MU * MASS * G, rel=1e-6)
    assert found["moves"] == pytest.approx(MU * MASS * G, rel=1e-6)
    assert found["holds"] < MU * MASS * G < found["moves"]


def test_a_push_down_has_no_limit(tmp_path: Path) -> None:
    push = hf.robustness(cube(), "cube", (0, 0, SIDE), (0, 0, -1))
    stands, held = written(push, tmp_path / "push.json")["proofs"]
    assert stands["claim"] == f"{RESTS}: 'cube'"
    assert held["claim"] == (
        f"{RESTS} with every multiple of load 1 from 0 on; "
        "that is any multiple of 1 N along (0, 0, -1) on 'cube' at (0, 0, 0.1) m"
    )


@pytest.mark.parametrize(("gravity", "x"), [((0, 5.0, -G), 0.0), ((0, 0, -G), 0.53), ((0, 0, -G), 5.0)])
def test_what_falls_is_proved_to(tmp_path: Path, gravity: tuple[float, float, float], x: float) -> None:
    """It slides on a slope, tips over an edge, or hangs in the air."""
    scene = hf.Scene([floor(), box("cube", (SIDE,) * 3, MASS, (x, 0, SIDE / 2))], MU, gravity)
    answer = hf.stability(scene)
    assert answer.status is hf.Status.UNSTABLE
    data = written(answer, tmp_path / "falls.json")
    assert [proof["claim"] for proof in data["proofs"]] == [f"no {RESTS}, by a motion of 'cube'"]


def test_a_push_on_what_falls_proves_the_fall(tmp_path: Path) -> None:
    assembly = cube(gravity=(0, 5.0, -G))
    push = hf.robustness(assembly, "cube", (0, 0, SIDE), (0, 0, -1), engine="limit")
    assert [proof["kind"] for proof in written(push, tmp_path / "push.json")["proofs"]] == ["falls"]


def test_the_limits_of_a_carrier_are_of_all_that_it_carries(tmp_path: Path) -> None:
    rough, slick = box("rough", (SIDE,) * 3, MASS, (0, 0, 0.05)), box("slick", (SIDE,) * 3, 1.0, (0.3, 0, 0.05))
    scene = hf.Scene([floor(), rough, slick], hf.Friction(0.8, {("floor", "slick"): 0.3}))
    limits = hf.transport_limits(scene, [(1, 0, 0), (0, -1, 0), (1, 1, 0)])
    data = written(limits, tmp_path / "limits.json", row=1)
    assert factors(data) == pytest.approx({"holds": 0.3 * G, "moves": 0.3 * G}, rel=1e-6)
    assert [entry["body"] for entry in data["proofs"][2]["motion"]] == ["slick"]
    assert len(written(limits, tmp_path / "limits.json")["proofs"]) == 7


@pytest.mark.parametrize("order", [1, -1])
def test_loads_on_two_stacks_hold_as_far_as_the_weaker_of_them(order: int, tmp_path: Path) -> None:
    """Each slides on its own at μ m g; two newtons on the rough one for each on the slick one."""
    rough, slick = box("rough", (SIDE,) * 3, 2.0, (0, 0, 0.05)), box("slick", (SIDE,) * 3, 1.0, (0.3, 0, 0.05))
    scene = hf.Scene([floor(), *(rough, slick)[::order]], hf.Friction(0.8, {("floor", "slick"): 0.3}))
    loads = [hf.Load("rough", (0, 0, 0.01), force=(2, 0, 0)), hf.Load("slick", (0.3, 0, 0.01), force=(1, 0, 0))]
    data = written(hf.load_factor(scene, loads[::order]), tmp_path / "factor.json")
    assert factors(data) == pytest.approx({"holds": 0.3 * G, "moves": 0.3 * G}, rel=1e-6)


def test_standing_loads_and_accelerations_are_part_of_it(tmp_path: Path) -> None:
    pressed = hf.Load("cube", (0, 0, SIDE), force=(0, 0, -30))
    push = hf.load_factor(
        cube(), [hf.Load("cube", (0, 0, 0.01), force=(1, 0, 0))], standing=[pressed], acceleration=(0, 0, 1.0)
    )
    found = factors(written(push, tmp_path / "factor.json"))
    assert found == pytest.approx({"holds": MU * (MASS * (G + 1) + 30), "moves": MU * (MASS * (G + 1) + 30)}, rel=1e-6)


@pytest.mark.parametrize("name", ["stack", "table", "wall2x2", "slope_two", "cantilever", "arch", "v_groove"])
def test_shipped_scenes_are_proved(tmp_path: Path, name: str) -> None:
    assembly = hf.assemble(shipped_scene(name))
    assert written(hf.stability(assembly), tmp_path / "stands.json")["proofs"][0]["kind"] == "stands"
    rng = np.random.default_rng(3)
    body = assembly.movable[-1]
    points = body.surface_world.vertices[:3]
    pushes = hf.robustness(assembly, body.name, points, rng.normal(size=(3, 3)), engine="limit")
    data = written(pushes, tmp_path / "pushes.json")
    held = [p for p in data["proofs"] if p["kind"] == "holds" and p["factor"] != "unlimited"]
    moved = [float(p["factor"]) for p in data["proofs"] if p["kind"] == "moves"]
    np.testing.assert_allclose(moved, pushes.upper[np.isfinite(pushes.upper)], rtol=1e-6)
    for proof, lower in zip(held, pushes.lower[np.isfinite(pushes.lower)], strict=True):
        assert float(proof["factor"]) == pytest.approx(lower, rel=1e-4)
        assert float(proof["factor"]) <= lower * (1 + 1e-12)


@pytest.mark.parametrize("family", [leaning, arch])
def test_bodies_that_hold_each_other_are_corrected_together(tmp_path: Path, family: Family) -> None:
    """A plank that leans on a block, and voussoirs: the second body of a contact may hold the first."""
    for seed in range(5):
        assembly = standing(family, np.random.default_rng(seed))
        data = written(hf.stability(assembly, engine="limit"), tmp_path / "stands.json")
        assert data["resting holds"] == [], "nothing is only balanced"


def test_a_map_is_one_file(tmp_path: Path) -> None:
    pushes = hf.robustness_map(cube(), ["cube"], spacing=0.05, engine="limit")
    data = written(pushes, tmp_path / "map.json")
    held = [proof for proof in data["proofs"] if proof["kind"] == "holds"]
    lower = [float(proof["factor"]) if proof["factor"] != "unlimited" else np.inf for proof in held]
    np.testing.assert_allclose(lower, pushes.lower, rtol=0.02)
    assert (lower >= pushes.lower * (1 - 1e-6)).all()


@pytest.mark.parametrize("name", ["table", "arch", "tabletop"])
def test_orders_are_proved_state_by_state(tmp_path: Path, name: str) -> None:
    assembly = hf.assemble(shipped_scene(name))
    for order in (hf.disassembly_order(assembly), hf.build_order(assembly, pushes=0)):
        order.save_certificate(tmp_path / "order.json")
        states = json.loads((tmp_path / "order.json").read_text())
        jsonschema.validate(states, schema())
        there = [{body["name"] for body in state["bodies"]} for state in states]
        whole = {body.name for body in assembly.movable}
        if isinstance(order, hf.answers.Disassembly):
            wanted = [whole - set(order.order[:k]) for k in range(len(order.order) + 1)]
        else:
            wanted = [set(order.first) | set(order.order[:k]) for k in range(len(order.order) + 1)]
        assert there == [names for names in wanted if names]
        claims = claims_of((tmp_path / "order.json").read_text())
        assert [claim.split(": ")[1] for claim in claims] == [RESTS] * len(states)
        for claim, names in zip(claims, there, strict=True):
            assert all(repr(name) in claim for name in sorted(names)) or " more" in claim
        assert claims[-1].startswith(f"state {len(states)}, ")


def test_a_removal_is_proved_to_be_safe_and_to_be_unsafe(tmp_path: Path) -> None:
    stack = hf.assemble(shipped_scene("stack"))
    for body, second in (("cube3", RESTS), ("cube1", f"no {RESTS}")):
        removal = hf.can_remove(stack, body)
        removal.save_certificate(tmp_path / "removal.json")
        claims = [claim.split(": ")[1] for claim in claims_of((tmp_path / "removal.json").read_text())]
        claims = [claim.removesuffix(", by a motion of 'cube2', 'cube3'") for claim in claims]
        assert (claims, removal.safe) == ([RESTS, second], second is RESTS)
    states = json.loads((tmp_path / "removal.json").read_text())
    for wrong, why in (([], "exactly"), ([states], "exactly"), ([*states, {}], "exactly")):
        with pytest.raises(RefusedError, match=why):
            claims_of(json.dumps(wrong))
    states[1]["bodies"][0]["mass"] = "2.5"
    with pytest.raises(RefusedError, match=r"do not balance|no power"):
        claims_of(json.dumps([states[1], {**states[0], "gravity": ["0", "0", "-9.8"]}]))
    alone = hf.assemble(hf.Scene([floor(), box("cube", (SIDE,) * 3, MASS, (0, 0, SIDE / 2))], MU))
    hf.can_remove(alone, "cube").save_certificate(tmp_path / "removal.json")
    assert len(claims_of((tmp_path / "removal.json").read_text())) == 1, "where nothing is left nothing can fall"
    with pytest.raises(hf.HoldfastError, match="ask anew"):
        pickle.loads(pickle.dumps(hf.can_remove(alone, "cube"))).save_certificate(tmp_path / "x.json")


def test_a_fall_by_the_law_of_an_engine_has_no_proof(tmp_path: Path) -> None:
    """A block between walls that might clamp it: forces that balance exist, but nothing brings them about."""
    walls = [
        hf.Body(n, hf.Box((0.1,) * 3), fixed=True, pose=at(x, 0, 0.5)) for n, x in (("left", -0.1), ("right", 0.1))
    ]
    hangs = hf.assemble(hf.Scene([*walls, box("cube", (SIDE,) * 3, MASS, (0, 0, 0.5))], 0.5))
    answer = hf.stability(hangs)
    assert answer.status is hf.Status.UNSTABLE
    with pytest.raises(hf.HoldfastError, match="forces that balance exist"):
        answer.save_certificate(tmp_path / "falls.json")
    assert not list(tmp_path.iterdir())


def test_a_certificate_is_compared_with_a_scene(tmp_path: Path) -> None:
    scene = shipped_scene("table")
    assembly = hf.assemble(scene)
    data = written(hf.robustness(assembly, "slab", (0, 0, 0.2), (1, 0, 0)), tmp_path / "push.json")
    assert differences(data, assembly) == []
    hf.save_scene(scene, tmp_path / "scene.json")
    assert differences(data, hf.assemble(hf.load_scene(tmp_path / "scene.json"))) == []
    for place, value, says in (
        (("gravity", 2), "-9.8", "gravity differs: 0, 0, -9.8 in the certificate, 0, 0, -9.81 here"),
        (("bodies", 0, "mass"), "3", "the mass of"),
        (("bodies", 1, "centre", 0), "0.01", "the centre of"),
        (("bodies", 0, "name"), "x", "x cannot move, or is not there"),
        (("fixed", 0), "slope", "slope is not fixed"),
        (("contacts", 0, "mu"), "0.9", "mu is 0.9 in the certificate, 0.5 here"),
        (("contacts", 1, "points", 0, "at", 1), "0.9", "at of point 1 is "),
        (("contacts", 1, "points", 2, "normal"), ["0", "0.6", "0.8"], "normal of point 3 is 0, 0.6, 0.8 in the"),
    ):
        (said,) = differences(altered(data, place, value), assembly)
        assert says in said, place
        assert said.startswith("the contact between") == (place[0] == "contacts")
    data["contacts"][0]["points"].pop()
    (said,) = differences(data, assembly)
    assert "points in the certificate" in said
    removal = hf.can_remove(assembly, "slab")
    removal.save_certificate(tmp_path / "removal.json")
    with_slab, without = json.loads((tmp_path / "removal.json").read_text())
    assert (left_out(with_slab, assembly), left_out(without, assembly)) == (([], False), (["slab"], True))


def test_a_certificate_of_glued_faces_agrees_with_the_glue_alone(tmp_path: Path) -> None:
    wall = hf.Body("wall", hf.Box((0.1, 0.1, 0.1)), position=(-0.05, 0, 0), fixed=True, material="brick")
    brick = hf.Body("brick", hf.Box((0.03, 0.02, 0.01)), mass=0.02, position=(0.015, 0, 0), material="brick")
    glued, stronger, dry = (
        hf.assemble(hf.Scene([wall, brick], hf.Friction(0.5, tension={("brick", "brick"): tension})))
        for tension in (3e4, 9e4, 0.0)
    )
    data = written(hf.stability(glued, engine="limit"), tmp_path / "glued.json")
    assert differences(data, glued) == []
    for other in (stronger, dry):
        assert differences(data, other) == ["what stands on 'brick' is not the pull of tension between its faces alone"]


def test_the_checker_needs_nothing_but_python(tmp_path: Path) -> None:
    hf.stability(cube()).save_certificate(tmp_path / "stands.json")
    alone = [sys.executable, "-I", "-S", str(CHECKER)]  # without installed packages
    said = subprocess.run([*alone, str(tmp_path / "stands.json")], capture_output=True, text=True, check=False)
    assert (said.returncode, said.stderr) == (0, "")
    assert said.stdout.splitlines() == [f"verified: {RESTS}: 'cube'", verify_certificate.UNCHECKED]
    (tmp_path / "stands.json").write_text((tmp_path / "stands.json").read_text().replace('"2.0"', '"2.1"'))
    said = subprocess.run([*alone, str(tmp_path / "stands.json")], capture_output=True, text=True, check=False)
    assert (said.returncode, said.stdout) == (1, "NOT verified: the forces on 'cube' do not balance\n")
    assert subprocess.run([*alone, str(tmp_path / "none")], capture_output=True, check=False).returncode == 2
    lines = [line for line in CHECKER.read_text().splitlines() if line.strip()]
    assert len(lines) <= 312


# --- what a claim says ---


def test_a_claim_names_body_point_direction_and_newtons_rounded_to_the_safe_side(tmp_path: Path) -> None:
    """A push at 30 degrees: the same bounds as by hand, down for what is held, and up for what moves."""
    push = hf.robustness(cube(), "cube", (-SIDE / 2, 0, 0.01), (np.cos(np.pi / 6), 0, -0.5))
    data = written(push, tmp_path / "push.json")
    _, held, moved = (proof["claim"] for proof in data["proofs"])
    slides = MU * MASS * G / (np.cos(np.pi / 6) - 0.5 * MU)
    for claim, word, sign in ((held, "up to", -1), (moved, "above", 1)):
        where = " N along (0.866025, 0, -0.5) on 'cube' at (-0.05, 0, 0.01) m"
        newtons = float(claim.split(f"; that is {word} ")[1].split(where)[0])
        assert newtons == pytest.approx(slides, rel=1e-6)
        assert sign * (newtons - slides) > 0
        factor = verify_certificate.number(data["proofs"][1 if sign < 0 else 2]["factor"])
        assert sign * (verify_certificate.number(repr(newtons)) - factor) >= 0


def test_a_load_at_a_point_is_that_force_there(tmp_path: Path) -> None:
    data = written(hf.robustness(cube(), "cube", (-SIDE / 2, 0.01, 0.03), (1, 0, 0)), tmp_path / "push.json")
    (load,) = data["proofs"][1]["load"]
    assert load == {"body": "cube", "at": ["-0.05", "0.01", "0.03"], "force": ["1.0", "0.0", "0.0"]}
    by_hand = {"body": "cube", "force": ["1", "0", "0"], "torque": ["0", "-0.02", "-0.01"]}
    for proof in data["proofs"][1:]:
        proof["load"] = [by_hand]
    with pytest.raises(RefusedError, match="what it claims is not what it proves") as refused:
        claims_of(json.dumps(data))
    assert "N m along (0, -0.894427, -0.447214) on 'cube' about its centre of mass" in str(refused.value)


def test_existence_beyond_the_answer_is_told(tmp_path: Path) -> None:
    """Pushed down and turned at once, forces exist up to 1.44 times the load; contacts stay at rest to 0.77."""
    push = hf.load_factor(
        cube(), [hf.Load("cube", (0, 0, SIDE), force=(0, 0, -1), moment=(0, 0, 1))], engine="compliant"
    )
    proof = next(p for p in written(push, tmp_path / "push.json")["proofs"] if p["kind"] == "holds")
    assert proof["answered"] == {"engine": "compliant", "answer": repr(push.factor)}
    assert push.factor < 0.9 * float(proof["factor"])
    assert (
        f"the answer that this was saved from is {push.factor:.6g} times the load, by engine 'compliant'"
        in proof["claim"]
    )
    data = json.loads((tmp_path / "push.json").read_text())
    data["proofs"][1]["answered"]["answer"] = data["proofs"][1]["factor"]
    with pytest.raises(RefusedError, match="what it claims"):
        claims_of(json.dumps(data))


@pytest.mark.parametrize(("answer", "says"), [("undecided", "is undecided, by"), ("unstable", "is unstable, by")])
def test_rest_that_was_not_the_answer_is_told(tmp_path: Path, answer: str, says: str) -> None:
    data = written(hf.stability(cube()), tmp_path / "stands.json")
    data["proofs"][0]["answered"]["answer"] = answer
    with pytest.raises(RefusedError, match=says):
        claims_of(json.dumps(data))


def older(data: dict[str, Any]) -> dict[str, Any]:
    """Return a certificate as the release before wrote it: torques in place of points, and shorter claims."""
    data = {**copy.deepcopy(data), "format": verify_certificate.OLDER}
    centres = {body["name"]: [verify_certificate.number(x) for x in body["centre"]] for body in data["bodies"]}
    for proof in data["proofs"]:
        proof.pop("answered", None)
        proof["claim"] = proof["claim"].split("; that is")[0].split(", by a motion")[0].split(": ")[0]
        for entry in proof.get("load", ()):
            force = [verify_certificate.number(x) for x in entry["force"]]
            lever = [
                verify_certificate.number(x) - c for x, c in zip(entry.pop("at"), centres[entry["body"]], strict=True)
            ]
            entry["torque"] = [str(lever[i - 2] * force[i - 1] - lever[i - 1] * force[i - 2]) for i in range(3)]
    return data


def test_files_of_the_release_before_are_verified(pushed: dict[str, Any]) -> None:
    data = older(pushed)
    jsonschema.validate(data, schema())
    claims = claims_of(json.dumps(data))
    assert [claim.split(";")[0].split(":")[0] for claim in claims] == [proof["claim"] for proof in data["proofs"]]
    data["format"] = verify_certificate.FORMAT
    with pytest.raises(RefusedError, match="what it claims"):
        claims_of(json.dumps(data))


# --- what is altered is refused ---


def in_air(force: str, torque: str = "0", mass: str = "2") -> dict[str, Any]:
    """A cube of 2 kg that touches the floor at one point below its middle, held by some newtons."""
    hold = {"body": "cube", "force": ["0", "0", force], "torque": [torque, "0", "0"]}
    point = {"at": ["0", "0", "0"], "normal": ["0", "0", "1"]}
    body = {"name": "cube", "mass": mass, "centre": ["0", "0", "0.05"]}
    carried = verify_certificate.number(mass) * verify_certificate.number("9.81") - verify_certificate.number(force)
    return {
        "format": verify_certificate.FORMAT, "units": "m, kg, s, N, N m", "gravity": ["0", "0", "-9.81"],
        "acceleration": [0, 0, 0], "fixed": ["floor"], "bodies": [body],
        "standing": [], "contacts": [{"between": ["floor", "cube"], "mu": "0.5", "points": [point]}],
        "rest": [["0", "0", str(carried)]], "resting holds": [hold], "proofs": [{"kind": "stands", "claim": ""}],
    }  # fmt: skip


def test_holds_are_what_rounding_leaves_and_no_more() -> None:
    """2 kg weigh 19.62 N, so that 1.962e-8 N is the most; of torques at a lever of 0.05 m 9.81e-10 N m."""
    for held, torque in (("1.962e-8", "0"), ("-1.9e-8", "0"), ("0", "0")):
        with pytest.raises(RefusedError, match="what it claims"):  # it is proved, but the claim is missing
            claims_of(json.dumps(in_air(held, torque)))
    for held, torque in (("1.963e-8", "0"), ("19.62", "0"), ("21", "0"), ("0", "9.82e-10"), ("1e-9", "-1")):
        with pytest.raises(RefusedError, match="'cube' is held with more than"):
            claims_of(json.dumps(in_air(held, torque)))
    heavy = in_air("1.963e-8")
    heavy["bodies"].append({"name": "anvil", "mass": "1e6", "centre": ["1", "0", "0"]})
    with pytest.raises(RefusedError, match="'cube' is held"):
        claims_of(json.dumps(heavy)), "the weight of others allows nothing"
    floating = in_air("1e-12")
    floating["gravity"] = ["0", "0", "0"]
    with pytest.raises(RefusedError, match="'cube' is held"):
        claims_of(json.dumps(floating))


def test_limits_are_told() -> None:
    """What would take more than some seconds is refused with the limit that it is beyond."""

    def refused(data: dict[str, Any] | str, why: str) -> None:
        with pytest.raises(RefusedError, match=why):
            claims_of(data if isinstance(data, str) else json.dumps(data))

    refused(" " * 20_000_001, "longer than 20,000,000 characters")
    refused(in_air("0", mass="2." + "0" * 980 + "1"), "do not balance|what it claims")
    refused(in_air("0", mass="2." + "0" * 1000 + "1"), "a number of more than 1,000 digits")
    many = in_air("0")
    point = many["contacts"][0]["points"][0]
    for k in range(400):  # quotients whose common denominator has more than 1,000 digits
        many["contacts"][0]["points"].append(point)
        many["rest"].append(["0", "0", f"1/{10**6 + 2 * k + 1}"])
    refused(many, "the common denominator of some numbers has more than")
    moving = in_air("0")
    moving["resting holds"], moving["contacts"][0]["points"] = [], [point] * 2000
    motion = [{"body": "cube", "velocity": ["1e-399", "0", "1e-300"], "turn": ["0", "0", "0"]}]
    load = [{"body": "cube", "force": ["1", "0", "0"], "torque": ["0", "0", "0"]}]
    moving["proofs"] = [{"kind": "moves", "claim": "", "load": load, "factor": "1e308", "motion": motion}] * 60
    refused(moving, "motions pass too many points")


def altered(data: Any, path: tuple[Any, ...], value: Any) -> Any:
    data = copy.deepcopy(data)
    part = data
    for key in path[:-1]:
        part = part[key]
    part[path[-1]] = value
    return data


@pytest.fixture
def pushed(tmp_path: Path) -> dict[str, Any]:
    assembly = hf.assemble(shipped_scene("stack"))
    body = assembly.movable[-1]
    push = hf.robustness(assembly, body.name, body.surface_world.vertices[0], (1, 0.3, 0.1))
    return written(push, tmp_path / "push.json")


def test_a_certificate_with_another_number_is_refused_or_proves_what_it_then_says(pushed: dict[str, Any]) -> None:
    """Forces, masses and gravity enter equations, so any change is refused. Others may be harmless, because the proof
    leaves them room (a normal in a cone, the velocity of what opens, friction where nothing slips), or does not need
    them (the height of a centre above level forces, a load across the motion); then the altered claim is proved, too.
    """
    where, refused = list(places(pushed)), 0
    for path in where:
        value = float(verify_certificate.number(_at(pushed, path)))
        for other in (-value if value else 1.0, 1.001 * value + 1e-4):
            try:
                claims_of(json.dumps(altered(pushed, path, repr(other))))
                assert not {"rest", "forces", "mass", "gravity"} & set(path), path
            except RefusedError:
                refused += 1
    assert refused > 0.8 * 2 * len(where)
    held, moved = (k for k, proof in enumerate(pushed["proofs"]) if "factor" in proof)
    for k, share in ((held, 1.0001), (held, 0.9999), (moved, 0.9999)):
        other = repr(share * float(pushed["proofs"][k]["factor"]))
        with pytest.raises(RefusedError, match=r"do not balance|does not prove"):  # not that the words are others
            claims_of(json.dumps(altered(pushed, ("proofs", k, "factor"), other)))


def _at(data: Any, path: tuple[Any, ...]) -> Any:
    for key in path:
        data = data[key]
    return data


def test_other_alterations_are_refused(pushed: dict[str, Any]) -> None:
    def refused(change: Any, why: str) -> None:
        other = copy.deepcopy(pushed)
        change(other)
        with pytest.raises(RefusedError, match=why):
            claims_of(json.dumps(other))

    refused(lambda d: d.update(units="mm, kg, s, N, N m"), "format")
    refused(lambda d: d.update(note="trust me"), "exactly the entries")
    refused(lambda d: d["contacts"].pop(), "needs .* forces|do not balance|brake")
    refused(lambda d: d["contacts"][0]["points"].pop(), "needs .* forces")
    refused(lambda d: d["contacts"][0]["between"].reverse(), "do not balance")
    refused(lambda d: d["bodies"].append(d["bodies"][0]), "twice")
    refused(lambda d: d["fixed"].append(d["bodies"][0]["name"]), "twice")
    refused(lambda d: d["bodies"][0].update(mass=1.5), "not an exact number")
    refused(lambda d: d["bodies"][0].update(mass="-1"), "not positive")
    refused(lambda d: d["contacts"][0].update(mu="-0.1"), "is negative")
    refused(lambda d: d["contacts"][0]["points"][0].update(normal=["0", "0", "0"]), "normal is zero")
    refused(lambda d: d["proofs"][1].update(factor="1e9999"), "not an exact number")
    refused(lambda d: d["proofs"][1].update(claim="it stands"), "not what it proves")
    refused(lambda d: d["proofs"][1].update(kind="proved"), "unknown")
    refused(lambda d: d["proofs"][2].update(motion=[]), "does not prove")
    refused(lambda d: d.update(proofs=[]), "nothing")
    refused(lambda d: d["proofs"][1].update(load=[]), "load is zero")
    refused(lambda d: d["proofs"][1]["load"].append(d["proofs"][1]["load"][0]), "twice")
    refused(lambda d: d["bodies"][0].update(name="ball\nverified: all"), "no name of a body")
    refused(lambda d: d.update(gravity="000"), "list of three")
    refused(lambda d: d.update(bodies=None), "lists")
    with pytest.raises(RefusedError, match="twice"):
        claims_of('{"format": 1, "format": 1}')
    for text in ("", "[]", "3", "null", '{"a": NaN}', "[" * 100_000, '"\\ud800"'):
        with pytest.raises(RefusedError):
            claims_of(text)


def test_an_answer_that_was_copied_has_no_certificate(tmp_path: Path) -> None:
    answer = pickle.loads(pickle.dumps(hf.stability(cube())))
    with pytest.raises(hf.HoldfastError, match="saved or copied"):
        answer.save_certificate(tmp_path / "stands.json")
    assert not (tmp_path / "stands.json").exists()


def test_what_cannot_be_proved_exactly_is_refused(tmp_path: Path) -> None:
    """Nothing but rounding decides whether this ball is in balance."""
    ball = hf.Body("ball", hf.Sphere(0.05), mass=1.0, pose=at(0, 0, 0.05), com=(1e-9, 0, 0))
    with pytest.raises(hf.HoldfastError, match="no exact proof"):
        hf.stability(hf.Scene([floor(), ball], MU)).save_certificate(tmp_path / "ball.json")
    with pytest.raises(hf.HoldfastError, match="there is no row 3"):
        hf.robustness(cube(), "cube", (0, 0, SIDE), (0, 0, -1)).save_certificate(tmp_path / "push.json", row=3)
