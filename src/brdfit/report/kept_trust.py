"""The trust map of a fit, kept in its record, so that its files tell what the fit told.

A class needs three things (`reconstruct.trust`): the believed samples, which are in the `.csv`;
the deviation of the result, which is the record's `uncertainty`; and that of the prior, which is
kept here at the same nodes, compressed. Opened again, the same rule answers, for any direction.
"""

from __future__ import annotations

import base64
import binascii
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from brdfit.errors import CorruptFile
from brdfit.grid import Grid
from brdfit.reconstruct.doubt import NODES, Doubt, table_at_nodes
from brdfit.reconstruct.reach import Reach
from brdfit.reconstruct.result import Reconstruction
from brdfit.reconstruct.trust import Silent, Trust, TrustMap
from brdfit.report.samples_csv import Judged
from brdfit.report.uncertainty import Uncertainty

__all__ = ["KeptTrust"]

_SHARES = Grid(30, 30, 36)
_CLASSES = (Trust.MEASURED, Trust.INTERPOLATED, Trust.SUPPLIED)
_ENCODING = "base64 of zlib of little-endian float16, the nodes above the horizon in C order"


@dataclass(frozen=True, eq=False)
class KeptTrust:
    """The classes of a fit and their shares of the domain."""

    map: TrustMap
    shares: tuple[float, float, float]
    """Measured, interpolated, supplied: by how often random pairs of directions fall there."""

    @classmethod
    def of(cls, result: Reconstruction, stated: Uncertainty | None) -> KeptTrust:
        """Return that of a fit whose uncertainty is `stated`."""
        doubt = Doubt.of(result.model, None if stated is None else stated.stddev)
        found = TrustMap(result.trust_map.reach, doubt or Silent())
        return cls(found, _shares(found))

    @classmethod
    def from_record(
        cls, record: Mapping[str, Any], judged: Judged, stated: Uncertainty | None, where: str
    ) -> KeptTrust:
        """Return what `record` wrote of a fit of the samples `judged`.

        Raises `CorruptFile`, naming `where`, for anything else.
        """
        try:
            shares = tuple(float(record["shares"][trust.name.lower()]) for trust in _CLASSES)
            prior = record["prior"]
            doubt = None if prior is None else _doubt(prior, stated)
        except (KeyError, TypeError, ValueError, binascii.Error, zlib.error) as error:
            raise CorruptFile(
                f"{where}: 'trust' is damaged ({type(error).__name__}: {error}); expected the "
                f"shares of the classes and the deviation of the prior, {_ENCODING}, beside an "
                f"'uncertainty'. Fit again, or remove that entry."
            ) from error
        reach = Reach(judged.samples, ~judged.outliers)
        return cls(TrustMap(reach, doubt or Silent()), (shares[0], shares[1], shares[2]))

    def record(self) -> dict[str, Any]:
        """Return everything as JSON-able values."""
        names = (trust.name.lower() for trust in _CLASSES)
        model = self.map.model
        prior = None
        if isinstance(model, Doubt):
            values = model.prior.values.reshape(-1)[NODES.cells].astype("<f2")
            prior = {
                "quantity": "standard deviation of ln f_r before any sample, brightness known",
                "noise": model.noise,
                "shape": list(NODES.shape),
                "encoding": _ENCODING,
                "values": base64.b64encode(zlib.compress(values.tobytes(), 9)).decode("ascii"),
            }
        return {
            "definition": self.map.definition,
            "shares": dict(zip(names, self.shares, strict=True)),
            "prior": prior,
        }


def _doubt(prior: Mapping[str, Any], stated: Uncertainty | None) -> Doubt:
    if stated is None:
        raise ValueError("no uncertainty stands beside it")
    if tuple(prior["shape"]) != NODES.shape:
        raise ValueError(f"shape {prior['shape']}, but {list(NODES.shape)} was expected")
    expected = 2 * NODES.cells.size
    # never more than what belongs there, whatever the record claims
    content = zlib.decompressobj().decompress(
        base64.b64decode(prior["values"], validate=True), expected + 1
    )
    if len(content) != expected:
        raise ValueError(f"{len(content)} bytes or more, but {expected} were expected")
    values = np.frombuffer(content, dtype="<f2").astype(np.float64)
    noise = float(prior["noise"])
    if not (np.isfinite(values).all() and (values >= 0.0).all() and noise >= 0.0):
        raise ValueError("a deviation is negative or not finite")
    return Doubt(stated.stddev, table_at_nodes(values[:, None], ("all",)), noise)


def _shares(trust: TrustMap) -> tuple[float, float, float]:
    classes = trust.on_grid(_SHARES)
    measured, interpolated, supplied = (
        float(_SHARES.solid_angle[classes == one].sum()) for one in _CLASSES
    )
    return measured, interpolated, supplied
