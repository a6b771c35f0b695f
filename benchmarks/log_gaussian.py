"""What a population is worth as a prior: held-out real measurements under a Gaussian in ln f_r.

The mean and the covariance of the log-columns of a population (every channel of every member
a column, each with its weight) are a Gaussian prior; samples condition it; the rest of the file
is predicted. Its scale and the noise follow from the marginal likelihood of the samples that
are fitted. With `residual` the prior has a second, local part: a Matern kernel in half and
difference angles, with amplitude and length from the same likelihood. No outliers, no weights
of samples: the plainest method that leans on mean and covariance, and on nothing else.

    python benchmarks/populations.py ...            every population on the reporting half
    python benchmarks/population_shares.py ...      shares of the families on the choosing half
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.spatial.distance import cdist

from brdfit.arrays import BoolArray, FloatArray
from brdfit.bench.real_files import RealCase, find_cases, generator, read_case
from brdfit.geometry import half_diff_from_directions
from brdfit.populations import Population
from brdfit.samples import Samples

SEED = 1
HELD_OUT = 600
"""At most so many samples of a file are predicted."""
BANDS = 4
"""At most so many channels of a spectral file, evenly spread."""
INCIDENCES = 2.0 / 3.0
"""Share of the angles of incidence, from the normal on, that a blind setting may see."""

# Hyper-parameters that the likelihood chooses from: scale of the population's covariance,
# variance of the noise, length scales and variances of the residual.
_SCALES = (0.25, 1.0, 3.0, 10.0)
_NOISES = np.array([1e-5, 1e-4, 3e-4, 1e-3, 3e-3, 1e-2, 3e-2, 0.1, 0.3])
_LENGTHS = ((0.08, 0.35), (0.15, 0.5), (0.3, 1.0))
_VARIANCES = (0.01, 0.1)


@dataclass(frozen=True)
class Setting:
    """How a file is split, and with which prior the rest is predicted."""

    samples: int
    residual: bool = False
    blind: bool = False
    """The held-out samples have angles of incidence that no fitted one has, nearer to grazing."""

    def __str__(self) -> str:
        words = [str(self.samples), "residual" * self.residual, "blind" * self.blind]
        return " ".join(word for word in words if word)


SETTINGS = (
    Setting(100),
    Setting(1000),
    Setting(100, residual=True),
    Setting(1000, residual=True),
    Setting(100, residual=True, blind=True),
)


def halves(folder: Path) -> dict[str, list[RealCase]]:
    """Return the files for choosing and those for reporting.

    Of each laboratory's files in alphabetical order the first, third, ... are for choosing.
    """
    by_laboratory: dict[str, list[RealCase]] = {}
    for case in find_cases(folder):
        by_laboratory.setdefault(case.name.split("/")[0], []).append(case)
    files = by_laboratory.values()
    return {
        "choosing": [case for cases in files for case in cases[0::2]],
        "reporting": [case for cases in files for case in cases[1::2]],
    }


@dataclass(frozen=True, eq=False)
class Trial:
    """A split file: the first `n` rows are fitted, the others predicted."""

    name: str
    setting: Setting
    n: int
    wi: FloatArray
    wo: FloatArray
    log_value: FloatArray
    """(rows, channels); 0 where not known."""
    known: BoolArray

    @classmethod
    def of(cls, case: RealCase, setting: Setting, draw: int = 0) -> Trial | None:
        """Return the trial of one draw, or None where the file has too few samples for it."""
        samples = read_case(case)
        some = np.linspace(0, samples.n_channels - 1, min(BANDS, samples.n_channels))
        samples = samples.select_channels(list(some.round().astype(int)))
        rows = _split(case, samples, setting, draw)
        if rows is None:
            return None
        known = samples.positive[rows]
        logs = np.log(np.where(known, samples.value[rows], 1.0))
        n = setting.samples
        return cls(case.name, setting, n, samples.wi[rows], samples.wo[rows], logs, known)

    @property
    def laboratory(self) -> str:
        """Folder of the file."""
        return self.name.split("/")[0]

    def kernels(self) -> list[tuple[FloatArray | float, float]]:
        """Return the residual covariances (rows, n) to choose from, each with its variance."""
        kernels: list[tuple[FloatArray | float, float]] = [(0.0, 0.0)]
        if self.setting.residual:
            theta_h, theta_d, phi_d = half_diff_from_directions(self.wi, self.wo)
            r = np.sin(theta_h) * np.sin(theta_d)
            x = np.stack([theta_d / (np.pi / 2), r * np.cos(2 * phi_d), r * np.sin(2 * phi_d)], 1)
            narrow = np.sqrt(theta_h / (np.pi / 2))[:, None]
            for of_half, of_others in _LENGTHS:
                scaled = np.hstack([narrow / of_half, x / of_others])
                h = np.sqrt(5.0) * cdist(scaled, scaled[: self.n])
                matern = (1.0 + h + h * h / 3.0) * np.exp(-h)
                kernels += [(variance * matern, variance) for variance in _VARIANCES]
        return kernels


def _split(case: RealCase, samples: Samples, setting: Setting, draw: int) -> FloatArray | None:
    usable = np.flatnonzero(samples.usable.any(axis=1))
    key = (case.name, str(setting.samples), "population", str(draw))
    order = generator(SEED, *key).permutation(usable)
    fitted, others = order[: setting.samples], order[setting.samples :]
    if setting.blind:
        theta_i = np.degrees(np.arccos(np.clip(samples.wi[:, 2], 0.0, 1.0))).round(1)
        seen = theta_i <= np.quantile(np.unique(theta_i[usable]), INCIDENCES)
        fitted, others = order[seen[order]][: setting.samples], order[~seen[order]]
    if fitted.size < setting.samples or others.size < setting.samples / 4:
        return None
    return np.concatenate([fitted, others[:HELD_OUT]])


def log_columns(population: Population, trial: Trial) -> FloatArray:
    """Return ln f_r (rows, columns), every channel of every member a column."""
    logs = population.log_values(trial.wi, trial.wo).astype(np.float64)
    return np.moveaxis(logs, 2, 1).reshape(len(logs), -1)


@dataclass(frozen=True, eq=False)
class Moments:
    """What a prior is made of: mean (rows,) and mean product with the fitted rows (rows, n)."""

    mean: FloatArray
    product: FloatArray

    @classmethod
    def of(cls, population: Population, trial: Trial) -> Moments:
        """Return the moments of a population's columns at the rows of a trial."""
        logs = log_columns(population, trial)
        weights = np.tile(population.weights, len(population.channels))
        weighted = logs * (weights / weights.sum())
        return cls(weighted.sum(axis=1), weighted @ logs[: trial.n].T)

    @classmethod
    def mixed(cls, parts: Sequence[Moments], shares: Sequence[float]) -> Moments:
        """Return the moments of several populations, each with a share."""
        share = np.asarray(shares) / np.sum(shares)
        return cls(
            sum(s * part.mean for s, part in zip(share, parts, strict=True)),
            sum(s * part.product for s, part in zip(share, parts, strict=True)),
        )

    def covariance(self) -> FloatArray:
        """Return the covariance of all rows with the fitted ones, (rows, n)."""
        return self.product - np.outer(self.mean, self.mean[: self.product.shape[1]])


