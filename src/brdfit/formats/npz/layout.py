"""What is in brdfit's `.npz`: a zip archive of NumPy arrays that `numpy.load` also reads.

| member        | samples                  | table                                   |
|---------------|--------------------------|-----------------------------------------|
| `brdfit`      | header, JSON as uint8    | header, JSON as uint8                   |
| `wi`, `wo`    | (n, 3) float64           |                                         |
| `value`       | (n, channels) float64    |                                         |
| `sigma`       | (n, channels), optional  |                                         |
| `flags`       | (n,) int64, bits of Flag |                                         |
| `rows`        | (n,) int64, optional     |                                         |
| `values`      |                          | (theta_h, theta_d, phi_d, channels)     |
| `valid`       |                          | (theta_h, theta_d, phi_d) bool          |
| `wavelengths` | (channels,), optional    | (channels,), optional                   |

The header holds `version`, `kind` ("samples" or "table"), `channels` (names) and `source`
(where the data came from: the fields of `brdfit.samples.Source`).
"""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["HEADER", "KINDS", "VERSION", "Member"]

VERSION = 1
"""Raised when a reader of the former version could no longer read a file."""

HEADER = "brdfit"
"""The member that says what the archive is."""


@dataclass(frozen=True)
class Member:
    """What an array of the archive must be like."""

    dimensions: int
    kinds: str
    """Allowed NumPy kinds: f float, i integer, b bool."""
    optional: bool = False


KINDS: dict[str, dict[str, Member]] = {
    "samples": {
        "wi": Member(2, "f"),
        "wo": Member(2, "f"),
        "value": Member(2, "f"),
        "sigma": Member(2, "f", optional=True),
        "flags": Member(1, "i"),
        "rows": Member(1, "i", optional=True),
        "wavelengths": Member(1, "f", optional=True),
    },
    "table": {
        "values": Member(4, "f"),
        "valid": Member(3, "b"),
        "wavelengths": Member(1, "f", optional=True),
    },
}
"""The members of each kind, besides the header."""
