"""A finished fit without a fit: a Lambertian with a lobe, and samples of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pytest

from brdfit.arrays import FloatArray
from brdfit.geometry import directions_from_spherical, half_diff_from_directions
from brdfit.grid import Grid
from brdfit.progress import Progress, silent
from brdfit.reconstruct.outcome import Outcome
from brdfit.reconstruct.result import Reconstruction
from brdfit.report import fit_figure
from brdfit.samples import Samples


@dataclass(frozen=True)
class Lobe:
    """f_r = albedo / pi + a lobe about the half vector, in any number of channels."""

    channels: int = 3

    def evaluate(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        theta_h, _, _ = half_diff_from_directions(wi, wo)
        colour = np.linspace(0.2, 0.6, self.channels)
        return colour / np.pi + 5.0 * np.exp(-((theta_h / 0.1) ** 2))[:, None]

    def dense(self, grid: Grid, progress: Progress) -> FloatArray:
        return grid.spread(self.evaluate(*grid.directions(grid.cells)))

    def stddev(self, wi: FloatArray, wo: FloatArray) -> FloatArray | None:
        return None


@dataclass(frozen=True)
class Known:
    """A method that knows the answer."""

    name: ClassVar[str] = "known"

    def fit(self, samples: Samples, progress: Progress = silent) -> Reconstruction:
        model = Lobe(samples.n_channels)
        with np.errstate(invalid="ignore", divide="ignore"):
            residuals = np.log(samples.value / model.evaluate(samples.wi, samples.wo))
        residuals = np.where(samples.positive, residuals, np.nan)
        weights = np.where(samples.usable, np.exp(-np.abs(np.nan_to_num(residuals))), 0.0)
        weights = np.repeat(weights.mean(axis=1)[:, None], samples.n_channels, axis=1)
        return Reconstruction(
            samples=samples,
            method=self,
            model=model,
            channel_weights=weights,
            residuals=residuals,
            initial_residuals=residuals * 2.0,
            outliers=samples.usable.any(axis=1) & (weights[:, 0] < 0.5),
            outlier_rule="weight below 0.5",
            outcome=Outcome.CONVERGED,
            iterations=3,
        )


@pytest.fixture
def lobe_samples() -> Callable[..., Samples]:
    """Return samples of the lobe: 5 incidences, the plane of incidence and beside it."""

    def make(channels: int = 3, wavelengths: FloatArray | None = None) -> Samples:
        theta_i, theta_o, phi = (
            grid.ravel()
            for grid in np.meshgrid(
                np.radians([10.0, 30.0, 50.0]),
                np.radians(np.arange(5.0, 80.0, 5.0)),
                np.radians([0.0, 90.0, 180.0]),
                indexing="ij",
            )
        )
        wi = directions_from_spherical(theta_i, np.zeros_like(theta_i))
        wo = directions_from_spherical(theta_o, phi)
        value = Lobe(channels).evaluate(wi, wo)
        value[4] *= 8.0
        value[7, 0] = 0.0
        value[9] = np.nan
        rows = np.arange(len(value)) + 3
        return Samples(wi=wi, wo=wo, value=value, wavelengths=wavelengths, rows=rows)

    return make


@pytest.fixture
def fit_known(lobe_samples: Callable[..., Samples]) -> Callable[..., Reconstruction]:
    """Return a finished reconstruction of `lobe_samples`."""

    def make(channels: int = 3, wavelengths: FloatArray | None = None) -> Reconstruction:
        return Known().fit(lobe_samples(channels, wavelengths))

    return make


@pytest.fixture(autouse=True)
def _small_spheres(monkeypatch: pytest.MonkeyPatch) -> None:
    """Draw spheres of few pixels under few lights: the time of a picture goes there."""
    monkeypatch.setattr(fit_figure, "_SPHERE_SIZE", 16)
    monkeypatch.setattr(fit_figure, "_SPACING", 0.5)
