"""Every answer pickles, copies, is saved, read back and shown, whatever it holds; nothing in it can be written to."""

from __future__ import annotations

import copy
import dataclasses
import html
import json
import multiprocessing
import os
import pickle
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from functools import cache
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from envelopes import problems
from public_api import NAMES
from reachable import arrays, writable

import holdfast as hf
from holdfast.base.archive import save
from holdfast.base.public import Summary, as_html
from holdfast.base.values import Table
from holdfast.batches.saved import ANSWERS
from holdfast.scene.shipped.blocks import at, floor

SIDE, X, DOWN = (-0.05, 0.0, 0.05), (1.0, 0.0, 0.0), (0.0, 0.0, -1.0)
ODD = "<b>x</b>&amp;'\"\n\u2028</script>"  # no name of a body may become part of a page


@cache
def cube() -> hf.answers.Assembly:
    return hf.assemble(hf.shipped_scene("cube"))


@cache
def hanging() -> hf.answers.Assembly:
    """A cube in the air."""
    scene = hf.shipped_scene("cube")
    pose = np.eye(4)
    pose[2, 3] = 0.3
    moved = [body if body.fixed else body.moved(pose) for body in scene.bodies]
    return hf.assemble(hf.Scene(moved, scene.friction))


@cache
def wedged() -> hf.answers.Assembly:
    """Between two walls without a floor: engine ``limit`` cannot tell, ``compliant`` says that it falls."""
    return hf.assemble(hf.shipped_scene("wedged"))


@cache
def oddly_named() -> hf.answers.Assembly:
    cube = hf.Body(ODD, hf.Box((0.1, 0.1, 0.1)), mass=1.0, pose=at(0, 0, 0.05))
    return hf.assemble(hf.Scene([floor(), cube], 0.5, name=ODD))


def placed() -> hf.answers.Placement:
    box = hf.Body("box", hf.Box((0.03, 0.03, 0.03)), mass=0.1)
    return hf.plan_placement(
        cube(), box, where=hf.Where(supports=["cube"]), search=hf.Search(spacing=0.05, seed=1), engine="graph"
    )


def no_place() -> hf.answers.Placement:
    box = hf.Body("box", hf.Box((5, 5, 5)), mass=1000)
    return hf.plan_placement(
        cube(), box, where=hf.Where(supports=["cube"]), search=hf.Search(spacing=0.05, solves=2), engine="graph"
    )


