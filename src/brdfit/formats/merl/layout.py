"""What a MERL `.binary` file is, byte by byte.

    3 x int32      90, 90, 180: theta_h, theta_d, phi_d
    then three planes R, G, B, each of 90 x 90 x 180 float64, little-endian, at
    index phi_d + 180 (theta_d + 90 theta_h)

f_r in 1/sr is the stored number times 1/1500 (R), 1.15/1500 (G), 1.66/1500 (B). A negative
number means that the cell was not measured.

Reference: W. Matusik, H. Pfister, M. Brand, L. McMillan, "A Data-Driven Reflectance Model",
ACM Trans. Graph. 22(3), 2003, and the reader that comes with the database.
"""

from __future__ import annotations

from brdfit.grid import MERL_GRID

__all__ = ["CONVENTION", "FILE_BYTES", "HEADER", "HEADER_BYTES", "NOT_MEASURED", "SCALES"]

HEADER = MERL_GRID.shape
"""The three integers at the start."""

HEADER_BYTES = 12
"""Three int32."""

SCALES = (1.0 / 1500.0, 1.15 / 1500.0, 1.66 / 1500.0)
"""Stored number to f_r in 1/sr, for R, G, B."""

FILE_BYTES = HEADER_BYTES + 3 * MERL_GRID.size * 8
"""34,992,012."""

NOT_MEASURED = -1.0
"""What is stored in every channel of a cell without a value."""

CONVENTION = (
    "half/difference angles, theta_h square-root warped, phi_d in [0, pi) by reciprocity; "
    "stored numbers scaled to f_r in 1/sr, cosine not included; negative = not measured"
)
