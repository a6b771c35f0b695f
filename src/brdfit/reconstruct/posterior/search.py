"""What a fit tries and how long, and the population that it tries it with."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from brdfit.arrays import FloatArray
from brdfit.reconstruct.posterior.kernel import Angles, taken

__all__ = ["Design", "Search"]


@dataclass(frozen=True)
class Search:
    """What is tried, and how long."""

    shapes: tuple[tuple[float, float], ...] = ((0.15, 1), (0.4, 1), (0.4, 3), (1, 1), (1, 3))
    """Length and stretch of the kernels; each is tried at the first amplitude..."""
    amplitudes: tuple[float, ...] = (0.3, 0.1, 1.0)
    """...and the best of them at the others..."""
    grazing: float = 0.25
    """...and the best of those with the horizon further away."""
    lobe: float = 0.5
    """The same with an e-fold of the population's f_r as so many lengths of distance..."""
    following: tuple[tuple[float, float], ...] = ((0.4, 1), (0.4, 3), (1, 1), (1, 3))
    """...for these shapes: the shortest follows any lobe by itself..."""
    worth: float = 0.01
    """...is kept where left-out samples are likelier by so much in ln for each believed..."""
    heard: float = 0.1
    """...and not tried where the first stage believes a smaller share: it knows of no lobe."""
    section_steps: int = 2
    """Steps in which members like the material say what f_r that is."""

    starts: int = 6
    first_steps: int = 12
    proving_steps: int = 12
    """Steps that a start takes, and goes on for to show where it leads."""
    screening_steps: int = 3
    second_steps: int = 8
    last_steps: int = 4
    patience: int = 2
    """Times as many are taken, in these two, while they make left-out samples likelier."""
    screening_rows: int = 500
    screening_channels: int = 6
    """Samples and channels that kernels are compared on, evenly drawn."""
    rows: int = 1000
    """Samples that the search looks at; the rest join in when it is over."""
    centres: int = 1500
    """Samples that the residual may hang on."""
    most: int = 10_000
    """Samples that decide the result; all others are judged by it."""
    leading: int = 80
    """Directions of the prior in the first stage, at most..."""
    rows_per_direction: int = 8
    """...and samples that each of them wants: with fewer, outliers find a place in the prior."""
    nearest: int = 10
    reach: float = 3.0
    mix: float = 0.01


@dataclass(frozen=True, eq=False)
class Design:
    """A population at the samples: [mu | B] (n, 1 + q), V (columns, q), column weights."""

    components: FloatArray
    axes: FloatArray
    weights: FloatArray
    angles: Angles
    section: FloatArray
    """[mu | B] (h, d, 1 + q) at the nodes of `section.SECTION`."""

    def take(self, index: np.ndarray) -> Design:
        """Return some of the rows."""
        return replace(self, components=self.components[index], angles=taken(self.angles, index))

    def sizes(self) -> FloatArray:
        """Return the root mean square of each component (q,) at the samples."""
        squares = (self.components[:, 1:].astype(np.float64) ** 2).mean(axis=0)
        return np.asarray(np.sqrt(squares))

    def columns(self) -> FloatArray:
        """Return ln f_r (n, k) of the columns that may be leaned on."""
        used = self.axes[self.weights > 0.0].astype(np.float32)
        return np.asarray(self.components[:, :1] + self.components[:, 1:] @ used.T)
