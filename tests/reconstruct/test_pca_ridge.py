"""Log-relative principal components: the published formulas against a direct computation."""

from __future__ import annotations

import numpy as np
import pytest

from brdfit.geometry import cos_incident_outgoing
from brdfit.grid import MERL_GRID
from brdfit.reconstruct import PcaRidge
from brdfit.reconstruct.correction_basis import training_cells
from brdfit.reconstruct.pca_ridge import centred_gram, principal_axes
from brdfit.samples import Samples

EPSILON, ETA = 0.001, 40.0


def off(one, other):
    """Return |ln one - ln other|."""
    return np.abs(np.log(one) - np.log(other))


def mapped(population, wi, wo):
    """Return ln((f c + eps) / (median + eps)), (n, columns), and its parts, as published."""
    values = np.maximum(population.evaluate(wi, wo).astype(np.float64), 1e-4)
    cosine = np.clip(wi[:, 2] * wo[:, 2], 0.01, 1.0)[:, None]
    weighted = np.moveaxis(values, 2, 1).reshape(len(wi), -1) * cosine
    median = np.median(weighted, axis=1, keepdims=True)
    return np.log((weighted + EPSILON) / (median + EPSILON)), median, cosine


def reconstructed_as_published(population, samples, wi, wo):
    """Return f_r (n, c): SVD of the mapped columns, median and mean column written out."""
    cells = training_cells(MERL_GRID)
    columns, _, _ = mapped(population, *MERL_GRID.directions(cells))
    _, singular, v_t = np.linalg.svd(columns - columns.mean(axis=1, keepdims=True), False)
    assert singular[0] > 0.0
    count = min(len(samples), len(v_t))

    def scaled_components(wi, wo):
        there, median, cosine = mapped(population, wi, wo)
        mean = there.mean(axis=1, keepdims=True)
        return ((there - mean) @ v_t.T)[:, :count], mean, median, cosine

    q, mean, median, cosine = scaled_components(samples.wi, samples.wo)
    b = np.log((samples.value * cosine + EPSILON) / (median + EPSILON)) - mean
    u, s, w_t = np.linalg.svd(q, full_matrices=False)
    a = w_t.T @ ((s / (s**2 + ETA))[:, None] * (u.T @ b))
    q, mean, median, cosine = scaled_components(wi, wo)
    return (np.exp(q @ a + mean) * (median + EPSILON) - EPSILON) / cosine


@pytest.mark.parametrize("n", [5, 20, 150])  # fewer samples than columns, and more
def test_it_is_the_published_formula_written_out(toy, measure, random_directions, n):
    samples, somewhere = measure(n=n), random_directions(200)
    population = toy.without(["m4"])
    expected = reconstructed_as_published(population, samples, *somewhere)
    found = PcaRidge(population=population).fit(samples).evaluate(*somewhere)
    bright = expected > 2e-3  # below epsilon little is left of single precision
    assert bright.mean() > 0.8
    assert off(found, expected)[bright].max() < 2e-3


def test_a_member_comes_back_the_nearer_the_weaker_the_ridge(toy, measure, random_directions):
    samples, somewhere = measure("m3", n=400, noise=0.0), random_directions(200)
    truth = toy.subset(["m3"]).evaluate(*somewhere)[:, 0]
    errors = [
        off(PcaRidge(population=toy, eta=eta).fit(samples).evaluate(*somewhere), truth).mean()
        for eta in (1e3, 40.0, 1e-3)
    ]
    assert errors == sorted(errors, reverse=True)
    assert errors[-1] < 0.01


def test_without_evidence_it_is_the_mean_of_the_population(toy, measure, random_directions):
    wi, wo = random_directions(100)
    found = PcaRidge(population=toy, eta=1e12).fit(measure(n=50)).evaluate(wi, wo)
    columns, median, cosine = mapped(toy, wi, wo)
    mean = np.exp(columns.mean(axis=1, keepdims=True))
    assert np.allclose(found, (mean * (median + EPSILON) - EPSILON) / cosine, rtol=1e-4)


def test_brightness_is_assumed_less_the_more_samples_say_otherwise(toy, measure, random_directions):
    """Unlike the other methods it knows how bright materials are: a ridge draws it there."""
    population, somewhere = toy.without(["m4"]), random_directions(200)
    followed = []
    for n in (4, 40, 2000):
        samples = measure(n=n)
        one, other = (
            PcaRidge(population=population).fit(samples.with_value(k * samples.value))
            for k in (1.0, 8.0)
        )
        ratio = off(one.evaluate(*somewhere), other.evaluate(*somewhere))
        followed.append(float(np.median(ratio)) / np.log(8.0))
    assert followed == sorted(followed)
    assert followed[0] < 0.7
    assert 0.9 < followed[2] < 1.01


def test_one_wild_sample_moves_it_and_is_named(toy, measure, random_directions):
    """It has no defence: what is promised is that it says so."""
    samples, somewhere = measure(), random_directions(200)
    value = samples.value.copy()
    value[7] *= 1e4
    clean, hit = (
        PcaRidge(population=toy).fit(samples.with_value(v)) for v in (samples.value, value)
    )
    moved = off(clean.evaluate(*somewhere), hit.evaluate(*somewhere))
    assert moved.max() > 0.02
    assert hit.outliers[7]
    assert not clean.outliers.any()


def test_two_measurements_of_one_place_and_values_at_the_noise_floor_are_taken(toy, measure):
    samples = measure(n=60)
    rows = np.append(np.arange(60), [0, 0, 1])
    value = samples.value[rows]
    value[5], value[6, 1] = 0.0, -1e-3
    more = Samples(wi=samples.wi[rows], wo=samples.wo[rows], value=value)
    result = PcaRidge(population=toy).fit(more)
    left_out = PcaRidge(population=toy).fit(more.subset(np.delete(np.arange(63), 5)))
    found, expected = (r.evaluate(samples.wi, samples.wo) for r in (result, left_out))
    assert np.allclose(found, expected)


def test_a_million_samples_need_the_memory_of_a_chunk(toy, measure, monkeypatch):
    from brdfit.reconstruct import pca_ridge

    samples = measure(n=1000)
    whole = PcaRidge(population=toy).fit(samples).evaluate(samples.wi, samples.wo)
    monkeypatch.setattr(pca_ridge, "_CHUNK", 64)
    pieces = PcaRidge(population=toy).fit(samples).evaluate(samples.wi, samples.wo)
    assert np.allclose(whole, pieces, rtol=1e-5)


def test_the_centred_gram_matrix_is_that_of_centred_columns(rng):
    columns = rng.normal(size=(50, 7)) + 3.0
    centred = columns - columns.mean(axis=1, keepdims=True)
    assert np.allclose(centred_gram(columns.T @ columns), centred.T @ centred)


def test_principal_axes_are_those_of_the_singular_value_decomposition(rng):
    columns = rng.normal(size=(50, 7)) * np.arange(1, 8)
    _, _, v_t = np.linalg.svd(columns, full_matrices=False)
    axes = principal_axes(columns.T @ columns)
    assert np.allclose(np.abs(v_t @ axes), np.eye(7), atol=1e-10)


def test_the_cosine_is_the_same_from_angles_and_from_directions(rng):
    cells = rng.choice(MERL_GRID.cells, 1000)
    wi, wo = MERL_GRID.directions(cells)
    cos_i, cos_o = cos_incident_outgoing(*MERL_GRID.half_diff(cells))
    assert np.allclose(wi[:, 2] * wo[:, 2], cos_i * cos_o)
