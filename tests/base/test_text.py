"""Names and texts that leave holdfast: on one line, printable, not too long (findings D2, D6, D7, D15, D21)."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from holdfast.base.errors import SceneError, located, message
from holdfast.base.text import DOTS, escaped, is_text, listed, many, one_line, quoted

ANY = st.text(st.characters(), max_size=300)  # lone surrogates among them


@given(ANY, st.integers(10, 500))
def test_d7_any_text_is_printable_and_short(text: str, most: int) -> None:
    shown = one_line(text, most)
    assert shown.isprintable()
    assert len(shown) <= most
    shown.encode("utf-8")


@given(st.text(st.characters(min_codepoint=32, max_codepoint=126), max_size=100))
def test_an_ordinary_text_stays_as_it_is(text: str) -> None:
    assert one_line(text, 100) == text


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("a\x1b[31mb", "a\\x1b[31mb"),
        ("a\nb\tc\rd", "a\\nb\\tc\\rd"),
        ("pay\u202e1", "pay\\u202e1"),
        ("a\u2066b", "a\\u2066b"),
        ("a\ud800b", "a\\ud800b"),
        ("a\u00a0b\u3000c", "a b c"),
        ("a\u2028b", "a\\u2028b"),
        ("[red]x[/red] Teller 日本 ∞", "[red]x[/red] Teller 日本 ∞"),
    ],
)
def test_d7_d15_what_has_no_glyph_is_written_out(text: str, shown: str) -> None:
    assert one_line(text) == shown


def test_d6_of_a_long_text_both_ends_are_left() -> None:
    shown = one_line("begin" + "x" * 1600 + "end", 60)
    assert len(shown) == 60
    assert shown.startswith("beginxxx")
    assert shown.endswith("xxxend")
    assert DOTS in shown


def test_d21_markup_of_pages_is_escaped() -> None:
    assert escaped("<img src=x onerror='1'>\n") == "&lt;img src=x onerror='1'&gt;\\n"


def test_a_value_whose_repr_fails_is_named_by_its_class() -> None:
    class Odd:
        def __repr__(self) -> str:
            raise RuntimeError

    assert quoted(Odd()) == "<Odd>"
    assert quoted(10**5000) == "<int>"
    assert quoted("a'b") == '"a\'b"'


def test_a_list_of_names_is_cut_and_counted() -> None:
    assert listed(["a\n", "b", "c"], 2) == "a\\n, b and 1 more"
    assert listed([f"n{k}" for k in range(2000)], 1) == "n0 and 1,999 more"


def test_messages_keep_to_one_line_of_a_length_that_can_be_read() -> None:
    text = message("p" * 5000 + ".yaml", "is \x1b[2J\n" + "x" * 5000, "go\n")
    assert text.isprintable()
    assert len(text) < 1200
    assert text.endswith("go\\n")
    with pytest.raises(SceneError) as caught, located("w\n" * 5000):
        raise SceneError("it is so")
    assert str(caught.value).isprintable()
    assert len(str(caught.value)) < 300


@given(ANY)
def test_what_counts_as_a_text_can_be_written(text: str) -> None:
    try:
        text.encode("utf-8")
    except UnicodeEncodeError:
        assert not is_text(text)
    else:
        assert is_text(text)


def test_a_number_with_its_noun() -> None:
    assert [many(count, "scene") for count in (0, 1, 1200)] == ["0 scenes", "1 scene", "1,200 scenes"]
