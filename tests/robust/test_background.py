"""Where values lie that no prediction explains."""

from __future__ import annotations

import numpy as np
import pytest

from brdfit.robust import Background

EVERYWHERE = np.linspace(-80.0, 80.0, 32_001)[:, None]


def values(seed=1, n=60, c=3):
    rng = np.random.default_rng(seed)
    return rng.exponential(size=(n, c)) * -1.0 + 2.0, rng.random(n)


def density(background, y):
    return np.exp(background.log_density(y, np.ones(y.shape, dtype=bool)))


@pytest.mark.parametrize("wrong", ["nobody", "some", "one"])
def test_it_is_a_density(wrong):
    y, weights = values()
    known = np.ones(y.shape, dtype=bool)
    weights = {"nobody": None, "some": weights, "one": np.eye(60)[7]}[wrong]
    total = np.trapezoid(density(Background.of(y, known, weights), EVERYWHERE), EVERYWHERE[:, 0])
    assert abs(total - 1.0) < 1e-3


def test_it_is_the_sum_of_the_formula():
    y, wrong = values()
    background = Background.of(y, np.ones(y.shape, dtype=bool), wrong)
    total, centre, breadth = wrong.sum() + 5.0, np.median(y), max(np.std(y), 0.7)
    mean = ((wrong[:, None] * y).sum() / 3 + 5.0 * centre) / total
    spread = (wrong[:, None] * (y - mean) ** 2).sum() / 3
    spread += 5.0 * (breadth**2 + (centre - mean) ** 2)
    h = 0.7 * 1.06 * np.sqrt(spread / total) * total**-0.2
    at = np.linspace(-4.0, 5.0, 50)

    def normal(x, width):
        return np.exp(-0.5 * (x / width) ** 2) / (width * np.sqrt(2 * np.pi))

    found = np.einsum("i,kic->k", wrong / 3, normal(at[:, None, None] - y, h))
    imagined = 5.0 * normal(at - centre, breadth)
    expected = 0.98 * (found + imagined) / total + 0.02 * normal(at - centre, 5.0)
    assert np.allclose(density(background, at[:, None]), expected, rtol=1e-2)


def test_a_crowd_is_likelier_than_a_normal_says():
    rng = np.random.default_rng(2)
    y = np.log(rng.random((400, 1)))
    known = np.ones(y.shape, dtype=bool)
    crowd = Background.of(y, known, np.ones(400)).log_density(y, known).mean()
    assert crowd > Background.of(y, known).log_density(y, known).mean() + 0.2


def test_it_moves_with_the_values_and_repeating_a_channel_changes_nothing():
    y, wrong = values()
    known = np.ones(y.shape, dtype=bool)
    one = Background.of(y, known, wrong).log_density(y, known)
    moved = Background.of(y + 7.3, known, wrong).log_density(y + 7.3, known)
    many = Background.of(np.tile(y, 4), np.tile(known, 4), wrong)
    assert np.allclose(one, moved, atol=1e-9)
    assert np.allclose(one, many.log_density(np.tile(y, 4), np.tile(known, 4)))


def test_rows_that_are_right_and_entries_that_are_unknown_have_no_part_in_it():
    y, wrong = values()
    known = np.ones(y.shape, dtype=bool)
    wrong[10:] = 0.0
    known[:5, 1] = False
    spoilt = y.copy()
    spoilt[:5, 1] = 1e3
    at = np.linspace(-3.0, 3.0, 20)[:, None]
    few = density(Background.of(y, known, wrong), at)
    assert np.array_equal(few, density(Background.of(spoilt, known, wrong), at))
    otherwise = np.vstack([y[:10], np.sort(y[10:], axis=0)])
    assert np.allclose(few, density(Background.of(otherwise, known, wrong), at))


def test_values_that_coincide_have_a_width():
    y = np.zeros((30, 1))
    known = np.ones(y.shape, dtype=bool)
    background = Background.of(y, known, np.ones(30))
    near, far = density(background, np.array([[0.05], [1.0]]))
    assert near > 0.8 * density(background, y)[0]
    assert 0.0 < far < 0.5 * near


def test_a_few_side_by_side_are_no_crowd_yet():
    y, _ = values()
    known, wrong = np.ones(y.shape, dtype=bool), np.zeros(60)
    wrong[:2] = 1.0
    y[:2] = 3.0
    at = np.array([[3.0]])
    before = density(Background.of(y, known), at)
    assert before < density(Background.of(y, known, wrong), at) < 0.4
