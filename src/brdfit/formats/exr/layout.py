"""Where a cell stands in the atlas, and what the attribute `brdfit` of the header says.

The attribute is JSON: version, grid (n_theta_h, n_theta_d, n_phi_d), columns (tiles beside one
another), channels, planes (the picture's channel that holds each), wavelengths, source.
"""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from brdfit.arrays import FloatArray
from brdfit.errors import CorruptFile
from brdfit.formats.own import source_from_record, source_record
from brdfit.grid import Grid
from brdfit.samples import Source
from brdfit.table import Table

__all__ = ["ATTRIBUTE", "Atlas"]

ATTRIBUTE = "brdfit"
_VERSION = 1
_MOST_CELLS = 1 << 26
_MOST_CHANNELS = 4096
# What a damaged attribute meets on its way.
_DAMAGE = (ValueError, KeyError, TypeError, AttributeError, OverflowError, RecursionError)


@dataclass(frozen=True)
class Atlas:
    """What the header says."""

    grid: Grid
    columns: int
    """Tiles beside one another."""
    channels: tuple[str, ...]
    planes: tuple[str, ...]
    """Name of the picture's channel, for each channel."""
    wavelengths: tuple[float, ...] | None
    source: Source

    @classmethod
    def of(cls, table: Table) -> Atlas:
        """Return the atlas of a table, about as wide as high."""
        n_h, n_d, n_phi = table.grid.shape
        columns = min(max(round(math.sqrt(n_phi * n_d / n_h)), 1), n_phi)
        # a divisor near the square leaves no tile empty
        columns = min(
            (c for c in range(1, n_phi + 1) if n_phi % c == 0), key=lambda c: abs(c - columns)
        )
        waves = table.wavelengths
        return cls(
            grid=table.grid,
            columns=columns,
            channels=table.channels,
            planes=_plane_names(table.channels),
            wavelengths=None if waves is None else tuple(waves.tolist()),
            source=table.source,
        )

    @property
    def shape(self) -> tuple[int, int]:
        """(height, width) of the picture."""
        rows = -(-self.grid.n_phi_d // self.columns)
        return rows * self.grid.n_theta_d, self.columns * self.grid.n_theta_h

    def picture(self, cells: FloatArray) -> FloatArray:
        """Return (height, width) of values (n_theta_h, n_theta_d, n_phi_d); NaN in empty tiles."""
        n_h, n_d, n_phi = self.grid.shape
        rows = self.shape[0] // n_d
        tiles = np.full((rows * self.columns, n_d, n_h), np.nan)
        # theta_d upward: the last node in the first row of pixels
        tiles[:n_phi] = cells.transpose(2, 1, 0)[:, ::-1]
        across = tiles.reshape(rows, self.columns, n_d, n_h).transpose(0, 2, 1, 3)
        return np.ascontiguousarray(across).reshape(self.shape)

    def cells(self, picture: FloatArray) -> FloatArray:
        """Return (n_theta_h, n_theta_d, n_phi_d) of a picture; the inverse of `picture`."""
        n_h, n_d, n_phi = self.grid.shape
        rows = self.shape[0] // n_d
        tiles = picture.reshape(rows, n_d, self.columns, n_h).transpose(0, 2, 1, 3)
        tiles = tiles.reshape(rows * self.columns, n_d, n_h)[:n_phi]
        return np.asarray(tiles[:, ::-1].transpose(2, 1, 0))

    def to_json(self) -> str:
        """Return the attribute."""
        return json.dumps(
            {
                "version": _VERSION,
                "grid": list(self.grid.shape),
                "columns": self.columns,
                "channels": list(self.channels),
                "planes": list(self.planes),
                "wavelengths": None if self.wavelengths is None else list(self.wavelengths),
                "source": source_record(self.source),
            }
        )

    @classmethod
    def from_json(cls, text: str, file: str) -> Atlas:
        """Read what `to_json` wrote; `CorruptFile` for anything else."""
        try:
            raw: dict[str, Any] = json.loads(text)
            version = int(raw["version"])
            n_h, n_d, n_phi = (int(size) for size in raw["grid"])
            waves = raw["wavelengths"]
            columns = int(raw["columns"])
            channels = tuple(str(name) for name in raw["channels"])
            planes = tuple(str(name) for name in raw["planes"])
            fits = 0 < len(channels) == len(planes) == len(set(planes)) <= _MOST_CHANNELS
            if not fits or not 1 <= columns <= n_phi or n_h * n_d * n_phi > _MOST_CELLS:
                raise ValueError("sizes that no atlas has")
            atlas = cls(
                grid=Grid(n_h, n_d, n_phi),
                columns=columns,
                channels=channels,
                planes=planes,
                wavelengths=None if waves is None else tuple(float(wave) for wave in waves),
                source=source_from_record(raw["source"]),
            )
        except _DAMAGE as error:
            raise CorruptFile(
                f"{file}: the attribute {ATTRIBUTE!r} of the header is damaged "
                f"({type(error).__name__}: {error}). Write the table again."
            ) from error
        if version > _VERSION:
            raise CorruptFile(
                f"{file}: found version {version} of the atlas but this brdfit reads up to "
                f"{_VERSION}. Update brdfit."
            )
        return atlas


def _plane_names(channels: tuple[str, ...]) -> tuple[str, ...]:
    """Return names that picture viewers show: R, G, B; Y for one; else those of the channels.

    A dot would begin a layer, so that 400.5nm becomes 400,5nm.
    """
    if len(channels) == 1:
        return ("Y",)
    colour = tuple(name[:1].upper() for name in channels)
    if colour == ("R", "G", "B"):
        return colour
    names = tuple(name.replace(".", ",") for name in channels)
    usable = all(names) and len(set(names)) == len(names) and all(len(n) < 200 for n in names)
    return names if usable else tuple(f"channel{k:04}" for k in range(len(channels)))
