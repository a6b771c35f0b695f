"""Write a table as an RGL measurement, as finely as it needs."""

from __future__ import annotations

import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np

from brdfit.errors import DataQualityWarning, UsageError
from brdfit.files import atomic_path
from brdfit.formats.rgl.measurement import Measurement, measurement_to_bytes
from brdfit.formats.rgl.parameterisation import Parameterisation
from brdfit.formats.rgl.probes import Probes
from brdfit.formats.rgl.tabulate import Resolution, tabulated
from brdfit.formats.xyz import refuse_other_channels
from brdfit.samples import Source
from brdfit.table import Table
from brdfit.versions import version_of

__all__ = ["LADDER", "write_table"]

LADDER = (
    Resolution(12, 24, 48),
    Resolution(24, 48, 96),
    Resolution(32, 96, 128),
    Resolution(48, 128, 128),
    Resolution(64, 160, 160),
)
"""What is tried, the coarsest first."""

# Difference from the table at which a finer file is no longer worth its size.
_CLOSE = 0.01
_NOT_CLOSE = 0.03
_MOST_BYTES = 128 << 20


def write_table(table: Table, path: Path) -> None:
    """Write the coarsest of five resolutions that is close to the table, else the finest.

    Close is a mean |delta ln f| of at most 0.01, over pairs of directions within 80 degrees of
    the normal, half of them spread evenly, half as the nodes of the MERL grid are, and a
    directional albedo within 1 % of the table's at seven incidences. Where the mean is above 0.03
    a `DataQualityWarning` says so. One channel is written as three equal ones,
    bands of wavelengths as spectra. Raises `UsageError` for other channels, or a table
    without values.
    """
    if table.wavelengths is None:
        refuse_other_channels(table, path, "an RGL file without wavelengths")
    if not table.mask.any():
        raise UsageError(f"{path.name}: the table has no valid cell, so there is nothing to write.")
    measurement, off = _fine_enough(table)
    if off > _NOT_CLOSE:
        warnings.warn(
            f"{path.name}: differs from the table by {off:.1%} in the mean, at the finest "
            f"resolution that fits into {_MOST_BYTES >> 20} MiB.",
            DataQualityWarning,
            stacklevel=3,
        )
    content = measurement_to_bytes(_labelled(measurement, table))
    with atomic_path(path) as aside:
        aside.write_bytes(content)


def _fine_enough(table: Table) -> tuple[Measurement, float]:
    """Return the measurement and its mean |delta ln f|."""
    probes = Probes.of(table)
    channels = max(table.n_channels, 3)
    fitting = [r for r in LADDER if r.size(channels) <= _MOST_BYTES] or LADDER[:1]
    for resolution in fitting:
        measurement = tabulated(table, resolution)
        off, albedo_off = probes.differences(Parameterisation.of(measurement))
        if off <= _CLOSE and albedo_off <= _CLOSE:
            break
    return measurement, off


def _labelled(measurement: Measurement, table: Table) -> Measurement:
    values, wavelengths = measurement.values, table.wavelengths
    if wavelengths is not None:
        order = np.argsort(wavelengths)
        values, wavelengths = values[..., order], wavelengths[order]
    elif values.shape[3] == 1:
        values = np.repeat(values, 3, axis=3)
    return replace(
        measurement,
        values=values,
        wavelengths=wavelengths,
        description=_description(table.source),
    )


def _description(source: Source) -> str:
    name = source.metadata.get("description") or source.name
    origin = f" from {source.name}" if name != source.name else ""
    digest = f", SHA-256 {source.sha256}" if source.sha256 else ""
    return f"{name} (written by brdfit {version_of()}{origin}{digest})"
