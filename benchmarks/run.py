"""Run the benchmarks: ``python -m benchmarks.run [SUITE ...] [--save] [--compare]``; all suites unless named."""

from __future__ import annotations

import argparse
import json
import os
import platform
from pathlib import Path
from typing import Any

from benchmarks import accuracy, compliant_maps, contacts, growth, maps, pipeline, reliability

SUITES = {
    "accuracy": accuracy.measure,
    "contacts": contacts.measure,
    "pipeline": pipeline.measure,
    "maps": maps.measure,
    "compliant": compliant_maps.measure,
    "growth": growth.measure,
    "reliability": reliability.measure,
}
PLOTS = {"growth": growth.plot, "contacts": contacts.plot}
RESULTS = Path(__file__).parent / "results"


def machine() -> dict[str, Any]:
    import numba
    import numpy

    return {
        "processor": platform.processor() or platform.machine(),
        "cores": os.cpu_count(),
        "python": platform.python_version(),
        "numpy": numpy.__version__,
        "numba": numba.__version__,
    }


def table(rows: list[dict[str, Any]]) -> str:
    """Rows as a Markdown table."""
    heads = list(dict.fromkeys(key for row in rows for key in row))
    lines = ["| " + " | ".join(heads) + " |", "|" + "---|" * len(heads)]
    for row in rows:
        values = [row.get(head, "") for head in heads]
        cells = [f"{v:.3g}" if isinstance(v, float) else str(v) for v in values]
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines)


def compare(name: str, rows: list[dict[str, Any]]) -> None:
    """Print the ratio of every time to the saved one."""
    path = RESULTS / f"{name}.json"
    if not path.exists():
        print(f"nothing saved for {name}")
        return
    saved = {row["case"]: row for row in json.loads(path.read_text())["rows"]}
    for row in rows:
        for key, value in row.items():
            before = saved.get(row["case"], {}).get(key)
            if key.endswith(" s") and isinstance(before, float) and before > 0:
                print(f"{name}, {row['case']}, {key}: {value / before:.2f} x the saved {before:.3g}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("suites", nargs="*", metavar="SUITE", help=", ".join(SUITES))
    parser.add_argument("--save", action="store_true", help="write benchmarks/results")
    parser.add_argument("--compare", action="store_true", help="show ratios to the saved results")
    options = parser.parse_args()
    unknown = set(options.suites) - set(SUITES)
    if unknown:
        parser.error(f"unknown suite {unknown.pop()!r}; known: {', '.join(SUITES)}")
    for name in options.suites or SUITES:
        rows = SUITES[name]()
        print(f"\n## {name}\n\n{table(rows)}")
        if options.compare:
            compare(name, rows)
        if options.save:
            data = {"suite": name, "machine": machine(), "rows": rows}
            (RESULTS / f"{name}.json").write_text(json.dumps(data, indent=1, allow_nan=False) + "\n")
            (RESULTS / f"{name}.md").write_text(f"# {name}\n\n{table(rows)}\n")
            if name in PLOTS:
                PLOTS[name](rows, RESULTS / f"{name}.png")


if __name__ == "__main__":
    main()
