"""What a campaign keeps: how far it is, how its trials ended, and the smallest input for each defect."""

from __future__ import annotations

import fcntl
import hashlib
import json
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from fuzz.outcome import Outcome

SLOWEST = 5  # numbers of the slowest trials that are kept


@dataclass
class Tally:
    """The trials of one kind: the ``next`` number, ``counts`` of endings, ``signs`` of defects, time and memory."""

    next: int = 0
    counts: Counter[str] = field(default_factory=Counter)
    signs: Counter[str] = field(default_factory=Counter)
    seconds: float = 0.0
    peak: float = 0.0
    slowest: list[tuple[float, int]] = field(default_factory=list)

    def add(self, number: int, found: Outcome) -> None:
        self.next = number + 1
        self.counts[found.ending] += 1
        if not found.good:
            self.signs[f"{found.ending}: {found.sign}"] += 1
        self.seconds += found.seconds
        self.peak = max(self.peak, found.peak)
        self.slowest = sorted([*self.slowest, (found.seconds, number)])[-SLOWEST:]

    @classmethod
    def of(cls, data: dict[str, Any]) -> Tally:
        counters = {name: Counter(data[name]) for name in ("counts", "signs")}
        return cls(**{**data, **counters, "slowest": [(s, n) for s, n in data["slowest"]]})


class Store:
    """A folder with one state file a seed, and one file for each defect."""

    def __init__(self, folder: Path, seed: int) -> None:
        self.folder, self.seed = folder, seed
        folder.mkdir(parents=True, exist_ok=True)
        self._state = folder / f"state-{seed}.json"
        data = json.loads(self._state.read_text()) if self._state.exists() else {}
        self.tallies = {kind: Tally.of(entry) for kind, entry in data.items()}

    @contextmanager
    def locked(self) -> Iterator[None]:
        """Let no other process work on this state meanwhile; raise BlockingIOError if one does."""
        with self._state.with_suffix(".lock").open("w") as stream:
            fcntl.flock(stream, fcntl.LOCK_EX | fcntl.LOCK_NB)
            yield

    def tally(self, kind: str) -> Tally:
        return self.tallies.setdefault(kind, Tally())

    def save(self) -> None:
        """Write the state, completely or not at all."""
        new = self._state.with_suffix(".new")
        new.write_text(json.dumps({kind: vars(tally) for kind, tally in self.tallies.items()}, indent=1))
        new.replace(self._state)

    def known(self, kind: str, found: Outcome) -> bool:
        return self._path(kind, found).exists()

    def keep(self, item: dict[str, Any], found: Outcome, number: int) -> Path:
        """Keep an input that shows a defect, as ``test_found`` reads it."""
        path = self._path(item["kind"], found)
        told = {"ending": found.ending, "sign": found.sign, "seed": self.seed, "number": number, "detail": found.detail}
        path.write_text(json.dumps({"item": item, **told}, indent=1) + "\n")
        return path

    def _path(self, kind: str, found: Outcome) -> Path:
        digest = hashlib.sha256(found.sign.encode()).hexdigest()[:8]
        return self.folder / f"{found.ending}-{kind}-{digest}.json"
