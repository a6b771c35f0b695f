"""A variance that features of a row make larger or smaller."""

from __future__ import annotations

import numpy as np

from brdfit.robust import Unevenness


def settled(features, residual, weights=None, steps=12):
    weights = np.ones(len(features)) if weights is None else weights
    found = Unevenness()
    for _ in range(steps):
        size = residual**2 / found.factor(features)
        found = found.updated(features, size, weights)
    return found


def halves(n):
    return np.repeat(np.eye(2), n // 2, axis=0)


def test_without_a_step_it_is_the_same_everywhere():
    assert np.array_equal(Unevenness().factor(halves(6)), np.ones(6))


def test_it_finds_how_much_further_off_some_rows_are(rng):
    features = np.repeat(np.eye(3), 1000, axis=0)
    residual = rng.normal(size=3000) * (features @ [0.5, 1.0, 3.0])
    one, middle, three = settled(features, residual).factor(np.eye(3))
    np.testing.assert_allclose([one / middle, three / middle], [0.25, 9.0], rtol=0.15)
    assert middle == 1.0


def test_a_typical_row_keeps_its_variance_whatever_the_unit(rng):
    features, residual = halves(400), rng.normal(size=400) * 7.0
    found = settled(features, residual)
    assert np.isclose(np.median(found.factor(features)), 1.0, rtol=1e-3)
    other = settled(features, residual * 10.0)
    np.testing.assert_allclose(found.factor(features), other.factor(features), rtol=1e-9)


def test_few_rows_say_little(rng):
    few, many = (
        settled(halves(n), np.where(np.arange(n) < n // 2, 1.0, 3.0)).factor(np.eye(2))
        for n in (6, 2000)
    )
    assert 1.0 < few[1] / few[0] < 4.0
    assert np.isclose(many[1] / many[0], 9.0, rtol=0.05)


def test_a_row_that_is_not_believed_has_no_say(rng):
    features, residual = halves(200), rng.normal(size=200)
    weights = np.ones(200)
    weights[::7] = 0.0
    wild = np.where(weights > 0.0, residual, 50.0)
    one, other = (settled(features, r, weights).factor(features) for r in (residual, wild))
    np.testing.assert_allclose(one, other)


def test_one_wild_row_among_few_does_not_own_its_place(rng):
    features, residual = halves(60), rng.normal(size=60)
    residual[-1] = 1e3
    step = Unevenness().updated(features, residual**2, np.ones(60))
    assert np.all(step.factor(features) < 6.0)
