"""What is recorded of one fit of a part of a file: error, outliers named, intervals.

A held-out measurement is to lie within the interval that the method states, which is that of
the BRDF, of standard deviation d in ln f_r, and the noise of a measurement besides:

    z = ln(value / result) / sqrt(d^2 + s^2 + (floor / result)^2)

with s, the noise of a good sample, and the floor as fit and settings state them. `within_68`
is the share of |z| <= 1, `within_95` that of |z| <= `deviations(0.95)`, 1.96 for a method that
takes its errors for normal.
"""

from __future__ import annotations

import time
import warnings
from typing import TYPE_CHECKING

import numpy as np

from brdfit.arrays import FloatArray
from brdfit.bench.holdout.conditions import Part
from brdfit.bench.ledger import Record, figure
from brdfit.bench.log_rbf import LogRbf
from brdfit.bench.real_files import compare
from brdfit.bench.verdicts import judged
from brdfit.errors import BrdfitError, BrdfitWarning
from brdfit.samples import Samples

if TYPE_CHECKING:
    from brdfit.reconstruct.result import Method, Reconstruction

__all__ = ["judge_method", "judge_rbf"]


def judge_method(method: Method, part: Part) -> Record:
    """Return the record of a method of brdfit; of a refused fit the reason and no figures."""
    start = time.perf_counter()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", BrdfitWarning)
            result = method.fit(part.fitted)
    except BrdfitError as error:
        return _sizes(part) | {"how": f"{type(error).__name__}: {error}"} | _NOTHING
    record = _sizes(part) | {"how": result.outcome.value}
    record["seconds"] = round(time.perf_counter() - start, 3)
    predicted = result.evaluate(part.held_out.wi, part.held_out.wo)
    noise = _noise(result)
    record |= compare(part.held_out, predicted)
    record |= judged(result.outliers, part.planted, part.moved, noise)
    return record | _intervals(result, part.held_out, predicted, noise)


def judge_rbf(part: Part, seed: int) -> Record:
    """Return the record of the log-domain RBF interpolator."""
    try:
        fitted = LogRbf.fit(part.fitted, seed)
    except BrdfitError as error:
        return _sizes(part) | {"how": f"{type(error).__name__}: {error}"} | _NOTHING
    predicted = fitted.evaluate(part.held_out.wi, part.held_out.wo)
    return _sizes(part) | {"how": fitted.settings} | compare(part.held_out, predicted)


_NOTHING: Record = {"median": None, "mean": None}


def _sizes(part: Part) -> Record:
    return {
        "fitted": len(part.fitted),
        "held_out": len(part.held_out),
        "channels": part.fitted.n_channels,
    }


def _noise(result: Reconstruction) -> float:
    """Return s, ln f_r: as the fit states it, else from the residuals of what it believes."""
    stated = result.history[-1].get("noise") if result.history else None
    if stated is not None:
        return float(stated)
    residuals = np.abs(result.residuals[~result.outliers])
    residuals = residuals[np.isfinite(residuals)]
    # of a normal distribution the median deviation is 0.6745 standard deviations
    return float(np.median(residuals) / 0.6745) if residuals.size else 0.0


def _intervals(
    result: Reconstruction, held_out: Samples, predicted: FloatArray, noise: float
) -> Record:
    stated = result.model.stddev(held_out.wi, held_out.wo)
    if stated is None:
        return {}
    floor = float(getattr(result.method, "noise_floor", 0.0))
    compared = held_out.positive & np.isfinite(predicted) & (predicted > 0.0)
    value, f, deviation = held_out.value[compared], predicted[compared], stated[compared]
    z = np.abs(np.log(value / f)) / np.sqrt(deviation**2 + noise**2 + (floor / f) ** 2)
    if not z.size:
        return {"within_68": None, "within_95": None, "stddev": None}
    return {
        "within_68": figure((z <= 1.0).mean()),
        "within_95": figure((z <= result.deviations(0.95)).mean()),
        "stddev": figure(float(np.median(deviation))),
    }