PUSHES = ([SIDE, (0.0, 0.0, 0.1)], [X, DOWN])  # the second is infinite
POSES = np.array([hf.pose(x, 0, 0.05) for x in (0.0, 0.01, 3.0)])
ENGINES = ("graph", "limit", "compliant")
ASK: dict[str, Callable[[], Any]] = {
    **{f"stability, {e}": lambda e=e: hf.stability(cube(), engine=e) for e in ENGINES},
    "stability, unstable": lambda: hf.stability(hanging()),
    "stability, drifting": lambda: hf.stability(wedged()),
    "stability, undecided": lambda: hf.stability(wedged(), engine="limit"),
    **{f"pushes, {e}": lambda e=e: hf.robustness(cube(), "cube", *PUSHES, engine=e) for e in ENGINES},
    "pushes, bounded": lambda: hf.robustness(cube(), "cube", *PUSHES, bounds=True),
    "pushes, unstable": lambda: hf.robustness(hanging(), "cube", (-0.05, 0, 0.3), X, engine="limit"),
    "pushes, undecided": lambda: hf.robustness(wedged(), "cube", *_on(wedged()), engine=hf.Graph(nodes=12)),
    "load factor": lambda: hf.load_factor(cube(), [hf.Load("cube", SIDE, X)]),
    "load factor, nothing moves": lambda: hf.load_factor(cube(), [], engine="limit"),
    **{f"map, {e}": lambda e=e: hf.robustness_map(cube(), spacing=0.04, engine=e) for e in ENGINES},
    "map, unstable": lambda: hf.robustness_map(hanging(), spacing=0.05, engine="limit"),
    "samples": lambda: hf.robustness_under(
        cube(), "cube", *PUSHES, uncertain=hf.sets.Uncertain(mu_range=0.2, samples=3, seed=1), engine="limit"
    ),
    "gradients": lambda: hf.sets.gradients(cube(), hf.robustness(cube(), "cube", *PUSHES, engine="limit")),
    "gradients, kinks": lambda: dataclasses.replace(
        answer("gradients"), kinks=(hf.answers.Kink(row=0, by="mass of cube", before=1.0, after=2.0),)
    ),
    "sensitivity": lambda: hf.sets.sensitivity(cube(), "cube", SIDE, X),
    "worst case": lambda: hf.sets.worst_case(cube(), "cube", *PUSHES, mu_range=0.1, mass_range=0.1),
    "worst case, centres": lambda: hf.sets.worst_case(
        cube(), "cube", *PUSHES, mass_range=0.1, com_range={"cube": (0.01, 0, 0)}
    ),
    "accelerations": lambda: hf.sets.sustainable_accelerations(cube(), accuracy=0.2),
    "constraint": lambda: hf.sets.constraint(cube(), "cube", solves=50),
    "poses": lambda: hf.stability_of_poses(cube(), "cube", POSES),
    "poses, pushed": lambda: hf.robustness_of_poses(cube(), "cube", POSES, POSES[:, :3, 3] - (0.05, 0, 0), X),
    "transport": lambda: hf.transport_limits(cube(), [X, (0, 0, 1)], bounds=True),
    "transport, unstable": lambda: hf.transport_limits(hanging(), [X], engine="limit"),
    "transport, samples": lambda: hf.transport_under(
        cube(), [X, (0, 0, 1)], hf.sets.Uncertain(mu_range=0.2, mass_range=0.1, samples=3), engine="limit"
    ),
    "friction": lambda: hf.friction_from(
        cube(), [("cube", SIDE, X, 4.0), ("cube", SIDE, X, 4.4), ("cube", SIDE, X, 5.0, False)], engine="limit"
    ),
    "friction, undecided": lambda: hf.friction_from(
        cube(), [("cube", SIDE, X, 1.0), ("cube", SIDE, X, 9.0)], scatter=0.1, engine="limit"
    ),
    "carried": lambda: hf.carry(cube(), "road", bounds=True),
    "carried, unstable": lambda: hf.carry(hanging(), "eumos40509_0.5g", engine="limit"),
    "monitored": lambda: hf.Monitor(cube(), seconds=100, solves=30).update(X),
    "monitored, unstable": lambda: hf.Monitor(hanging()).update(X),
    "disassembly": lambda: hf.disassembly_order(hf.shipped_scene("stack"), engine="graph"),
    "disassembly, no end": lambda: hf.disassembly_order(
        hf.shipped_scene("stack"), engine="limit", goal="cube1", lift=(1, 0, 0)
    ),
    "removal": lambda: hf.can_remove(hf.shipped_scene("stack"), "cube2", engine="graph"),
    "build order": lambda: hf.build_order(hf.shipped_scene("stack"), engine="graph", pushes=30),
    "build order, no pushes": lambda: hf.build_order(hf.shipped_scene("stack"), engine="graph", pushes=0),
    "build order, no end": lambda: hf.build_order(hf.shipped_scene("arch"), engine="limit", pushes=0),
    "settled": lambda: hf.settle(hf.Scene(hf.shipped_scene("cube").moved({"cube": hf.pose(z=0.052)}).bodies, 0.5)),
    "resting poses": lambda: hf.resting_poses(hf.Box((0.1, 0.2, 0.3))),
    "safe pushes": lambda: hf.safe_pushes(cube(), "cube", 9.0, spacing=0.05),
    "placements": lambda: hf.place_all(
        cube(), [hf.Body("box", hf.Box((0.03, 0.03, 0.03)), mass=0.1)], search=hf.Search(solves=3), engine="graph"
    ),
    "placement": placed,
    "no placement": no_place,
    "odd names": lambda: hf.robustness_map(oddly_named(), spacing=0.05, engine="limit"),
    "odd names, stability": lambda: hf.stability(oddly_named(), engine="limit"),
    "odd names, order": lambda: hf.disassembly_order(oddly_named(), engine="graph"),
}  # fmt: skip


def _on(assembly: hf.answers.Assembly) -> tuple[Any, Any]:
    body = assembly.movable[0]
    return body.com_world + np.array([0.0, 0.0, (body.box[1] - body.box[0])[2] / 2]), DOWN


@cache
def answer(name: str) -> Any:
    return ASK[name]()


@pytest.mark.parametrize("name", ASK)
def test_a_copy_is_equal_and_shares_what_was_shared(name: str) -> None:
    value = answer(name)
    for other in (pickle.loads(pickle.dumps(value)), copy.deepcopy(value)):
        assert other is not value
        assert other == value
        assert other.to_dict() == value.to_dict()
        assert len(_kinematics(other)) == len(_kinematics(value))
        assert writable(other, name) == []


def _kinematics(value: Any) -> set[int]:
    """Numbers of the objects that the mechanisms of an answer stand on."""
    told = getattr(getattr(value, "answers", None), "mechanism", ())
    return {id(mechanism.kinematics) for mechanism in told if mechanism is not None}


