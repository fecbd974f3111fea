"""Bars and histograms of pages: shares and values are those that were given."""

from __future__ import annotations

import re

import numpy as np

from holdfast.drawing.svg import bar, histogram


def test_a_logarithmic_histogram_is_labelled_with_values_and_counts_the_rest_aside() -> None:
    text = histogram("weakest push", [0.01, 1.0, 1.0, 100.0, 0.0, np.inf], "N", logarithmic=True)
    assert "<h3>weakest push [N]</h3>" in text
    assert "4 scenes, 1 infinite, 1 at 0" in text
    assert re.findall(r"<text [^>]*>([^<]+)</text>", text) == ["0.01", "1", "100"]
    counts = [int(count) for count in re.findall(r"<title>(\d+)</title>", text)]
    assert (counts[0], counts[12], counts[-1], sum(counts)) == (1, 2, 1, 4)


def test_a_bar_is_divided_by_shares() -> None:
    text = bar({"stable": 3, "<unstable>": 1}, {"stable": "#123456"})
    places = [tuple(map(float, pair)) for pair in re.findall(r'<rect x="([\d.]+)" y="0" width="([\d.]+)"', text)]
    assert places == [(0, 345), (345, 115)]
    assert "stable 3 (75.0%)" in text
    assert "&lt;unstable&gt; 1 (25.0%)" in text
    assert bar({"stable": 0}, {}) == ""
