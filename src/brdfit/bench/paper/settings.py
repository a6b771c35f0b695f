"""What decides the figures of the poster's tables, and what they are made of."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any

from brdfit.bench.outliers import DEFAULT_OUTLIERS, OUTLIER_MODELS
from brdfit.bench.paper.poster import DATA_RATIOS, OUTLIER_RATIOS
from brdfit.errors import UsageError
from brdfit.grid import MERL_GRID, Grid

__all__ = ["FEW_ROWS", "METRICS", "PARTS", "FewRow", "PaperSettings"]

METRICS = ("linear", "root", "log")
"""The error metrics of the poster, in its order."""

PARTS = {
    "errors": "the tables of errors by outlier and data ratio",
    "few": "the tables of errors of few samples",
    "sensitivity": "the table of sensitivity to the error metric",
    "expressiveness": "each correction function described by the others",
    "real": "real files: a part fitted, the rest predicted",
}
"""What `brdfit bench paper` makes, part by part."""

FewRow = tuple[int, str]
"""Number of samples, and outlier model: a table of the part "few"."""

FEW_ROWS: tuple[FewRow, ...] = (
    (110_000, "factor"),
    *((count, model) for count in (1000, 100) for model in ("factor", "uniform")),
)
"""Those that are made unless others are asked for."""

# Samples above which one draw of directions does not differ from another.
_MANY = 5000


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
    few: tuple[FewRow, ...] = FEW_ROWS
    """Samples and outlier model of each table of few samples, every one once."""
    few_draws: int = 5
    """Draws of directions of few samples; each material has one of them. Where there are many
    samples all materials share one: it is as good as any other."""
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
        for count, model in self.few if "few" in self.parts else ():
            if not 0 < count <= self.grid.cells.size or model not in OUTLIER_MODELS:
                raise UsageError(
                    f"few: found {count}:{model} but a row is a number of samples up to the "
                    f"{self.grid.cells.size:,} cells of the grid, and one of "
                    f"{', '.join(OUTLIER_MODELS)}."
                )
        unknown = sorted(set(self.parts) - set(PARTS))
        if unknown:
            raise UsageError(f"parts: found {unknown[0]!r} but known are {', '.join(PARTS)}.")

    def draws_of(self, count: int) -> int:
        """Return how many draws of so many samples there are."""
        return self.few_draws if count <= _MANY else 1

    def record(self) -> dict[str, Any]:
        """Return the settings as JSON-able values."""
        values = dataclasses.asdict(self)
        values["grid"] = list(self.grid.shape)
        if "few" not in self.parts:
            del values["few"], values["few_draws"]
        return values
