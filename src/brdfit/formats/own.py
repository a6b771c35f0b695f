"""The layout of samples in our own CSV and Parquet files: reads back exactly.

Columns: wi_x wi_y wi_z wo_x wo_y wo_z, the channels, sigma_ before each channel where there
is a standard deviation, brdfit_flags, brdfit_row. A header (JSON) beside them holds channel
names, wavelengths and where the samples came from. Without it the column names alone are
still unambiguous.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any

import numpy as np

from brdfit.arrays import BoolArray, FloatArray, IntArray
from brdfit.errors import CorruptFile
from brdfit.formats.columns import OWN_ROW
from brdfit.formats.declaration import OWN_FLAGS
from brdfit.samples import Flag, Samples, Source

__all__ = [
    "OwnHeader",
    "own_columns",
    "own_matrix",
    "own_source",
    "samples_from_own",
    "source_from_record",
    "source_record",
]

_DIRECTIONS = ("wi_x", "wi_y", "wi_z", "wo_x", "wo_y", "wo_z")
_VERSION = 1


@dataclass(frozen=True)
class OwnHeader:
    """What the columns cannot hold."""

    channels: tuple[str, ...]
    wavelengths: tuple[float, ...] | None
    has_sigma: bool
    has_rows: bool
    source: Source

    @classmethod
    def of(cls, samples: Samples) -> OwnHeader:
        """Return the header that describes `samples`."""
        waves = samples.wavelengths
        return cls(
            channels=samples.channels,
            wavelengths=None if waves is None else tuple(float(wave) for wave in waves),
            has_sigma=samples.sigma is not None,
            has_rows=samples.rows is not None,
            source=samples.source,
        )

    def to_json(self) -> str:
        """Return the header in one line."""
        return json.dumps(
            {
                "version": _VERSION,
                "channels": list(self.channels),
                "wavelengths": None if self.wavelengths is None else list(self.wavelengths),
                "sigma": self.has_sigma,
                "rows": self.has_rows,
                "source": source_record(self.source),
            }
        )

    @classmethod
    def from_json(cls, text: str, file: str) -> OwnHeader:
        """Read what `to_json` wrote; `CorruptFile` for anything else."""
        try:
            raw: dict[str, Any] = json.loads(text)
            waves = raw["wavelengths"]
            version = int(raw["version"])
            header = cls(
                channels=tuple(str(name) for name in raw["channels"]),
                wavelengths=None if waves is None else tuple(float(wave) for wave in waves),
                has_sigma=bool(raw["sigma"]),
                has_rows=bool(raw["rows"]),
                source=source_from_record(raw["source"]),
            )
        except (ValueError, KeyError, TypeError, AttributeError) as error:
            raise CorruptFile(
                f"{file}: the header of a brdfit samples file is damaged "
                f"({type(error).__name__}: {error}). Remove that line to have the columns "
                f"guessed from their names."
            ) from error
        if version > _VERSION:
            raise CorruptFile(
                f"{file}: found version {version} of the samples layout but this brdfit reads "
                f"up to {_VERSION}. Update brdfit."
            )
        return header

    def column_names(self) -> tuple[str, ...]:
        """Return the names of all columns, in order."""
        sigma = tuple(f"sigma_{name}" for name in self.channels) if self.has_sigma else ()
        rows = (OWN_ROW,) if self.has_rows else ()
        return (*_DIRECTIONS, *self.channels, *sigma, OWN_FLAGS, *rows)


def own_matrix(samples: Samples) -> FloatArray:
    """Return the floating-point columns (n, 6 + channels [+ channels]) of `samples`."""
    sigma = [] if samples.sigma is None else [samples.sigma]
    return np.hstack([samples.wi, samples.wo, samples.value, *sigma])


def own_columns(samples: Samples) -> list[FloatArray | IntArray]:
    """Return all columns (n,) in the order of `OwnHeader.column_names`."""
    columns: list[FloatArray | IntArray] = list(own_matrix(samples).T)
    columns.append(samples.bits)
    if samples.rows is not None:
        columns.append(samples.rows)
    return columns


def samples_from_own(
    header: OwnHeader, cells: FloatArray, readable: BoolArray, lines: IntArray, source: Source
) -> Samples:
    """Return the samples of our own columns.

    `cells` (n, columns) are all columns as floats; rows that were damaged since are
    flagged, and have their line in this file for want of another.
    """
    n = len(header.channels)
    bits = np.nan_to_num(cells[:, 6 + n * (1 + header.has_sigma)]).astype(np.int64)
    rows = None
    if header.has_rows:
        rows = np.where(readable, np.nan_to_num(cells[:, -1]).astype(np.int64), lines)
    return Samples(
        wi=cells[:, :3],
        wo=cells[:, 3:6],
        value=cells[:, 6 : 6 + n],
        sigma=cells[:, 6 + n : 6 + 2 * n] if header.has_sigma else None,
        wavelengths=None if header.wavelengths is None else np.array(header.wavelengths),
        channels=header.channels,
        flags=bits | np.where(readable, 0, int(Flag.UNREADABLE)),
        rows=rows,
        source=source,
    )


def source_record(source: Source) -> dict[str, Any]:
    """Return a source as JSON-able values."""
    return {
        "name": source.name,
        "format": source.format,
        "sha256": source.sha256,
        "convention": source.convention,
        "notes": list(source.notes),
        "metadata": source.metadata,
    }


def source_from_record(record: Any) -> Source:
    """Return what `source_record` was made of; an error of Python's for anything else."""
    return Source(
        name=str(record["name"]),
        format=str(record["format"]),
        sha256=str(record["sha256"]),
        convention=str(record["convention"]),
        notes=tuple(str(note) for note in record["notes"]),
        metadata={str(k): str(v) for k, v in record["metadata"].items()},
    )


def own_source(first: Source, now: Source) -> Source:
    """Return the source of what is read back: this file, its origin `first` in the metadata."""
    origin = {"origin.name": first.name, "origin.format": first.format}
    if first.sha256:
        origin["origin.sha256"] = first.sha256
    return Source(
        name=now.name,
        format=now.format,
        sha256=now.sha256,
        convention=first.convention or "unit vectors, normal = +z; values are f_r, 1/sr",
        notes=(*first.notes, *now.notes),
        metadata={**first.metadata, **origin},
    )
