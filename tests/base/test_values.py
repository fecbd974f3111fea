"""Values carry, copy, compare and save without loss."""

from __future__ import annotations

import copy
import json
import pickle
from enum import StrEnum, auto
from functools import cached_property
from pathlib import Path

import numpy as np
import pytest

from holdfast.base import archive
from holdfast.base.archive import archived, load, save, to_dict
from holdfast.base.arrays import Float, Objects
from holdfast.base.errors import HoldfastError
from holdfast.base.public import Of, PublicValue, Record, column
from holdfast.base.values import Table, sealed


@archived
class Colour(StrEnum):
    RED = auto()


class Piece(Record):
    weights: Float


class Whole(Record):
    name: str
    share: float
    colour: Colour
    part: Piece | None
    again: Piece | None
    numbers: Float
    told: Objects
    table: Table[tuple[str, str], float]
    flags: tuple[bool, ...] = (True, False)

    @cached_property
    def twice(self) -> Float:
        return self.numbers * 2


def whole(share: float = np.inf, count: int = 5) -> Whole:
    part = Piece(sealed(np.array([0.1, np.inf, -0.0])))
    told = np.empty(3, dtype=object)
    told[:] = [Colour.RED, None, ("a", "b")]
    numbers = np.linspace(0, 1, count) ** 3
    return Whole("crate", share, Colour.RED, part, part, sealed(numbers), sealed(told), Table({("a", "b"): 0.3}))


def roundtrips(value: Whole, folder: Path) -> list[Whole]:
    results = [pickle.loads(pickle.dumps(value)), copy.deepcopy(value)]
    for suffix in (".json", ".npz"):
        save(value, folder / f"value{suffix}")
        results.append(load(folder / f"value{suffix}"))
    return results


@pytest.mark.parametrize("count", [0, 5, 1000])
def test_nothing_is_lost(tmp_path: Path, count: int) -> None:
    value = whole(count=count)
    assert value.twice.shape == (count,)
    for other in roundtrips(value, tmp_path):
        assert other == value
        assert hash(other) == hash(value)
        assert other is not value
        assert other.numbers.tobytes() == value.numbers.tobytes()
        assert other.part is other.again  # what was shared stays shared
        assert "twice" not in vars(other)
        with pytest.raises(ValueError, match="read-only"):
            other.numbers[:] = 0
        assert isinstance(other.colour, Colour)
        assert other.part is not None
        assert np.signbit(other.part.weights[2])


@pytest.mark.parametrize("change", [{"share": 1.0}, {"count": 4}])
def test_a_difference_is_seen(change: dict) -> None:
    assert whole() != whole(**change)
    assert whole() != "crate"


def test_text_stays_short() -> None:
    value = whole(count=100_000)
    assert len(repr(value)) < 1000
    assert len(repr(Table({str(k): float(k) for k in range(10_000)}))) < 1000


def test_tables_read_like_dicts_and_no_zero_is_negative() -> None:
    assert repr(Table({"overlaps": 3, "share": -0.0})) == "{'overlaps': 3, 'share': 0.0}"
    assert repr(Piece(sealed(np.array([-0.0, 1.0])))) == "Piece(weights=[0., 1.])"


def test_plain_data_is_json() -> None:
    data = to_dict(whole())
    assert json.loads(json.dumps(data, allow_nan=False)) == data
    assert data["share"] == "inf"
    assert data["told"] == ["red", None, ["a", "b"]]
    assert data["table"] == {"a-b": 0.3}


def test_a_record_tells_what_its_parts_know_and_has_no_truth() -> None:
    class Crate(PublicValue, ask=".share or .name"):
        whole: Whole
        sizes: Float = column("n", default=None)

        name = Of[str]("whole.name", "The name of the crate.")
        plain = "name sizes"

    crate = Crate(whole=whole())
    assert crate.name == "crate"
    assert Crate.name.__doc__ == "The name of the crate."
    assert crate.to_dict() == {"name": "crate", "sizes": None}
    with pytest.raises(AttributeError):
        crate.name = "box"  # type: ignore[assignment]
    with pytest.raises(TypeError, match="positional"):
        Crate(whole())  # type: ignore[misc]
    with pytest.raises(HoldfastError, match=r"bool\(\) of Crate: .*; ask \.share or \.name"):
        bool(crate)


def test_a_field_that_a_file_lacks_is_refused_unless_older_files_have_none(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Then it takes its default; to take one elsewhere would read a damaged file as if it said so."""
    path = tmp_path / "value.json"
    save(whole(), path)
    data = json.loads(path.read_text())
    del data["value"]["fields"]["flags"]  # which has a default
    path.write_text(json.dumps(data))
    with pytest.raises(HoldfastError, match="other fields"):
        load(path)
    monkeypatch.setitem(archive.NEW, "Whole", {"flags"})
    assert load(path) == whole()
    del data["value"]["fields"]["name"]
    path.write_text(json.dumps(data))
    with pytest.raises(HoldfastError, match="other fields"):
        load(path)


def test_a_table_cannot_be_changed() -> None:
    table = Table({"a": 1.0})
    with pytest.raises(TypeError):
        table["a"] = 2.0  # type: ignore[index]
    assert table == {"a": 1.0}


def test_a_file_cannot_name_other_classes(tmp_path: Path) -> None:
    path = tmp_path / "value.json"
    save(whole(), path)
    path.write_text(path.read_text().replace('"Whole"', '"Path"'))
    with pytest.raises(HoldfastError, match="not known"):
        load(path)


def test_what_cannot_be_saved_says_so_and_leaves_nothing(tmp_path: Path) -> None:
    told = np.empty(1, dtype=object)
    told[0] = print
    value = Whole("x", 0.0, Colour.RED, None, None, np.zeros(1), told, Table())
    with pytest.raises(HoldfastError, match="cannot be saved"):
        save(value, tmp_path / "value.json")
    with pytest.raises(HoldfastError, match="suffix"):
        save(value, tmp_path / "value.txt")
    assert list(tmp_path.iterdir()) == []
