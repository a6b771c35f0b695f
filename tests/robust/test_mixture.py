"""The mixture of measurements and something else."""

from __future__ import annotations

import numpy as np
from scipy.stats import t

from brdfit.robust import Background, Factors, Mixture


def judged(y, mean, variance=0.01, known=None):
    known = np.ones(y.shape, dtype=bool) if known is None else known
    mixture = Mixture(0.2, Background.of(y, known))
    return mixture.judge(y, mean, np.full(len(y), variance), known), known, mixture


def test_a_row_far_from_its_prediction_is_not_believed_and_one_nearby_is():
    y = np.array([[0.0], [0.05], [3.0]])
    verdict, _, _ = judged(y, np.zeros((3, 1)))
    assert (verdict.responsibility[:2] > 0.9).all()
    assert verdict.responsibility[2] < 1e-6


def test_repeating_a_channel_changes_nothing():
    rng = np.random.default_rng(1)
    y, mean = rng.normal(size=(20, 2)), rng.normal(size=(20, 2))
    one, _, _ = judged(y, mean)
    many, _, _ = judged(np.tile(y, 4), np.tile(mean, 4))
    assert np.allclose(one.responsibility, many.responsibility)


def test_an_unknown_entry_has_no_say_and_an_unknown_row_no_weight():
    y = np.array([[0.0, 9.0], [0.0, 0.0]])
    known = np.array([[True, False], [False, False]])
    verdict, _, _ = judged(y, np.zeros((2, 2)), known=known)
    assert verdict.responsibility[0] > 0.9
    assert verdict.responsibility[1] == 0.0
    assert verdict.log_likelihood[1] == 0.0


def test_the_share_stays_inside_and_follows_the_verdict():
    y = np.concatenate([np.zeros(60), np.full(40, 4.0)])[:, None]
    verdict, known, mixture = judged(y, np.zeros((100, 1)))
    assert abs(mixture.updated(y, verdict, known).share - 0.4) < 0.05
    good, known, mixture = judged(y[:60], np.zeros((60, 1)))
    assert 0.0 < mixture.updated(y[:60], good, known).share < 0.1


def test_the_densities_are_those_of_the_formula():
    y, mean = np.array([[1.0, -0.5]]), np.array([[0.8, 0.1]])
    known, variance = np.ones((1, 2), dtype=bool), np.array([0.02])
    mixture = Mixture(0.3, Background(-1.0, 2.0), Factors(0.6, 1.2))

    def normal(x, v):
        return -0.5 * (x**2 / v + np.log(2 * np.pi * v))

    right = 0.7 * np.exp(normal(y - mean, 0.02).mean())
    factor = 0.3 * 0.6 * np.exp(normal(y - mean, 0.02 + 1.2**2).mean())
    broad = 0.98 * np.exp(normal(y + 1.0, 4.0)) + 0.02 * np.exp(normal(y + 1.0, 25.0))
    elsewhere = 0.3 * 0.4 * np.exp(np.log(broad).mean())
    verdict = mixture.judge(y, mean, variance, known)
    total = right + factor + elsewhere
    assert np.allclose(verdict.log_likelihood, np.log(total))
    assert np.allclose(verdict.responsibility, right / total)
    assert np.allclose(verdict.factor, factor / total)


def test_the_kind_of_outlier_is_told_by_what_they_follow():
    rng = np.random.default_rng(3)
    mean = rng.normal(scale=3.0, size=(600, 1))
    known, variance = np.ones((600, 1), dtype=bool), np.full(600, 0.01)
    wrong = rng.random((600, 1)) < 0.5
    right = mean + 0.1 * rng.normal(size=mean.shape)
    factors = np.where(wrong, mean + rng.normal(scale=1.2, size=mean.shape), right)
    elsewhere = np.where(wrong, rng.normal(4.0, 0.5, size=mean.shape), right)
    shares = []
    for y in (factors, elsewhere):
        mixture = Mixture(0.3, Background.of(y, known))
        for _ in range(20):
            mixture = mixture.updated(y, mixture.judge(y, mean, variance, known), known)
        shares.append(mixture.factors.share)
        assert abs(mixture.share - 0.5) < 0.08
    assert shares[0] > 0.85
    assert shares[1] < 0.1


def test_an_inlier_with_tails_is_believed_where_a_normal_is_not_but_counts_for_less():
    y, known = np.array([[0.0], [0.1], [0.45]]), np.ones((3, 1), dtype=bool)
    background, variance = Background(0.0, 1.0), np.full(3, 0.01)
    normal, tails = (
        Mixture(0.05, background, freedom=nu).judge(y, np.zeros((3, 1)), variance, known)
        for nu in (np.inf, 4.0)
    )
    assert np.array_equal(normal.credit, np.ones(3))
    assert normal.responsibility[2] < 0.1 < 0.5 < tails.responsibility[2]
    assert tails.credit[2] < 0.3 < 1.0 < tails.credit[0]
    assert np.isclose(tails.credit[1], 1.0)


def test_the_tails_are_those_of_students_t_and_a_normal_is_their_limit():
    e, variance = np.array([0.3, -1.2]), np.array([0.04, 0.2])
    known, mean = np.ones((2, 1), dtype=bool), np.zeros((2, 1))
    tails = Mixture(1e-12, Background(0.0, 1.0), freedom=4.0)
    found = tails.judge(e[:, None], mean, variance, known).log_likelihood
    assert np.allclose(found, t(4.0, scale=np.sqrt(variance)).logpdf(e), atol=1e-6)
    near = Mixture(0.2, Background(0.0, 1.0), freedom=1e7)
    far = Mixture(0.2, Background(0.0, 1.0))
    one, other = (m.judge(e[:, None], mean, variance, known) for m in (near, far))
    assert np.allclose(one.responsibility, other.responsibility, atol=1e-5)
