"""How sure a method is of its result, on a coarse grid: small enough to travel in a record.

A method may state the standard deviation of ln f_r. Its table cannot hold that, so the
record of a fit does: at the nodes of a 30 x 30 x 12 grid (6 degrees at most in theta_h,
3 in theta_d, 15 in phi_d; phi_d = 0 is the plane of incidence), trilinear between them.
"""

from __future__ import annotations

import base64
import binascii
from dataclasses import dataclass
from typing import Any

import numpy as np

from brdfit.arrays import FloatArray
from brdfit.errors import CorruptFile
from brdfit.grid import Grid
from brdfit.progress import Progress, silent
from brdfit.reconstruct.doubt import stated_doubt
from brdfit.reconstruct.result import Reconstruction
from brdfit.table import Table

__all__ = ["NORMAL_95", "Uncertainty"]

NORMAL_95 = 1.96
"""Standard deviations of a normal distribution on either side of the middle 95 %."""

_QUANTITY = "standard deviation of ln f_r"
_ENCODING = "base64 of little-endian float16 in C order; NaN below the horizon"


@dataclass(frozen=True, eq=False)
class Uncertainty:
    """The standard deviation of ln f_r over the domain.

    `stddev` holds it as a table: (n_theta_h, n_theta_d, n_phi_d, channels), one channel for
    all where the method does not tell them apart.
    """

    stddev: Table
    deviations_95: float = NORMAL_95
    """How many of these, to either side, hold 95 % (`Reconstruction.deviations`)."""

    @classmethod
    def of(cls, result: Reconstruction, progress: Progress = silent) -> Uncertainty | None:
        """Return what the method of `result` states; None if it states nothing."""
        found = stated_doubt(result, progress)
        return None if found is None else cls(found, result.deviations(0.95))

    @classmethod
    def from_record(cls, record: dict[str, Any], where: str) -> Uncertainty:
        """Return what `record` wrote; raises `CorruptFile`, naming `where`, for anything else."""
        try:
            shape = tuple(int(size) for size in record["shape"])
            channels = tuple(str(name) for name in record["channels"])
            content = base64.b64decode(record["values"], validate=True)
            values = np.frombuffer(content, dtype="<f2").astype(np.float64).reshape(shape)
            table = Table(values=values, grid=Grid(*shape[:3]), channels=channels)
            return cls(table, float(record.get("deviations_95", NORMAL_95)))
        except (KeyError, TypeError, ValueError, binascii.Error) as error:
            raise CorruptFile(
                f"{where}: 'uncertainty' is damaged ({type(error).__name__}: {error}); expected "
                f"the shape, the channels and {_ENCODING}. Fit again, or remove that entry."
            ) from error

    def record(self) -> dict[str, Any]:
        """Return everything as JSON-able values."""
        values = np.where(self.stddev.mask[..., None], self.stddev.values, np.nan)
        return {
            "quantity": _QUANTITY,
            "deviations_95": self.deviations_95,
            "grid": "theta_h (square-root warped), theta_d, phi_d, channel",
            "shape": list(values.shape),
            "channels": list(self.stddev.channels),
            "encoding": _ENCODING,
            "values": base64.b64encode(values.astype("<f2").tobytes()).decode("ascii"),
        }

    def evaluate(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        """Return the standard deviation of ln f_r (n, channels) at direction pairs (n, 3)."""
        return self.stddev.evaluate(wi, wo)
