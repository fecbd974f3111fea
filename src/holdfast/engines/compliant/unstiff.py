"""Which bodies at rest meet no stiffness in some motion, so that no load path of theirs begins without a hold.

All of the weight of a box may be concentrated at an edge, and the next nodes just touch without any force. Taken for
pressed, these resist every turn, although one to the outside only opens them. So nodes whose force is nothing but
rounding count as open. Whether the least push moves such a body is another question (balanced.py).
"""

from __future__ import annotations

import numpy as np

from holdfast.base.arrays import Bool, Float, Int
from holdfast.elastic.model import Elastic
from holdfast.elastic.sparse import unresisted_motion
from holdfast.native import core

TAKEN_ALONG = 1e-3  # displacement, relative to the largest in a motion, above which a body takes part in the motion


def unstiff_at(m: Elastic, q: Float, rounding: float) -> Bool:
    """Return which bodies (J,) meet no stiffness in some motion at rest ``q`` (6J,) as long as no node begins to press.

    Forces of nodes up to ``rounding``, as a share of the largest on each of the bodies that touch there, count as none.
    """
    pressed = _pressed(m, q)
    touching = _touching(m, pressed, rounding)
    K = np.empty_like(m.bonded)
    firm = m._replace(apart=np.where(touching, m.apart + 2 * np.abs(pressed) + 1, m.apart))
    core.evaluate(firm, 1.0, q, np.zeros(len(q)), K)
    return np.asarray(unresisted_motion(m, K) > TAKEN_ALONG)


def _pressed(m: Elastic, q: Float) -> Float:
    """How far each node (I,) is pressed under ``q`` (6J,), negative where it is open."""
    ends = np.vstack([q.reshape(-1, 6), np.zeros(6)])  # index -1: fixed
    shift, turn = np.zeros((2, len(m.a), 3))
    for bodies, arm, sign in ((m.b, m.arm_b, 1.0), (m.a, m.arm_a, -1.0)):
        shift += sign * (ends[bodies, :3] + np.cross(ends[bodies, 3:], arm))
        turn += sign * ends[bodies, 3:]
    shift, turn = (np.einsum("pij,pj->pi", m.axes, one)[_sheets(m)] for one in (shift, turn))
    return np.asarray(m.x * turn[:, 2] - m.y * turn[:, 1] - shift[:, 0] - m.apart)


def _sheets(m: Elastic) -> Int:
    """Return the sheet (I,) of each node."""
    return np.repeat(np.arange(len(m.a)), np.diff(m.first))


def _touching(m: Elastic, pressed: Float, rounding: float) -> Bool:
    """Tell at which nodes (I,) two bodies just touch: more or less pressed, by rounding alone."""
    sheet, largest = _sheets(m), np.zeros(len(m.wrench) // 6 + 1)
    for bodies in (m.a, m.b):
        np.maximum.at(largest, bodies[sheet], m.k * pressed)
    largest[-1] = np.inf
    return np.asarray(m.k * np.abs(pressed) <= rounding * np.minimum(largest[m.a], largest[m.b])[sheet])
