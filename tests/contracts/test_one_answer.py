"""``float`` of an answer with one row, and quantiles of several shares."""

from __future__ import annotations

import numpy as np
import pytest

import holdfast as hf

SIDE = (-0.05, 0.0, 0.05)
ALONG = (1.0, 0.0, 0.0)


@pytest.fixture(scope="module")
def cube() -> hf.answers.Assembly:
    return hf.assemble(hf.shipped_scene("cube"))


def test_float_of_one_answer_is_that_answer(cube: hf.answers.Assembly) -> None:
    push = hf.robustness(cube, "cube", SIDE, ALONG, engine="limit")
    assert float(push) == push.force[0] > 0
    carrier = hf.transport_limits(cube, ALONG, engine="limit")
    assert float(carrier) == carrier.acceleration[0] > 0
    moment = hf.Monitor(cube, seconds=100, solves=30).update(ALONG)
    assert float(moment) == moment.margin > 0
    factor = hf.load_factor(cube, [hf.Load("cube", SIDE, force=ALONG)], engine="limit")
    assert float(factor) == factor.factor > 0
    assert float(hf.load_factor(cube, [], engine="limit")) == np.inf


def test_float_of_several_answers_says_what_to_take(cube: hf.answers.Assembly) -> None:
    pushes = hf.robustness(cube, "cube", SIDE, [ALONG, (0, 1, 0)], engine="limit")
    with pytest.raises(
        hf.HoldfastError, match=r"float\(\) of Robustness: it holds 2 answers; .*answer\.lower\.min\(\)"
    ):
        float(pushes)
    under = hf.robustness_under(
        cube, "cube", SIDE, ALONG, uncertain=hf.sets.Uncertain(mu_range=0.1, samples=3), engine="limit"
    )
    with pytest.raises(hf.HoldfastError, match=r"of 3 samples; ask \.median or \.quantile"):
        float(under)


def test_float_of_an_unknown_answer_is_refused() -> None:
    floor = hf.Body("floor", hf.Box((1, 1, 0.1)), position=(0, 0, -0.05), fixed=True)
    sunk = hf.Body("sunk", hf.Box((0.1, 0.1, 0.1)), mass=1, position=(0, 0, 0.049))
    with pytest.warns(hf.errors.HoldfastWarning, match="overlap"):
        push = hf.robustness(hf.Scene([floor, sunk], 0.5), "sunk", (0, 0, 0.099), (0, 0, -1), engine="limit")
    assert push.status[0] is hf.Status.UNDECIDED
    with pytest.raises(hf.HoldfastError, match=r"the answer is not known; ask \.status, and \.undecided"):
        float(push)


def test_quantiles_of_several_shares_are_rows(cube: hf.answers.Assembly) -> None:
    u = hf.robustness_under(
        cube, "cube", SIDE, [ALONG, (0, 1, 0)], uncertain=hf.sets.Uncertain(mu_range=0.1, samples=9), engine="limit"
    )
    shares = (0.05, 0.5, 1.0)
    assert u.quantile(shares).shape == u.known(shares).shape == (3, 2)
    for row, share in zip(u.quantile(shares), shares, strict=True):
        np.testing.assert_array_equal(row, u.quantile(share))
    np.testing.assert_array_equal(u.known(shares)[1], u.known(0.5))
    for wrong in (-0.1, 1.1, [0.5, 2]):
        with pytest.raises(hf.HoldfastError, match=r"quantile: q: is .*; needs shares from 0 to 1"):
            u.quantile(wrong)
