"""Verdicts on published rows of blocks beside those of fine nodes, from tan φ = 0.60 to 0.90, as a table.

``PYTHONPATH=. python tests/cases/near_limits_table.py [step]``, with 0.002 from one coefficient to the next by default.
Exit code 1 where the default verdict is neither that of 25 nodes a side nor undecided.
"""

from __future__ import annotations

import sys
import time
from itertools import groupby

import numpy as np
from test_near_limits import FINE, STEP

import holdfast as hf
from bench.experiments.toppling_blocks import FIVE, SIXTEEN, Slope
from holdfast import Compliant, Status

LOW, HIGH = 0.6, 0.9


def verdicts(row: Slope, mu: float) -> tuple[Status, Status, bool]:
    """By default, on fine nodes whatever they have in reserve, and whether the blocks stand by hand."""
    assembly = hf.assemble(row.scene(mu))
    fine = Compliant(nodes=FINE).on(assembly, assembly.weight_wrench()).verdict()
    return hf.stability(assembly).status, fine.status, row.stand(mu)


def write(line: str) -> None:
    """Write a line at once."""
    sys.stdout.write(f"{line}\n")
    sys.stdout.flush()


def main(step: float) -> int:
    """Write the table; return how many verdicts are wrong."""
    wrong = 0
    write(f"{'blocks':>6}  {'tan φ':^13}  {'number':>6}  {'default':<9}  {f'{FINE} nodes':<9}  by hand")
    for row in (FIVE, SIXTEEN):
        began, coefficients = time.process_time(), np.arange(LOW, HIGH + 1e-9, step)
        found = [(float(mu), *verdicts(row, float(mu))) for mu in coefficients]
        for (default, fine, stands), lot in groupby(found, key=lambda one: one[1:]):
            between = [one[0] for one in lot]
            faulty = default not in (fine, Status.UNDECIDED)
            wrong += faulty * len(between)
            places = f"{between[0]:.4f}-{between[-1]:.4f}"
            says = "stand" if stands else "fall"
            said = f"{default:<9}  {fine:<9}  {says}{'  <- wrong' if faulty else ''}"
            write(f"{len(row.heights):>6}  {places}  {len(between):>6}  {said}")
        write(f"        {time.process_time() - began:.0f} s")
    write(f"wrong: {wrong}")
    return wrong


if __name__ == "__main__":
    sys.exit(main(float(sys.argv[1]) if len(sys.argv) > 1 else STEP) > 0)
