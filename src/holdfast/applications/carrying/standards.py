"""Accelerations that cargo has to withstand, as public sources state them. They imply no claim of compliance.

Every number is from a source that could be read, which the entry names. The coefficients of EN 12195-1 for rail and sea
and those of IATA for unit load devices are missing because no public source was found; give them as a table of your own
(``Profile.from_table``).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

G = 9.80665  # [m/s²] standard gravity, the unit in which most sources state accelerations

Side = Literal["forwards", "backwards", "left", "right", "up", "down"]


@dataclass(frozen=True)
class Standard:
    """The accelerations of one standard.

    ``cargo`` holds pairs of the side to which cargo is thrown, seen from the driver, and the acceleration [m/s²]; the
    carrier accelerates the other way. ``sources`` are the pages from which the numbers were taken.
    """

    title: str
    sources: tuple[str, ...]
    cargo: tuple[tuple[Side, float], ...]


def _all_round(forwards: float, backwards: float, sideways: float) -> tuple[tuple[Side, float], ...]:
    return ("forwards", forwards), ("backwards", backwards), ("left", sideways), ("right", sideways)


_BENCH = (
    "https://en.wikipedia.org/wiki/Acceleration_test (0.3 s or longer, reached within 50 ms; mostly 0.5 g)",
    "http://www.safeloadtesting.com/stability-testing/ (k g for at least 0.3 s, reached within 0.05 s)",
)
_ANNEX_13 = (
    "https://puc.overheid.nl/doc/PUC_2092_14/2, table 2 (basic acceleration data of annex 13, before corrections for "
    "length, speed and metacentric height; transverse figures include gravity parallel to the deck)",
)

STANDARDS: Mapping[str, Standard] = {
    "eumos40509_0.5g": Standard(
        "acceleration bench in the manner of EUMOS 40509, 0.5 g", _BENCH, (("backwards", 0.5 * G),)
    ),
    "eumos40509_0.8g": Standard(
        "acceleration bench in the manner of EUMOS 40509, 0.8 g",
        (*_BENCH, "https://www.safeloadtesting.com/en/acceleration-test/ (0.8 g in the direction of travel)"),
        (("backwards", 0.8 * G),),
    ),
    "road": Standard(
        "road, as in EN 12195-1: 0.8 g forwards, 0.5 g backwards and sideways, 1 g downwards throughout",
        (
            "https://tis-gdv.de/tis/ls/ls_im_strassenverkehr/kapitel01.html (GDV: consensus in Germany and elsewhere)",
            "https://www.kuljettaja.net/hakemisto/kiihtyvyyskerroin/ (the same numbers, as those of SFS-EN 12195-1)",
        ),
        _all_round(0.8 * G, 0.5 * G, 0.5 * G),
    ),
    "rail_aar": Standard(
        "rail, loading restraint factors recommended by the Association of American Railroads",
        ("TM 55-3930-660-14, appendix B: https://constructionforklifts.tpub.com/TM-55-3930-660-14/",),
        (*_all_round(3 * G, 3 * G, 2 * G), ("up", 2 * G), ("down", 2 * G)),
    ),
    "sea_msc": Standard(
        "sea, design factors of the Military Sealift Command for severe conditions",
        ("TM 55-3930-660-14, appendix B: https://constructionforklifts.tpub.com/TM-55-3930-660-14/",),
        (*_all_round(0.7 * G, 0.7 * G, 1.2 * G), ("up", 0.2 * G), ("down", 0.2 * G)),
    ),
    "sea_on_deck": Standard(
        "sea, CSS Code annex 13, on deck high, the worst place along the ship",
        _ANNEX_13,
        (*_all_round(3.8, 3.8, 7.4), ("up", 9.2), ("down", 9.2)),
    ),
    "sea_tween_deck": Standard(
        "sea, CSS Code annex 13, tween deck amidships",
        _ANNEX_13,
        (*_all_round(2.0, 2.0, 5.4), ("up", 4.3), ("down", 4.3)),
    ),
    "air_emergency": Standard(
        "air, ultimate inertia forces of an emergency landing, 14 CFR 25.561",
        ("http://federal.elaws.us/cfr/title-14/section-25.561 (b)(3)",),
        (*_all_round(9 * G, 1.5 * G, 3 * G), ("up", 3 * G), ("down", 6 * G)),
    ),
}
