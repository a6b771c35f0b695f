"""What decides the figures of the poster's tables, and what they are made of."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any

from brdfit.bench.outliers import DEFAULT_OUTLIERS, OUTLIER_MODELS
from brdfit.bench.paper.poster import DATA_RATIOS, OUTLIER_RATIOS
from brdfit.errors import UsageError
from brdfit.grid import MERL_GRID, Grid

__all__ = ["METRICS", "PARTS", "PaperSettings"]

METRICS = ("linear", "root", "log")
"""The error metrics of the poster, in its order."""

PARTS = {
    "errors": "the tables of errors by outlier and data ratio",
    "sensitivity": "the table of sensitivity to the error metric",
    "expressiveness": "each correction function described by the others",
    "real": "real files: a part fitted, the rest predicted",
}
"""What `brdfit bench paper` makes, part by part."""


@dataclass(frozen=True)
class PaperSettings:
    """Everything that a figure depends on, beside the population, the files and the code."""

    seed: int = 1
    outliers: str = DEFAULT_OUTLIERS
    """Outlier model, see `brdfit.bench.outliers`."""
    universe: float = 0.05
    """Share of the grid's cells that are measurements at data ratio 1; 1 is every cell."""
    data_ratios: tuple[float, ...] = DATA_RATIOS
    outlier_ratios: tuple[float, ...] = OUTLIER_RATIOS
    materials: int = 0
    """How many materials are reconstructed, spread over the population; 0 is all. Each
    still leans on all others."""
    image_size: int = 64
    """Pixels across the sphere of the perceptual error."""
    fraction: float = 0.2
    """Share of the usable samples of a real file that is fitted."""
    parts: tuple[str, ...] = tuple(PARTS)
    grid: Grid = MERL_GRID

    def __post_init__(self) -> None:
        if self.outliers not in OUTLIER_MODELS:
            raise UsageError(
                f"outlier model: found {self.outliers!r} but known are {', '.join(OUTLIER_MODELS)}."
            )
        for name, ratios in (("data", self.data_ratios), ("outlier", self.outlier_ratios)):
            if not ratios or not all(0.0 <= ratio <= 1.0 for ratio in ratios):
                raise UsageError(f"{name} ratios: found {ratios} but each is between 0 and 1.")
        if not 0.0 < self.universe <= 1.0:
            raise UsageError(f"universe: found {self.universe} but it is a share above 0, up to 1.")
        unknown = sorted(set(self.parts) - set(PARTS))
        if unknown:
            raise UsageError(f"parts: found {unknown[0]!r} but known are {', '.join(PARTS)}.")

    def record(self) -> dict[str, Any]:
        """Return the settings as JSON-able values."""
        values = dataclasses.asdict(self)
        values["grid"] = list(self.grid.shape)
        return values
