"""The stages: what each does, what it must at least move and compute, and who does it besides.

A stage is a function of the job that puts everything in place and returns what is to be timed.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from brdfit.arrays import FloatArray
from brdfit.bench.ledger import figure
from brdfit.bench.speed import rivals
from brdfit.bench.speed.job import Job
from brdfit.bench.speed.machine import Floor
from brdfit.bench.speed.measure import Prepared
from brdfit.formats import read_samples, write_samples, write_table
from brdfit.grid import MERL_GRID, Grid
from brdfit.reconstruct import Compact, CorrectionFunctions, Posterior
from brdfit.reconstruct.compact import Block
from brdfit.render import ILLUMINATIONS, Sphere
from brdfit.samples import Samples
from brdfit.table import Table

__all__ = ["JOB", "RIVALS", "STAGES", "Stage", "reading"]

_FLOAT = 4
_CORNERS = 8
_LIGHT = "area_studio"


@dataclass(frozen=True)
class Stage:
    """A name, a sentence, how it is prepared, and how often it is run."""

    name: str
    what: str
    prepare: Callable[[Job], Prepared]
    repeat: int = 5
    warm: bool = True
    """Run once before; not what takes minutes and has nothing to warm."""
    cost: int = 2
    """How long it takes beside the others."""


def _read_csv(job: Job) -> Prepared:
    path = job.folder / "measured.csv"
    samples = job.samples(job.sizes.many)
    write_samples(samples, path)
    return Prepared(
        lambda: read_samples(path),
        Floor(path.stat().st_size + _size(samples), why="the file, and directions and values"),
        told={"samples": len(samples)},
    )


def _fit_posterior(job: Job, samples: Samples) -> Prepared:
    method = Posterior(population=job.others)
    model = method.fit(samples).model
    n, columns = len(samples), job.everything.evaluate(*job.directions(1)).size
    q = model.basis.size  # type: ignore[attr-defined]
    floor = Floor(
        _size(samples) + _FLOAT * n * columns,
        single=2.0 * n * columns * q,
        double=n**3 / 3.0,
        why="the population at the samples, its components there, one Cholesky factor",
    )
    return Prepared(lambda: method.fit(samples), floor, told={"samples": n})


def _fit_correction(job: Job) -> Prepared:
    samples = job.samples(job.sizes.many)
    method = CorrectionFunctions(population=job.others)
    n, members, channels = len(samples), len(job.others), samples.n_channels
    floor = Floor(
        _size(samples) + _FLOAT * n * members * channels,
        single=1.0 * n * members**2 * channels,
        why="the population at the samples, one Gram matrix a channel",
    )
    return Prepared(lambda: method.fit(samples), floor, told={"samples": n})


def _batch(job: Job, shared: bool) -> Prepared:
    method, items = Compact(population=job.lean_on), job.items(shared)
    basis, block = method.basis(), Block.of(items)
    return Prepared(
        lambda: method.fit_block(block, basis), _batch_floor(items, basis.size), len(block)
    )


def _ridge_loop(job: Job) -> Prepared:
    basis, items = Compact(population=job.lean_on).basis(), job.items(shared=False)
    floor = _batch_floor(items, basis.size)
    return Prepared(lambda: rivals.ridge_loop(items, basis), floor, len(items))


def _batch_floor(items: list[Samples], size: int) -> Floor:
    samples = sum(len(item) for item in items)
    return Floor(
        sum(_size(item) for item in items) + 8 * len(items) * size * items[0].n_channels,
        double=samples * size**2 + len(items) * size**3 / 3.0,
        why="samples and coefficients, one Gram matrix and Cholesky factor an item",
    )


def _dense(job: Job, samples: Samples) -> Prepared:
    grid = job.sizes.grid
    result = Posterior(population=job.others).fit(samples)
    model = result.model
    rows = model.basis.on_grid(grid).rows  # type: ignore[attr-defined]
    written = _FLOAT * grid.size * samples.n_channels
    floor = Floor(
        rows.nbytes + written,
        single=2.0 * rows.size * samples.n_channels,
        why="the components on the grid, the table, one product",
    )
    return Prepared(lambda: result.table(grid), floor, told={"samples": len(samples)})


def _dense_compact(job: Job) -> Prepared:
    grid, samples = job.sizes.grid, job.items(shared=True)[0]
    method = Compact(population=job.others)
    result, rows = method.fit(samples), method.basis().rows
    channels = samples.n_channels
    floor = Floor(
        rows.nbytes + _FLOAT * grid.size * channels,
        single=2.0 * rows.size * channels,
        why="the components where they are kept, the table, one product",
    )
    return Prepared(lambda: result.table(grid), floor, told={"samples": len(samples)})


def _preview(job: Job) -> Prepared:
    table, sphere, light = (
        job.table(job.sizes.grid),
        Sphere(job.sizes.picture),
        ILLUMINATIONS[_LIGHT](),
    )
    counter = _Counter(table)
    sphere.shade(counter, light)
    floor = Floor(
        counter.asked * _CORNERS * table.n_channels * table.values.itemsize,
        why="the eight cells around every direction that is asked",
    )
    return Prepared(lambda: sphere.shade(table, light), floor, told={"directions": counter.asked})


@dataclass(eq=False)
class _Counter:
    """Counts the directions that a table is asked for."""

    table: Table
    asked: int = 0

    def evaluate(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        self.asked += len(wi)
        return self.table.evaluate(wi, wo)


def _write(job: Job, suffix: str, grid: Grid) -> Prepared:
    table, path = job.table(grid), job.folder / f"written{suffix}"
    write_table(table, path)
    floor = Floor(table.values.nbytes + path.stat().st_size, why="the table, and the file")
    return Prepared(lambda: write_table(table, path), floor)


def _whole(job: Job, run: Callable[[Samples], FloatArray]) -> Prepared:
    """Prepare the job that others do too: a small measurement in, every cell out."""
    samples = job.samples(job.sizes.few)
    grid = job.sizes.grid
    cells = grid.cells
    truth = np.log(job.truth(*grid.directions(cells)))

    def judge(result: FloatArray) -> dict[str, Any]:
        off = np.abs(np.log(np.maximum(result, 1e-12)) - truth)
        return {"error": figure(float(off.mean())), "cells": int(cells.size)}

    return Prepared(lambda: run(samples), judge=judge, told={"samples": len(samples)})


def _posterior_job(job: Job) -> Prepared:
    grid, method = job.sizes.grid, Posterior(population=job.others)

    def run(samples: Samples) -> FloatArray:
        table = method.fit(samples).table(grid)
        return np.asarray(table.values.reshape(-1, samples.n_channels)[grid.cells])

    return _whole(job, run)


def _size(samples: Samples) -> int:
    return int(samples.wi.nbytes + samples.wo.nbytes + samples.value.nbytes)


JOB = "job_posterior"
RIVALS = ("job_scipy_rbf", "job_sklearn_gp")

_LIST = (
    Stage("read_csv", "read a large RGB measurement from .csv", _read_csv),
    Stage(
        "fit_posterior_rgb",
        "fit a small RGB measurement, `Posterior`",
        lambda job: _fit_posterior(job, job.samples(job.sizes.few)),
    ),
    Stage(
        "fit_posterior_bands",
        "fit a spectral measurement, `Posterior`",
        lambda job: _fit_posterior(job, job.spectral()),
    ),
    Stage(
        "fit_correction_rgb",
        "fit a large RGB measurement, `CorrectionFunctions`",
        _fit_correction,
        repeat=3,
        cost=10,
    ),
    Stage(
        "batch_shared",
        "fit many items at the same directions, `Compact`",
        lambda job: _batch(job, True),
        repeat=3,
    ),
    Stage(
        "batch_own",
        "fit many items at directions of their own, `Compact`",
        lambda job: _batch(job, False),
        repeat=3,
    ),
    Stage("batch_ridge_loop", "the same, a numpy loop of ridge PCA", _ridge_loop, repeat=3),
    Stage(
        "dense_rgb",
        "table from a finished RGB fit, `Posterior`",
        lambda job: _dense(job, job.samples(job.sizes.few)),
    ),
    Stage(
        "dense_bands",
        "table from a finished spectral fit, `Posterior`",
        lambda job: _dense(job, job.spectral()),
    ),
    Stage("dense_compact", "table from a finished RGB fit, `Compact`", _dense_compact),
    Stage("preview", "shade a sphere of 256 pixels, as `brdfit render`", _preview),
    Stage(
        "write_binary", "write a table as .binary", lambda job: _write(job, ".binary", MERL_GRID)
    ),
    Stage(
        "write_bsdf",
        "write a table as .bsdf",
        lambda job: _write(job, ".bsdf", job.sizes.grid),
        repeat=3,
    ),
    Stage(JOB, "`Posterior`: fit and table", _posterior_job),
    Stage(
        RIVALS[0],
        "SciPy `RBFInterpolator`",
        lambda job: _whole(job, lambda samples: rivals.radial_basis(samples, job.sizes.grid)),
        repeat=1,
        warm=False,
        cost=30,
    ),
    Stage(
        RIVALS[1],
        "scikit-learn `GaussianProcessRegressor`",
        lambda job: _whole(job, lambda samples: rivals.gaussian_process(samples, job.sizes.grid)),
        repeat=1,
        warm=False,
        cost=60,
    ),
)

STAGES = {stage.name: stage for stage in _LIST}
"""Name -> stage, in the order of the page."""


def reading(laboratory: str) -> Stage:
    """Return the stage that reads a real file of a laboratory."""

    def prepare(job: Job) -> Prepared:
        path, options = next((p, o) for name, p, o in job.measured if name == laboratory)
        samples = read_samples(path, **options)
        floor = Floor(path.stat().st_size + _size(samples), why="the file, directions, values")
        told = {"samples": len(samples), "channels": samples.n_channels}
        return Prepared(lambda: read_samples(path, **options), floor, told=told)

    return Stage(f"read_{laboratory}", f"read a file of {laboratory}", prepare)
