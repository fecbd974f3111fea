"""Numba of other versions: what a command compiled is there for the next, and internals not known are not touched."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

UNKNOWN = """
import numba
numba.version_info = numba.version_info._replace(short=(9, 9))
"""
DOT = """
import sys
import numpy as np
from holdfast.base.compiled import dot3
from holdfast.elastic.vectors import dot
assert dot3(np.array([1.0, 2, 3]), np.array([4.0, 5, 6])) == 32
assert dot(np.array([1.0, 2]), np.array([3.0, 4])) == 11
assert "holdfast.base.linking" not in sys.modules
print(type(dot3).__name__)
"""


def call(code: str, folder: Path) -> str:
    known = dict(os.environ, HOLDFAST_CACHE_DIR=str(folder))
    done = subprocess.run([sys.executable, "-c", code], env=known, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert not done.stderr
    return done.stdout.strip()


def test_numba_alone_compiles_with_another_version(tmp_path: Path) -> None:
    assert call(UNKNOWN + DOT, tmp_path) == "CPUDispatcher"
