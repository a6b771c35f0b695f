"""A refinement of `Posterior` ends where left-out samples become no likelier, and says so."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from brdfit.linalg import CovariancePosterior
from brdfit.reconstruct import Outcome, Posterior
from brdfit.reconstruct.posterior.measurements import Measurements
from brdfit.reconstruct.posterior.refine import refine
from brdfit.reconstruct.posterior.stages import FREEDOM, everybody

MANY = 60


@pytest.fixture
def uneven():
    """Return rows along a line, a quarter of them forty times as noisy, and what they hang on."""
    rng = np.random.default_rng(3)
    n = 200
    x = np.sort(rng.uniform(0.0, 1.0, n))
    gram = np.exp(-0.5 * ((x[:, None] - x) / 0.1) ** 2)
    noise = np.where(x > 0.75, 0.2, 0.005)
    y = (np.sin(7.0 * x) + noise * rng.normal(size=n))[:, None]
    true = np.ones(y.shape, dtype=bool)
    rows = np.arange(n)
    data = Measurements(rows, rows, y, true, ~true, np.zeros(n), np.zeros((n, 1)))
    belief = everybody(data)
    mixture = replace(belief.mixture, freedom=FREEDOM)
    belief = replace(belief, width=0.25, mixture=mixture)
    return partial(refine, data, np.zeros(n), partial(CovariancePosterior.of, gram), belief)


def test_at_rest_another_step_is_worth_next_to_nothing(uneven):
    found = uneven(4, MANY)
    assert found.settled
    assert 4 <= found.steps < MANY
    gain = found.score - uneven(found.steps - 1).score
    assert gain < 0.02 * found.belief.count


def test_it_does_not_stop_while_samples_become_likelier(uneven):
    found = uneven(2, MANY)
    gains = np.diff([uneven(steps).score for steps in range(1, found.steps)])
    assert len(gains) > 5
    assert (gains[1:] >= 0.02 * 0.9 * found.belief.count).all()


def test_every_start_gets_as_many_steps(uneven):
    enough = uneven(2, MANY).steps
    assert uneven(enough + 5, MANY).steps == enough + 5


def test_a_limit_that_comes_first_is_told(uneven):
    cut = uneven(2)
    assert not cut.settled
    assert cut.steps == 2


def test_a_fit_of_samples_that_scatter_unevenly_comes_to_rest(toy, measure):
    samples = measure(n=400, noise=0.0)
    rng = np.random.default_rng(5)
    size = np.where(samples.wi[:, 2] < 0.6, 0.2, 0.005)
    spread = np.exp(size * rng.normal(size=len(samples)))[:, None]
    result = Posterior(population=toy.without(["m4"])).fit(
        samples.with_value(samples.value * spread)
    )
    assert result.outcome is Outcome.CONVERGED
