"""Makes names and other texts from users safe to display.

Every name that holdfast shows on a terminal, a page, a picture or in an error message goes through ``one_line``: it
cannot move the cursor, reverse the reading direction, break a line or fill a screen. Markup is escaped for each medium:
pages use ``escaped``, terminals ``rich.text.Text``, and pictures text without formulas.
"""

from __future__ import annotations

import html
import unicodedata
from collections.abc import Collection
from itertools import islice
from typing import Any

LONGEST_NAME = 60  # largest number of characters of a name among others, as in a table or a list
LONGEST_ITEM = 160  # largest number of characters of an item of a list, such as a pair of names with a place
LONGEST_LINE = 400  # largest number of characters of a sentence
DOTS = "..."  # stands for what was left out


def one_line(text: object, most: int = LONGEST_LINE) -> str:
    r"""Return ``text`` on one line of at most ``most`` characters, all of them printable.

    Spaces of any kind become plain spaces. Line breaks, control characters, characters that reverse the reading
    direction, lone surrogates and all others without a glyph are escaped as in Python, ``\n`` or ``\u202e``. The middle
    of a longer text is left out, because file names and numbers are at its ends.
    """
    given = text if isinstance(text, str) else str(text)
    if len(given) > most:
        given = _ends(given, most)
    if not given.isprintable():
        given = "".join(c if c.isprintable() else _written(c) for c in given)
    return _ends(given, most)


def quoted(value: object, most: int = LONGEST_NAME) -> str:
    """Return the ``repr`` of a value from outside on one line: names in quotes, so that their ends can be seen.

    A value that cannot be written that way is named by its class.
    """
    try:
        return one_line(repr(value), most)
    except Exception:  # a foreign class may do anything here, and an integer may have too many digits
        return f"<{type(value).__name__}>"


def escaped(text: object, most: int = LONGEST_LINE) -> str:
    """Return ``one_line`` of a text, escaped for HTML.

    It is for text, not for attributes: quotes are not escaped.
    """
    return html.escape(one_line(text, most), quote=False)


def listed(names: Collection[str], most: int = 6) -> str:
    """Return the first ``most`` names as one text, each made printable, with the number of the others."""
    more = f" and {len(names) - most:,} more" if len(names) > most else ""
    return ", ".join(one_line(name, LONGEST_ITEM) for name in islice(names, most)) + more


def many(count: int, what: str) -> str:
    """Return a number with its noun: "1 scene", "1,200 scenes"."""
    return f"{count:,} {what}" + ("" if count == 1 else "s")


def _ends(text: str, most: int) -> str:
    if len(text) <= most:
        return text
    last = (most - len(DOTS)) // 3
    return text[: most - len(DOTS) - last] + DOTS + text[len(text) - last :]


def _written(character: str) -> str:
    if unicodedata.category(character) == "Zs":
        return " "
    return character.encode("unicode_escape").decode("ascii")


def is_text(value: Any) -> bool:  # noqa: ANN401 - anything a caller may pass
    """Say whether ``value`` is a text that files can hold: one without lone surrogates."""
    return isinstance(value, str) and not any("\ud800" <= c <= "\udfff" for c in value)
