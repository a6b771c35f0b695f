"""Real measurement files of a folder, one case per material, and how a case is split.

A folder `DIR` holds one folder per laboratory: cornell/*.astm, rgl/*.bsdf (as the
irregular samples that were measured), nist/*.csv, curet/*.dat (each of its materials a
case), rt300s/*.xls (read with the blank beside it). Folders that are missing are left out.
"""

from __future__ import annotations

import hashlib
import warnings
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from brdfit.arrays import BoolArray, FloatArray
from brdfit.bench.ledger import Record, figure
from brdfit.errors import BrdfitError, BrdfitWarning, UsageError
from brdfit.files import sha256_of_file
from brdfit.samples import Samples

if TYPE_CHECKING:
    from brdfit.reconstruct.result import Method

__all__ = [
    "Evaluate",
    "RealCase",
    "Split",
    "compare",
    "find_cases",
    "fit_method",
    "generator",
    "input_hashes",
    "predict_rest",
    "read_case",
    "split",
]

Evaluate = Callable[[FloatArray, FloatArray], FloatArray]
"""f_r (n, channels) at direction pairs (n, 3): what a fit leaves."""

_FOLDERS = {
    "cornell": "*.astm",
    "rgl": "*.bsdf",
    "nist": "*.csv",
    "curet": "*.dat",
    "rt300s": "*.xls",
}
# A measurement without a sample: the reader subtracts it from those beside it.
_BLANK = "blank"
# An RGL file holds every measurement twice, mirrored at the plane of incidence: with both
# halves, what is to be predicted would be copies of what was fitted.
_OPTIONS: dict[str, dict[str, Any]] = {"rgl": {"half": True}}
# What a reader reads beside the file itself.
_BESIDE = {"curet": "table.txt", "rt300s": f"{_BLANK}*.xls"}


@dataclass(frozen=True)
class RealCase:
    """One measured material: a file, or one material of a file."""

    name: str
    """Folder, file and material: stable, the key of records."""
    path: Path
    options: dict[str, Any] = field(default_factory=dict)
    """What `read_samples` is told beside the path."""
    beside: tuple[Path, ...] = ()
    """Files that its reader reads as well: a table of directions, a blank."""


def find_cases(folder: Path) -> list[RealCase]:
    """Return every case below `folder`, sorted by name.

    Raises `UsageError` where there is none.
    """
    cases = []
    for laboratory, pattern in _FOLDERS.items():
        others = _BESIDE.get(laboratory)
        beside = tuple(sorted((folder / laboratory).glob(others))) if others else ()
        for path in sorted((folder / laboratory).glob(pattern)):
            name = f"{laboratory}/{path.name}"
            if path.name.startswith(_BLANK):
                continue
            if laboratory == "curet":
                cases += [
                    RealCase(f"{name}#{material:02d}", path, {"material": material}, beside)
                    for material in _curet_materials(path)
                ]
            else:
                cases.append(RealCase(name, path, _OPTIONS.get(laboratory, {}), beside))
    if not cases:
        looked = ", ".join(f"{name}/{pattern}" for name, pattern in _FOLDERS.items())
        raise UsageError(
            f"{folder}: found no measurements; looked for {looked}. Give the folder that holds "
            f"these folders with --data."
        )
    return cases


def _curet_materials(path: Path) -> list[int]:
    numbers = {line.split(None, 1)[0] for line in path.read_text().splitlines() if line.strip()}
    return sorted(int(number) for number in numbers)


def read_case(case: RealCase) -> Samples:
    """Read the samples of a case; what the reader warns of is counted in the records."""
    from brdfit.formats import read_samples

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", BrdfitWarning)
        return read_samples(case.path, **case.options)


def input_hashes(cases: list[RealCase]) -> dict[str, str]:
    """Return the SHA-256 of every file that is read, by laboratory and file name."""
    read = [path for case in cases for path in (case.path, *case.beside)]
    paths = {f"{path.parent.name}/{path.name}": path for path in read}
    return {name: sha256_of_file(path) for name, path in sorted(paths.items())}


def generator(seed: int, *key: str) -> np.random.Generator:
    """Return random numbers that depend on the seed and the key, and on nothing else."""
    digest = hashlib.sha256("|".join(key).encode()).digest()
    return np.random.default_rng([seed, int.from_bytes(digest[:8], "little")])


@dataclass(frozen=True)
class Split:
    """How the samples of every case are split."""

    fraction: float
    """Share of the usable samples that is fitted."""
    seed: int


def split(samples: Samples, how: Split, name: str) -> tuple[Samples, Samples]:
    """Return (to fit, held out): round(fraction n) of the n usable samples at random, the rest."""
    rows = np.flatnonzero(samples.usable.any(axis=1))
    order = generator(how.seed, name, "split").permutation(rows)
    count = round(how.fraction * rows.size)
    return samples.subset(np.sort(order[:count])), samples.subset(np.sort(order[count:]))


def predict_rest(
    name: str, samples: Samples, how: Split, fit: Callable[[Samples], tuple[Evaluate, str]]
) -> Record:
    """Return the record of one case and one method: the rest predicted from the part.

    `fit` returns the fitted function and how the fit ended. One that ends in an error of
    brdfit's leaves its message and no figures.
    """
    fitted, held_out = split(samples, how, name)
    record: Record = {
        "file": name,
        "samples": len(samples),
        "fitted": len(fitted),
        "held_out": len(held_out),
        "channels": samples.n_channels,
    }
    try:
        evaluate, ending = fit(fitted)
    except BrdfitError as error:
        return record | {"how": f"{type(error).__name__}: {error}", "median": None, "mean": None}
    return record | {"how": ending} | compare(held_out, evaluate(held_out.wi, held_out.wo))


def fit_method(method: Method, samples: Samples) -> tuple[Evaluate, str]:
    """Fit and return the function and the outcome's name; warnings are in the outcome."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", BrdfitWarning)
        result = method.fit(samples)
    return result.evaluate, result.outcome.value


def compare(held_out: Samples, predicted: FloatArray) -> Record:
    """Return how far a prediction (n, channels) is from the held-out samples.

    |delta ln f| over held-out values above zero. A censored one, zero or negative, has no
    logarithm: it is left out and counted, as is a prediction that is not above zero.
    """
    wanted: BoolArray = held_out.positive
    with np.errstate(invalid="ignore"):
        answered = np.isfinite(predicted) & (predicted > 0.0)
    both = wanted & answered
    error = np.abs(np.log(predicted[both] / held_out.value[both]))
    return {
        "compared": int(both.sum()),
        "censored": int(held_out.censored.sum()),
        "missing": int(held_out.value.size - held_out.usable.sum()),
        "without_prediction": int((wanted & ~answered).sum()),
        "median": figure(np.median(error)) if error.size else None,
        "mean": figure(error.mean()) if error.size else None,
    }
