"""The samples of a fit as a CSV: what was measured, what became of each, in file order."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from brdfit.geometry import spherical_from_directions
from brdfit.reconstruct.result import Reconstruction
from brdfit.samples import Flag

__all__ = ["write_samples_csv"]


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
        columns[f"residual_{name}"] = result.residuals[:, channel]
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
