"""Golden answers: keep those of one source tree bit for bit, print how another one's differ, accept them as text.

    PYTHONPATH=src python tools/golden.py save before.json
    PYTHONPATH=src python tools/golden.py compare before.json     # prints every difference, ends with 1 if there is one
    PYTHONPATH=src python tools/golden.py accept --why "..."      # rewrites tests/golden/answers, and logs the reason
    PYTHONPATH=src python tools/golden.py accept before.json --why "..."   # with kept ones, without asking again

The answers are those of the ``holdfast`` that PYTHONPATH leads to. ``--quick`` asks for a part of them, ``--topic`` for
single files of answers. What was accepted, and why, is in tests/golden/CHANGES.md. Bits are those of one machine:
processors differ in the last digits.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "golden"))

import record

import holdfast


def differences(old: Any, new: Any, path: str = "") -> Iterator[tuple[str, str, str]]:  # noqa: ANN401
    """(path, old, new) of all that is not the same, floats to the last bit."""
    if isinstance(old, dict) and isinstance(new, dict):
        for key in sorted({*old, *new}):
            if key not in old or key not in new:
                yield f"{path}/{key}", shown(old, key), shown(new, key)
            else:
                yield from differences(old[key], new[key], f"{path}/{key}")
    elif isinstance(old, list) and isinstance(new, list) and len(old) == len(new):
        for k, (a, b) in enumerate(zip(old, new, strict=True)):
            yield from differences(a, b, f"{path}[{k}]")
    elif json.dumps(old) != json.dumps(new):  # repr of floats: exact, and it tells -0.0 from 0.0
        yield path, json.dumps(old, ensure_ascii=False), json.dumps(new, ensure_ascii=False)


def shown(data: dict[str, Any], key: str) -> str:
    """One entry, or that it is not there."""
    return json.dumps(data[key], ensure_ascii=False) if key in data else "(absent)"


def computed(topics: list[str]) -> dict[str, Any]:
    """The answers of the code at hand."""
    print(f"answers of {Path(holdfast.__file__).parent}", flush=True)
    answers = {}
    for topic in topics:
        start = time.perf_counter()
        answers[topic] = record.TOPICS[topic]()
        print(f"  {topic} {time.perf_counter() - start:.1f} s", flush=True)
    return answers


def kept(file: Path, topics: list[str]) -> dict[str, Any]:
    """The answers in a file that ``save`` wrote."""
    answers = json.loads(file.read_text(encoding="utf-8"))
    missing = [topic for topic in topics if topic not in answers]
    if missing:
        sys.exit(f"{file} has no {', '.join(missing)}: ask for others by --quick or --topic")
    return {topic: answers[topic] for topic in topics}


def report(old: dict[str, Any], new: dict[str, Any], most: int) -> int:
    """Print what differs between answers to the same topics; how many."""
    found = list(differences(old, new))
    for path, before, after in found[:most]:
        print(f"{path}: {before[:200]} -> {after[:200]}")
    if len(found) > most:
        print(f"... and {len(found) - most} more (--most)")
    print(f"{len(found)} differences in {len(new)} topics")
    return len(found)


def main() -> int:
    """Run one command."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("command", choices=["save", "compare", "accept"])
    parser.add_argument("file", nargs="?", type=Path)
    parser.add_argument("--quick", action="store_true", help=f"only {', '.join(record.QUICK)}")
    parser.add_argument("--topic", action="append", choices=list(record.TOPICS), help="only this one; may be repeated")
    parser.add_argument("--most", type=int, default=200, help="differences to print")
    parser.add_argument("--why", help="why other answers are right, for the log; accept needs it")
    options = parser.parse_args()
    topics = options.topic or list(record.QUICK if options.quick else record.TOPICS)
    if options.command == "accept":
        if len((options.why or "").split()) < 4:
            parser.error("accept needs a reason: --why, in a sentence")
        before = record.mark()
        for topic, answers in (computed(topics) if options.file is None else kept(options.file, topics)).items():
            record.FOLDER.mkdir(exist_ok=True)
            (record.FOLDER / f"{topic}.json").write_text(record.as_text(answers) + "\n", encoding="utf-8")
        if record.mark() != before:
            with record.LOG.open("a", encoding="utf-8") as log:
                log.write(f"- {record.mark()}: {' '.join(options.why.split())}\n")
        return 0
    if options.file is None:
        parser.error(f"{options.command} needs a file")
    if options.command == "save":
        answers = computed(topics)
        options.file.write_text(record.as_text(answers) + "\n", encoding="utf-8")
        return 0
    return 1 if report(kept(options.file, topics), computed(topics), options.most) else 0


if __name__ == "__main__":
    sys.exit(main())