@pytest.mark.parametrize("name", ASK)
@pytest.mark.parametrize("suffix", [".json", ".npz"])
def test_nothing_is_lost_in_a_file(name: str, suffix: str, tmp_path: Path) -> None:
    value = answer(name)
    value.save(tmp_path / f"answer{suffix}")
    again = hf.load_answer(tmp_path / f"answer{suffix}")
    assert type(again) is type(value)
    assert again == value
    assert repr(again) == repr(value)
    assert again.to_dict() == value.to_dict()
    assert len(_kinematics(again)) == len(_kinematics(value))
    for (path, one), (other_path, other) in zip(_bits(value), _bits(again), strict=True):
        assert (path, one) == (other_path, other)
    assert writable(again, name) == []


def _bits(value: Any) -> list[tuple[str, bytes]]:
    """Of the arrays of numbers in the fields of an answer's table: -0.0 and 0.0 differ."""
    table = getattr(value, "answers", value)
    fields = [
        (name, getattr(table, name)) for name in ("force", "lower", "upper", "box", "vertices") if hasattr(table, name)
    ]
    return [(name, np.asarray(values).tobytes()) for name, values in fields]


@pytest.mark.parametrize("name", ASK)
def test_nothing_can_be_written_to(name: str) -> None:
    found = dict(arrays(answer(name), name))
    assert writable(answer(name), name) == []
    for array in found.values():
        if array.size:
            with pytest.raises(ValueError, match="read-only"):
                array[...] = array.flat[0]


@pytest.mark.parametrize("name", ASK)
def test_plain_data_is_strict_json(name: str) -> None:
    data = answer(name).to_dict()
    assert json.loads(json.dumps(data, allow_nan=False)) == data


@pytest.mark.parametrize("name", ASK)
def test_its_envelope_is_as_the_schema_says_and_loses_nothing(name: str) -> None:
    data, plain = answer(name).data(), answer(name).to_dict()
    assert problems(data) == []
    lost = _leaves(plain) - _leaves(data)
    told = [plain.get(name) for name in ("status", "outcome")]  # as the verdict; "none" as a bound that is none
    assert lost <= {"none", *(word for word in told if isinstance(word, str))}


def _leaves(data: Any) -> set[Any]:
    """The texts and the sizes of the numbers in plain data."""
    if isinstance(data, dict | list):
        return set().union(*map(_leaves, data.values() if isinstance(data, dict) else data))
    return {abs(data) if isinstance(data, int | float) else data} - {None, True, False}


def test_every_kind_of_answer_has_its_envelope() -> None:
    report = hf.answers.BatchReport(folder="x", outcomes=Table({"answered": 1, "error": 1}), verdicts=Table({}))
    assert problems(report.data()) == []
    assert report.data()["verdict"] == "undecided"
    firmer = hf.firmer(cube(), "cube", engine="limit", seconds=0.1)
    assert problems(firmer.data()) == []
    assert {type(answer(name)) for name in ASK} | {type(report), type(firmer)} == set(ANSWERS)


@pytest.mark.parametrize("name", ASK)
def test_it_shows_itself_in_short(name: str) -> None:
    value = answer(name)
    assert len(repr(value)) < 1000
    assert "\n" not in repr(value)
    assert " at 0x" not in repr(value)
    page = value._repr_html_()
    assert len(page) < 60_000
    assert _tags(page) <= TAGS


TAGS = {"div", "p", "b", "br", "span", "table", "tr", "th", "td", "img"}
TAGS |= {"svg", "g", "circle", "path", "polygon", "text"}
DRAWING = {"viewbox", "role", "r", "cx", "cy", "x", "y", "d", "points", "text-anchor", "font-size"}
DRAWING |= {"fill", "fill-opacity", "stroke", "stroke-width", "stroke-opacity"}


