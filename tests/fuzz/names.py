"""Hostile names: markup, control characters, writing directions, surrogates, lengths, and what other programs take."""

from __future__ import annotations

from typing import Any

from fuzz.draw import Rng, chance, one_of
from fuzz.spoken import OUTPUTS, SLOW

PIECES = (
    *("[/]", "[red]x[/red]", "[link=http://a.example]b[/link]", "[bold", "]", "\\[", "{x}", "{0}", "%s", "%n", "$x_1$"),
    *("$", "\\frac{", "<script>alert(1)</script>", "<b>", "</td>", "&amp;", "&", "'", '"', "`", "\\", "/", "../.."),
    *("|", "\x1b[31m", "\x1b]0;t\x07", "\x07", "\x08\x08", "\r", "\n", "\n\n", "\t", "\0", "\x7f", "\x85", "\u2028"),
    *("\u2029", "\u202e", "\u2066", "\u200f", "\u200b", "\ufeff", "\ud800", "\udfff", "\U0001f9f1", "\u0301" * 30),
    *("é", "名前", "ﷺ", "a" * 300, "a b " * 500, "x" * 5000, " ", "  ", "-", "--help", "none", "null", "true", "1e5"),
    *("0", "~", ":", "#", "- ", "floor", "b", "b x", ",", ";", "=", "*", "?", "!important", "url(x)", "con", "nul"),
    *(".", "..", "CON.txt", "$(ls)"),
)


def name(rng: Rng) -> dict[str, Any]:
    """Draw a name of one to four hostile pieces among plain ones, and the output that it is written to."""
    parts = [one_of(rng, PIECES) for _ in range(int(rng.integers(1, 5)))]
    if chance(rng, 0.3):
        parts += [chr(int(rng.integers(0x10FFFF))) for _ in range(int(rng.integers(1, 6)))]
    if chance(rng, 0.5):
        parts.insert(int(rng.integers(len(parts) + 1)), "body")
    output = one_of(rng, OUTPUTS)
    if output in SLOW and chance(rng, 0.8):
        output = "error"
    return {"name": "".join(parts), "output": output}
