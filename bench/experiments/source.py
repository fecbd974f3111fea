"""What a source is, and how predictions are set beside a number that it prints."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

import holdfast as hf
from bench.suite import Case, Row

G0 = 9.81  # [m/s²]
LADDER = (0.005, 0.02, 0.05, 0.2)  # distances from a printed number, relative, at which verdicts are asked
ENGINES = ("limit", "compliant", "graph")
Build = Callable[[float], hf.Scene]


@dataclass(frozen=True)
class Source:
    """Who measured or printed what, and what is assumed to predict it; ``cases`` set the predictions beside it."""

    name: str
    citation: str
    found: str
    assumed: str
    cases: Callable[[], Mapping[str, Case]]


def row(case: str, printed: str, meant: str, why: str, **predicted: Any) -> Row:  # noqa: ANN401 - numbers or words
    """A printed number or word beside the engines' own; ``meant`` is the engine that asks what the source asks.

    ``why`` is a sentence, needed where they do not agree to the digits that are printed.
    """
    agrees = same(printed, predicted[meant])
    if agrees == bool(why):
        raise ValueError(f"{case}: {printed} beside {predicted[meant]} ({meant}), explained by {why!r}")
    return {"case": case, "printed": printed, "meant": meant, **predicted, "agrees": agrees, "why": why}


def same(printed: str, predicted: Any) -> bool:  # noqa: ANN401 - a number or a word
    """Whether a prediction is what is printed, to half a unit of the last digit there."""
    if isinstance(predicted, str):
        return printed == predicted
    decimals = len(printed.partition(".")[2])
    return bool(abs(predicted - float(printed)) <= 0.505 * 10.0**-decimals)


def least(holds: Callable[[float], bool], falls: float, stands: float, accuracy: float) -> float:
    """The value next to which it begins to hold, between one at which it falls and one at which it stands."""
    while abs(stands - falls) > accuracy:
        middle = (falls + stands) / 2
        falls, stands = (falls, middle) if holds(middle) else (middle, stands)
    return (falls + stands) / 2


def threshold(
    case: str, printed: str, build: Build, ends: tuple[float, float], *, meant: str = "limit", why: str = ""
) -> Row:
    """The value from which on a scene stands, between ``ends`` (one that falls, one that stands).

    For ``limit`` it is where an equilibrium begins to exist, for ``compliant`` where the verdict ceases to be UNSTABLE.
    "falls to %" and "stands from %" are the distances on
    both sides of the printed value beyond which that is UNSTABLE, and STABLE, at every step of LADDER.
    """

    def asked(value: float) -> hf.Status:
        return hf.stability(build(value)).status

    digits = len(printed.partition(".")[2])
    exists = least(lambda x: balances(build(x)), *ends, 0.2 * 10.0**-digits)
    rests = least(lambda x: asked(x) is not hf.Status.UNSTABLE, *ends, 2e-4 * float(printed))
    way = np.sign(ends[1] - ends[0])
    said = {s: asked(float(printed) * (1 + way * s)) for k in LADDER for s in (-k, k)}
    falls = [s for s in said if all(said[t] is hf.Status.UNSTABLE for t in said if t <= s)]
    stands = [s for s in said if all(said[t] is hf.Status.STABLE for t in said if t >= s)]
    ladder = {"falls to %": 100 * max(falls, default=-np.inf), "stands from %": 100 * min(stands, default=np.inf)}
    return row(case, printed, meant, why, limit=exists, compliant=rests) | ladder


def balances(scene: hf.Scene) -> bool:
    """Whether an equilibrium exists, by ``limit``."""
    return hf.stability(scene, engine="limit").equilibrium_exists is True


def stands(scene: hf.Scene, engine: str) -> str:
    """Whether it stands, in a word: by ``limit`` and ``graph`` whether an equilibrium exists, else the verdict."""
    verdict = hf.stability(scene, engine=engine)
    if engine == "compliant":
        return {hf.Status.STABLE: "stands", hf.Status.UNSTABLE: "falls"}.get(verdict.status, "undecided")
    return "stands" if verdict.equilibrium_exists else "falls"


def level_acceleration(scene: hf.Scene, engine: str) -> float | str:
    """The least acceleration along x, either way, at which it moves [g], or that the engine refuses."""
    try:
        found = hf.transport_limits(scene, directions=[(1, 0, 0), (-1, 0, 0)], engine=engine)
    except hf.HoldfastError:
        return "refused"
    return float(found.acceleration.min()) / G0


def block(name: str, size: tuple[float, float, float], at: tuple[float, float, float], **more: Any) -> hf.Body:  # noqa: ANN401
    """A box with its middle ``at``, of 2,000 kg/m³ unless ``more`` says otherwise."""
    return hf.Body(name, hf.Box(size), position=at, **(more if "fixed" in more else {"density": 2000.0} | more))
