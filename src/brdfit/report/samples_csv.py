"""The samples of a fit as a CSV: what was measured, what became of each, in file order."""

from __future__ import annotations

import warnings
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from brdfit.arrays import BoolArray, FloatArray
from brdfit.errors import BrdfitWarning, CorruptFile
from brdfit.geometry import spherical_from_directions
from brdfit.reconstruct.result import Reconstruction
from brdfit.samples import Flag, Samples

__all__ = ["Judged", "read_samples_csv", "write_samples_csv"]

_DIRECTIONS = ("theta_i_deg", "phi_i_deg", "theta_o_deg", "phi_o_deg")
_RESIDUAL = "residual_"


@dataclass(frozen=True, eq=False)
class Judged:
    """The samples of a fit and what became of each, as in `Reconstruction`."""

    samples: Samples
    weights: FloatArray
    """(n,) in [0, 1]."""
    residuals: FloatArray
    """(n, channels) ln(value / result); NaN where not comparable."""
    outliers: BoolArray
    """(n,) usable, and named as wrong."""

    @classmethod
    def of(cls, result: Reconstruction) -> Judged:
        """Return the samples of `result` and its verdicts."""
        return cls(result.samples, result.weights, result.residuals, result.outliers)

    @property
    def rows(self) -> list[int]:
        """Line or record of the source, from 1, of each sample."""
        known = self.samples.rows
        return list(range(1, len(self.samples) + 1)) if known is None else known.tolist()


def write_samples_csv(result: Reconstruction, path: Path) -> None:
    """Write one line a sample, in the order of the file.

    | column                  | unit and meaning                                         |
    |-------------------------|----------------------------------------------------------|
    | `brdfit_row`            | line or record of the source, from 1                     |
    | `theta_i_deg` ...       | directions of light and detector: theta_i, phi_i,        |
    |                         | theta_o, phi_o in degrees                                |
    | channel names           | f_r as measured, 1/sr                                    |
    | `weight`                | in [0, 1], mean over the channels                        |
    | `outlier`               | 1 if used, but found to disagree with the rest           |
    | `residual_<channel>`    | ln(value / result)                                       |
    | `weight_<channel>`      | where the channels have verdicts of their own            |
    | `flags`, `brdfit_flags` | what is wrong with the sample, in words and as bits      |

    An empty field is a number that is not there. `brdfit.read_samples` reads the file back:
    the names say what the columns are.
    """
    import pyarrow as pa
    from pyarrow import csv

    arrays = {name: pa.array(column, from_pandas=True) for name, column in _columns(result).items()}
    options = csv.WriteOptions(quoting_style="needed")
    with path.open("wb") as stream:
        csv.write_csv(pa.table(arrays), stream, options)


def read_samples_csv(path: Path) -> Judged:
    """Read what `write_samples_csv` wrote; raises `CorruptFile` for anything else.

    Warnings about the samples are not repeated: they were given when they were fitted.
    """
    import pyarrow as pa
    from pyarrow import csv

    from brdfit.formats import read_samples

    try:
        table = csv.read_csv(path)
    except pa.ArrowInvalid as error:
        raise CorruptFile(f"{path.name}: cannot be read as a CSV ({error}).") from error
    names = table.column_names
    channels = [name.removeprefix(_RESIDUAL) for name in names if name.startswith(_RESIDUAL)]
    expected = ["brdfit_row", *_DIRECTIONS, *channels, "weight", "outlier", "brdfit_flags"]
    missing = [name for name in expected if name not in names]
    if missing or not channels:
        raise CorruptFile(
            f"{path.name}: the column {(missing or [_RESIDUAL + '...'])[0]!r} is missing; expected "
            f"the samples that brdfit fit writes beside its table. Fit again to have them."
        )

    def column(name: str) -> FloatArray:
        try:
            return np.asarray(table[name].to_numpy(), dtype=np.float64)
        except ValueError as error:
            raise CorruptFile(
                f"{path.name}: the column {name!r} holds something else than numbers ({error})."
            ) from error

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", BrdfitWarning)
        samples = read_samples(
            path,
            format="delimited",
            directions=_DIRECTIONS,
            values=channels,
            angles="degrees",
            flags="brdfit_flags",
        )
    rows = column("brdfit_row").astype(np.int64)
    return Judged(
        samples=replace(samples, rows=rows),
        weights=column("weight"),
        residuals=np.stack([column(_RESIDUAL + name) for name in channels], axis=1),
        outliers=column("outlier") != 0.0,
    )


def _columns(result: Reconstruction) -> dict[str, Any]:
    samples = result.samples
    columns: dict[str, Any] = {
        "brdfit_row": np.arange(1, len(samples) + 1) if samples.rows is None else samples.rows
    }
    for side, w in (("i", samples.wi), ("o", samples.wo)):
        theta, phi = spherical_from_directions(w)
        # Ten digits: enough for any instrument, without the noise of the last bits.
        columns[f"theta_{side}_deg"] = np.round(np.degrees(theta), 10)
        columns[f"phi_{side}_deg"] = np.round(np.degrees(phi), 10)
    for channel, name in enumerate(samples.channels):
        columns[name] = samples.value[:, channel]
    columns["weight"] = result.weights
    columns["outlier"] = result.outliers.astype(np.int8)
    for channel, name in enumerate(samples.channels):
        columns[f"{_RESIDUAL}{name}"] = result.residuals[:, channel]
    if not _pooled(result):
        for channel, name in enumerate(samples.channels):
            columns[f"weight_{name}"] = result.channel_weights[:, channel]
    columns["flags"] = _flag_names(samples.bits)
    columns["brdfit_flags"] = samples.bits
    return columns


def _pooled(result: Reconstruction) -> bool:
    """Whether every sample has one verdict in all of its used channels."""
    weights = np.where(result.samples.usable, result.channel_weights, np.nan)
    first = result.weights[:, None]
    differ = np.abs(weights - first) > 1e-9
    return not bool(np.any(differ & np.isfinite(weights)))


def _flag_names(bits: Any) -> list[str]:
    known = {
        int(combination): "+".join(
            str(flag.name).lower() for flag in Flag if int(combination) & flag
        )
        for combination in np.unique(bits)
    }
    return [known[int(one)] for one in bits]
