"""Colours for the texts of what gives way first, which are the same throughout a picture."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import Final

COLOURS: Final = ("#b5173f", "#0b6aa8", "#d9820f", "#3d8f5f", "#7a4fa3", "#8a5a2b", "#1aa3a3", "#d457a0", "#5b6470")
OTHERS: Final = "#b0b6bf"  # the colour of all further texts


def colours_of(words: Sequence[str]) -> dict[str, str]:
    """Return a colour for each text except "", in the order of frequency; the rarest share one colour."""
    often = Counter(word for word in words if word)
    ranked = sorted(often, key=lambda word: (-often[word], list(words).index(word)))
    return {word: COLOURS[k] if k < len(COLOURS) else OTHERS for k, word in enumerate(ranked)}