class _Tags(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.seen: set[str] = set()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = dict(attrs)
        assert given.keys() <= {"style", "alt", "src", "width", "height", *DRAWING}
        assert given.get("src", "data:image/png;base64,").startswith("data:image/png;base64,")
        assert "url" not in given.get("style", "")
        if tag not in ("img", "br"):
            self.open.append(tag)
        self.seen.add(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.handle_starttag(tag, attrs)
        self.handle_endtag(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


def _tags(page: str) -> set[str]:
    parser = _Tags()
    parser.feed(page)
    assert parser.open == []
    return parser.seen


@pytest.mark.parametrize("name", [name for name in ASK if name.startswith("odd")])
def test_names_of_bodies_never_become_part_of_a_page(name: str) -> None:
    page = answer(name)._repr_html_()
    assert "<b>x</b>" not in page
    assert "</script>" not in page
    assert (html.escape("<b>x</b>") in page) == ("stability" not in name)  # whose words name no body that rests


def test_a_page_stays_small_whatever_it_is_told() -> None:
    long = "<" * 100_000
    page = as_html("Map", Summary(long, [(long, long)] * 1000, [long] * 5, [[long] * 5] * 1000, [long] * 1000))
    assert len(page) < 10_000
    assert "<<" not in page


@pytest.mark.parametrize("method", ["fork", "spawn"])
def test_assemblies_go_to_other_processes_and_answers_come_back(method: str) -> None:
    here = {engine: hf.robustness(cube(), "cube", *PUSHES, engine=engine) for engine in ("graph", "limit")}
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context(method)) as pool:
        for engine, value in here.items():
            there, process = pool.submit(_asked, cube(), engine).result()
            assert process != os.getpid()
            assert there == value
            assert [m and m.text for m in there.mechanism] == [m and m.text for m in value.mechanism]
        sent = [answer(name) for name in ("map, limit", "transport", "stability, unstable", "placement", "disassembly")]
        assert list(pool.map(_sent, sent)) == sent


def _asked(assembly: hf.answers.Assembly, engine: str) -> tuple[hf.answers.Robustness, int]:
    return hf.robustness(assembly, "cube", *PUSHES, engine=engine), os.getpid()


def _sent(value: Any) -> Any:
    return value


def test_mechanisms_of_one_state_share_what_their_words_need() -> None:
    assert len(_kinematics(answer("map, limit"))) == 1
    assert len({id(m) for m in answer("map, limit").mechanism if m is not None}) > 3


def test_an_order_of_removals_goes_on_answering_after_a_journey(tmp_path: Path) -> None:
    value = answer("disassembly")
    value.save(tmp_path / "order.json")
    again = hf.load_answer(tmp_path / "order.json")
    assert again.answers(1) == value.answers(1)
    assert again.remaining == value.remaining
    assert again.paper_table() == value.paper_table()


def test_bounds_say_how_they_are_known() -> None:
    known = {name: (answer(name).lower_bound, answer(name).upper_bound) for name in ASK if name.startswith("pushes")}
    none, proved = hf.answers.Bound.NONE, hf.answers.Bound.PROVED
    assert known["pushes, graph"] == (none, none)
    assert known["pushes, compliant"] == (proved, none)
    assert known["pushes, bounded"] == (proved, proved)
    assert known["pushes, limit"] == (proved, proved)
    for cone, expected in (("inscribed", (proved, none)), ("circumscribed", (none, proved))):
        r = hf.robustness(cube(), "cube", SIDE, X, engine=hf.Limit(cone))
        assert (r.lower_bound, r.upper_bound) == expected


@pytest.mark.parametrize(
    "content", [b"", b"{", b"[]", b'{"format": "holdfast-saved/1"}', b"\xef\xbb\xbf", b"PK\x03\x04"]
)
@pytest.mark.parametrize("suffix", [".json", ".npz"])
def test_what_is_no_answer_is_one_clear_error(content: bytes, suffix: str, tmp_path: Path) -> None:
    path = tmp_path / f"bad{suffix}"
    path.write_bytes(content)
    with pytest.raises(hf.HoldfastError, match=f"bad{suffix}"):
        hf.load_answer(path)


def test_every_class_that_can_be_saved_can_be_read_back() -> None:
    """The report of a batch could be saved only."""
    savable = {each for each in NAMES.values() if isinstance(each, type) and hasattr(each, "save")}
    assert savable == set(ANSWERS)
    assert hf.answers.BatchReport in savable


def test_a_file_of_something_else_is_refused(tmp_path: Path) -> None:
    save(cube(), tmp_path / "cube.json")
    with pytest.raises(hf.HoldfastError, match="holds a Assembly; needs an answer"):
        hf.load_answer(tmp_path / "cube.json")


PICTURED = ["map, limit", "transport", "disassembly", "placement", "placements", "settled", "resting poses", "carried"]


@pytest.mark.parametrize("name", PICTURED)
def test_pictures(name: str, tmp_path: Path) -> None:
    value = answer(name)
    if name == "transport":
        value = hf.transport_limits(cube(), engine="limit")
    value.save_png(tmp_path / "answer.png")
    assert (tmp_path / "answer.png").read_bytes().startswith(b"\x89PNG")
    with pytest.raises(hf.HoldfastError, match=r"needs|name a \.png file"):
        value.save_png(tmp_path / "answer.jpg")
