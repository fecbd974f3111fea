"""``python -m fuzz COUNT``: try that many inputs, after those of earlier runs with the same seed and folder."""

from __future__ import annotations

import argparse
import signal
import sys
from pathlib import Path

from fuzz.campaign import SHARES, campaign, item_of, summary
from fuzz.keeper import MEGABYTES, SECONDS, Keeper
from fuzz.spoken import json_text
from fuzz.store import Store


def main() -> int:
    parser = argparse.ArgumentParser(prog="fuzz", description=__doc__)
    parser.add_argument("count", type=int)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--kinds", nargs="+", choices=[*SHARES], default=[*SHARES])
    parser.add_argument("--folder", type=Path, default=Path("out/fuzz"))
    parser.add_argument("--show", metavar="KIND:NUMBER", help="print one input and how its trial ends, and stop")
    parser.add_argument("--quiet", action="store_true", help="print the sums at the end only")
    asked = parser.parse_args()
    with Keeper(seconds=SECONDS, megabytes=MEGABYTES) as keeper:
        if asked.show:
            kind, number = asked.show.split(":")
            item = item_of(asked.seed, kind, int(number))
            print(json_text(item), keeper.tried(item), sep="\n")  # noqa: T201
            return 0
        store = Store(asked.folder, asked.seed)
        with store.locked():
            bad = campaign(store, asked.kinds, asked.count, (lambda _: None) if asked.quiet else said, keeper)
    print(f"seed {asked.seed}, {asked.count:,} more:\n{summary(store)}")  # noqa: T201
    return 1 if bad else 0


def said(text: str) -> None:
    print(text, file=sys.stderr, flush=True)  # noqa: T201


if __name__ == "__main__":
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        sys.exit(main())
    except KeyboardInterrupt:
        sys.exit("stopped; the state is kept")
    except BlockingIOError:
        sys.exit("another process is at this seed in this folder: take another seed")
