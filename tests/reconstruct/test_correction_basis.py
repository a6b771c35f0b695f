"""The correction basis: each material as what the others make of it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from brdfit.grid import MERL_GRID
from brdfit.linalg import NormalEquations, nonnegative
from brdfit.populations import Population
from brdfit.populations.contract import member_values
from brdfit.progress import silent
from brdfit.reconstruct.combination import encode_members
from brdfit.reconstruct.correction_basis import (
    CorrectionBasis,
    MemberGram,
    correction_basis,
    training_cells,
)
from brdfit.reconstruct.members import MemberRows
from brdfit.transform import ERROR_METRICS, error_metric

METRICS = sorted(ERROR_METRICS)


@pytest.fixture
def rows(toy, random_directions):
    return MemberRows.at(toy, *random_directions(500))


@pytest.mark.parametrize("name", METRICS)
def test_no_member_is_approximated_by_its_own_material(toy, rows, name):
    basis = CorrectionBasis.build(MemberGram.of(rows, error_metric(name)), toy.materials)
    same = np.equal.outer(toy.materials, toy.materials)
    assert same.sum() == len(toy) + 2  # the twins are of one material
    for matrix in basis.coefficients:
        members = matrix[:, : len(toy)]
        assert (members[same] == 0.0).all()
        assert (members >= 0.0).all()
        assert (members > 0.0).any(axis=1).all()


@pytest.mark.parametrize("name", METRICS)
def test_the_coefficients_are_those_of_a_fit_without_the_material(toy, rows, name):
    metric = error_metric(name)
    basis = CorrectionBasis.build(MemberGram.of(rows, metric), toy.materials)
    member = 3
    others = np.array([index for index in range(len(toy)) if index != member])
    x = encode_members(rows.logs[1][:, others].astype(np.float64), metric)
    y = metric.encode(rows.logs[1][:, member].astype(np.float64))
    equations = NormalEquations.of(x, y, np.ones(len(y)))
    expected = nonnegative(equations, int(metric.needs_constant))
    found = np.delete(basis.coefficients[1][member], member)
    assert np.allclose(x @ found, x @ expected, atol=1e-4)


@pytest.mark.parametrize("name", METRICS)
def test_a_correction_function_is_the_member_over_its_approximation(toy, rows, name):
    metric = error_metric(name)
    basis = CorrectionBasis.build(MemberGram.of(rows, metric), toy.materials)
    values = basis.evaluate(rows)
    assert values.shape == (500, basis.size) == (500, 3 * len(toy))
    assert np.isfinite(values).all()
    assert (values > 0.0).all()
    channel, member = 2, 5
    combined = encode_members(rows.logs[channel], metric) @ basis.coefficients[channel][member]
    expected = rows.logs[channel][:, member] - metric.decode(combined)
    found = np.log(values[:, channel * len(toy) + member])
    assert np.allclose(found, np.clip(expected, -3.0, 3.0), atol=1e-4)


@dataclass(frozen=True)
class MixedSource:
    """The toy materials, and one that is an exact mixture of two of them."""

    toy: Population
    metric: str
    name: str = "mixed"
    fingerprint: str = "mixed-1"
    channels: tuple[str, ...] = ("R", "G", "B")
    bilateral: bool = True

    @property
    def members(self):
        return (*self.toy.members, "mixture")

    @property
    def materials(self):
        return (*self.toy.materials, "mixture")

    def evaluate(self, wi, wo, pick):
        values = self.toy.evaluate(wi, wo).astype(np.float64)
        metric = error_metric(self.metric)
        a, b = (metric.encode(np.log(values[:, index])) for index in (2, 6))
        mixed = np.exp(metric.decode(0.3 * a + 0.7 * b))
        every = np.concatenate([values, mixed[:, None]], axis=1)[:, pick]
        return member_values(np.moveaxis(every, 2, 0).astype(np.float32))


@pytest.mark.parametrize("name", METRICS)
def test_what_the_others_explain_exactly_has_a_correction_function_of_one(
    toy, random_directions, name
):
    mixed = Population.of(MixedSource(toy, name))
    rows = MemberRows.at(mixed, *random_directions(500))
    basis = CorrectionBasis.build(MemberGram.of(rows, error_metric(name)), mixed.materials)
    values = basis.evaluate(rows)
    k = len(mixed)
    assert np.allclose(values[:, [k - 1, 2 * k - 1, 3 * k - 1]], 1.0, atol=2e-3)
    assert np.abs(np.log(values[:, 4])).max() > 0.05  # the others are no mixtures


def test_a_material_without_others_has_nothing_to_correct(toy, random_directions):
    alone = toy.subset(["m9"])
    rows = MemberRows.at(alone, *random_directions(50))
    for name in METRICS:
        basis = CorrectionBasis.build(MemberGram.of(rows, error_metric(name)), alone.materials)
        assert np.allclose(basis.evaluate(rows), 1.0, atol=1e-5)


@pytest.mark.parametrize("name", METRICS)
def test_leaving_members_out_of_the_sums_is_building_them_without(toy, rows, name):
    metric = error_metric(name)
    left_out = np.array([0, 4])
    kept = np.setdiff1d(np.arange(len(toy)), left_out)
    fewer = MemberRows(tuple(log[:, kept] for log in rows.logs))
    for one, other in zip(
        MemberGram.of(rows, metric).without(left_out).grams,
        MemberGram.of(fewer, metric).grams,
        strict=True,
    ):
        assert np.allclose(one, other)


def test_the_basis_is_built_once_for_a_selection_and_metric(toy, tmp_path, monkeypatch):
    monkeypatch.setenv("BRDFIT_CACHE", str(tmp_path))
    told = []

    def build(population, name):
        return correction_basis(population, error_metric(name), lambda *step: told.append(step))

    first = build(toy, "log")
    assert told == [("correction basis", 0, 1), ("correction basis", 1, 1)]
    again = build(toy, "log")
    assert len(told) == 2
    for one, other in zip(first.coefficients, again.coefficients, strict=True):
        assert np.array_equal(one, other)
    build(toy, "root")
    build(toy.without(["m4"]), "log")
    assert len(told) == 6


def test_the_basis_is_trained_on_a_fixed_draw_of_cells_that_exist(toy):
    cells = training_cells(MERL_GRID)
    assert cells.size == np.unique(cells).size == 20_000
    assert np.isin(cells, MERL_GRID.cells).all()
    assert np.array_equal(cells, training_cells(MERL_GRID))
    rows = MemberRows.at(toy, *MERL_GRID.directions(cells))
    built = CorrectionBasis.build(MemberGram.of(rows, error_metric("log")), toy.materials)
    kept = correction_basis(toy, error_metric("log"), silent)
    for one, other in zip(built.coefficients, kept.coefficients, strict=True):
        assert np.array_equal(one, other)
