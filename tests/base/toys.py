"""A copy of ``base`` with three functions that call each other, for tests of how machine code is made and kept."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import holdfast

TOY = """
import numpy as np
from holdfast.base.compiled import compiled
@compiled
def inner(x, k):
    return x + k
@compiled
def one(x):
    return inner(x, 1) + inner(x, 2)
@compiled
def rows(x):
    out = np.zeros(2)
    out[0] = one(x)
    return out
"""
CALL = """
from holdfast.toy import inner, one, rows
print(rows(3.0)[0], [sum(each.stats.cache_misses.values()) for each in (inner, one, rows)], len(inner.overloads))
"""


def copied(copy: Path) -> Path:
    """Copy ``base`` to a folder, in which no function is short; return the package."""
    own = Path(holdfast.__file__).parent / "base"
    shutil.copytree(own, copy / "base", ignore=shutil.ignore_patterns("__pycache__"))
    (copy / "__init__.py").write_text("")
    linking = copy / "base" / "linking.py"
    text, count = re.subn(r"^SHORT = \d+", "SHORT = 0", linking.read_text(), flags=re.MULTILINE)
    assert count == 1
    linking.write_text(text)
    (copy / "toy.py").write_text(TOY)
    return copy
