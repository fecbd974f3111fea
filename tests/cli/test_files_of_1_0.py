"""What 1.0.0 wrote is read by every 1.x: scenes, batches, certificates, and programs that know its JSON.

``contracts/files_of_1_0`` holds a scene with all that a file can say, a batch, a certificate, and the schema of JSON,
as 1.0.0 wrote them. Answers are in ``contracts/saved``. These files never change.
"""

from __future__ import annotations

import gzip
import json
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from calling import Call

import holdfast as hf

FILES = Path(__file__).parents[1] / "contracts" / "files_of_1_0"


def test_a_scene_says_what_it_said() -> None:
    scene = hf.load_scene(FILES / "scene.yaml")
    assert scene == hf.load_scene(FILES / "scene.json")
    jar, cap, crate, wedge = scene.bodies[1:]
    assert [body.name for body in scene.bodies] == ["shelf", "jar", "cap", "crate", "wedge"]
    assert [body.fixed for body in scene.bodies] == [True, False, False, False, False]
    assert [body.mass for body in (jar, cap, crate, wedge)] == [0.7, 0.1, 2.5, 0.2]
    assert jar.pose[:2, :2] == pytest.approx(np.array([[0.8660254, -0.5], [0.5, 0.8660254]]), abs=1e-7)
    assert cap.pose[:3, 1] == pytest.approx([0, 0, 1])  # 90 degrees about x
    assert crate.com_body == pytest.approx([0, 0.01, -0.02])
    assert (cap.top_load, crate.pressure) == (200.0, 5000.0)
    assert [type(body.shape).__name__ for body in scene.bodies] == ["Box", "Cylinder", "Capsule", "Compound", "Mesh"]
    assert scene.excluded
    assert (scene.holds[0].body, scene.holds[0].mu) == ("jar", 0.4)
    pairs = {frozenset(each.bodies): each for each in hf.assemble(scene).interfaces}
    mu = dict(zip(pairs, hf.assemble(scene).mu, strict=True))
    assert mu[frozenset({"shelf", "jar"})] == 0.3
    assert mu[frozenset({"shelf", "cap"})] == 0.35
    assert mu[frozenset({"shelf", "crate"})] == 0.5


def test_a_batch_tells_what_it_told(tmp_path: Path, call: Call) -> None:
    shutil.copytree(FILES / "batch", tmp_path / "batch")
    (row,) = hf.read_batch(tmp_path / "batch").data()
    assert (row["verdict"], row["details"]["scene"], row["details"]["engine"]) == ("stable", "table.yaml", "limit")
    assert call("report", tmp_path / "batch")[0] == 0


def test_a_certificate_is_verified(call: Call) -> None:
    code, out, _ = call("verify", FILES / "certificate.json")
    assert code == 0
    assert "up to 6.22677375 N along (0, 1, 0) on 'slab'" in " ".join(out.split())


def lost(before: Any, now: Any, where: str = "") -> Iterator[str]:
    """Where what a program could rely on is gone: keys, required keys, types, words."""
    if isinstance(before, dict):
        if not isinstance(now, dict):
            yield where
            return
        for key, value in before.items():
            if key in ("description", "title"):
                continue
            if key not in now:
                yield f"{where}/{key}"
            elif key == "required":
                yield from (f"{where}/required/{each}" for each in set(value) - set(now[key]))
            else:
                yield from lost(value, now[key], f"{where}/{key}")
    elif isinstance(before, list) and isinstance(now, list):
        told = [json.dumps(each, sort_keys=True) for each in now]
        if any(isinstance(each, dict) for each in before) and len(before) == len(now):
            for k, (one, other) in enumerate(zip(before, now, strict=True)):
                yield from lost(one, other, f"{where}/{k}")
        else:
            yield from (f"{where}: {each}" for each in before if json.dumps(each, sort_keys=True) not in told)
    elif before != now:
        yield f"{where}: {before!r} became {now!r}"


def test_programs_that_know_the_json_of_1_0_find_all_they_know(call: Call) -> None:
    before = json.loads(gzip.decompress((FILES / "answer.schema.json.gz").read_bytes()))
    now = json.loads(call("schema", "answer")[1])
    assert list(lost(before, now)) == []


def test_a_key_that_goes_is_noticed() -> None:
    before = {"properties": {"a": {"type": "string", "enum": ["x", "y"]}}, "required": ["a"]}
    longer = {"properties": {"a": {"type": "string", "enum": ["x", "y", "z"]}, "b": {}}, "required": ["a", "b"]}
    assert list(lost(before, longer)) == []
    assert list(lost(longer, before)) == ["/properties/a/enum: z", "/properties/b", "/required/b"]
    assert list(lost({"type": "string"}, {"type": "number"})) == ["/type: 'string' became 'number'"]
