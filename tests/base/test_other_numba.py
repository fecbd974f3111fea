"""A version of Numba that linking.py was not written for compiles the same functions by itself."""

from __future__ import annotations

import subprocess
import sys

CODE = """
import numba
numba.__version__ = "9.9.9"
import sys
import numpy as np
from holdfast.base.compiled import dot3, machine_code
from holdfast.elastic.vectors import dot
assert dot3(np.array([1.0, 2, 3]), np.array([4.0, 5, 6])) == 32
assert dot(np.array([1.0, 2]), np.array([3.0, 4])) == 11
assert "holdfast.base.linking" not in sys.modules
print(type(dot3).__name__)
"""


def test_numba_alone_compiles_with_another_version() -> None:
    done = subprocess.run([sys.executable, "-c", CODE], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == "CPUDispatcher"