def mean_error(
    trial: Trial, prior: Moments, kernels: list[tuple[FloatArray | float, float]]
) -> float:
    """Return mean |delta ln f| over the known held-out values, all channels together."""
    covariance, n = prior.covariance(), trial.n
    errors = []
    for channels, rows in _same_rows(trial.known[:n]):
        target = (trial.log_value - prior.mean[:, None])[:, channels]
        predicted = _most_likely(covariance, kernels, rows, target[rows])
        known = trial.known[n:][:, channels]
        errors.append(np.abs(predicted[n:] - target[n:])[known])
    return float(np.concatenate(errors).mean())


def _same_rows(known: BoolArray) -> Iterable[tuple[list[int], FloatArray]]:
    """Yield (channels, fitted rows) such that the channels are known at the same rows."""
    patterns: dict[bytes, list[int]] = {}
    for channel in range(known.shape[1]):
        patterns.setdefault(known[:, channel].tobytes(), []).append(channel)
    for channels in patterns.values():
        rows = np.flatnonzero(known[:, channels[0]])
        if rows.size >= 8:
            yield channels, rows


def _most_likely(
    covariance: FloatArray,
    kernels: list[tuple[FloatArray | float, float]],
    rows: FloatArray,
    target: FloatArray,
) -> FloatArray:
    """Return the deviation from the mean (all rows, channels) under the likeliest prior."""
    best, found = -np.inf, np.zeros((len(covariance), target.shape[1]))
    for kernel, variance in kernels:
        whole = (covariance + kernel)[:, rows]
        values, vectors = np.linalg.eigh(whole[rows])
        values = np.maximum(values, 0.0)
        along = vectors.T @ target
        for scale in (1.0,) if variance else _SCALES:
            spread = scale * values[:, None] + _NOISES
            squared = np.mean(along**2, axis=1)[:, None]
            likelihood = -0.5 * np.sum(np.log(spread) + squared / spread, axis=0)
            k = int(np.argmax(likelihood))
            if likelihood[k] > best:
                best = float(likelihood[k])
                found = scale * (whole @ (vectors @ (along / spread[:, k : k + 1])))
    return found
