"""From any number of channels to linear sRGB.

A BRDF known at bands is taken as piecewise linear between them and constant beyond the
outermost; under the illuminant D65 its tristimulus values follow from the CIE 1931 2-degree
colour matching functions:

    X = K sum_lambda f(lambda) S_D65(lambda) xbar(lambda),   Y and Z likewise,

then linear sRGB by the matrix of IEC 61966-2-1. Each of R, G, B is scaled (by less than
0.1 %) so that a perfect white, f = 1/pi in all bands, gives R = G = B = 1/pi exactly.

Saturated colours lie outside sRGB and come out slightly negative. That is kept: clipping
is for whoever displays or writes RGB, who also counts what was clipped.

Reference: CIE 015:2018, Colorimetry; the data and matrices are colour-science's.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from brdfit.albedo import Evaluable
from brdfit.arrays import FloatArray
from brdfit.errors import UsageError
from brdfit.tone import colour_library, three_channels

__all__ = ["ForDisplay", "display_matrix", "rgb_matrix", "shows_colour", "to_rgb"]

VISIBLE = (380.0, 780.0)
"""nm. Bands outside contribute nothing to a colour."""

_MIN_BANDS = 3
# Between these ends lie 98 % of Y and most of X and Z under D65: bands that do not come
# near both, or leave a gap this wide, say little about a colour.
_BLUE_END, _RED_END, _WIDEST_GAP = 500.0, 580.0, 160.0
_EYE_PEAK = 555.0


def shows_colour(wavelengths: npt.ArrayLike) -> bool:
    """Return whether bands at these wavelengths (nm) determine a colour.

    At least three in the visible, one at or below 500 nm, one at or above 580 nm, and no
    gap above 160 nm between neighbours. Otherwise data are shown in grey.
    """
    seen = np.sort(_visible(np.asarray(wavelengths, dtype=np.float64)))
    return bool(
        seen.size >= _MIN_BANDS
        and seen[0] <= _BLUE_END
        and seen[-1] >= _RED_END
        and np.diff(seen).max() <= _WIDEST_GAP
    )


def rgb_matrix(wavelengths: npt.ArrayLike) -> FloatArray:
    """Return (bands, 3): f_r at `wavelengths` (bands,) in nm times this is linear sRGB.

    Columns sum to 1, so that white stays white. Bands outside 380..780 nm have weight 0.
    Where the bands do not determine a colour (`shows_colour`) the three columns are
    equal: the mean of the visible bands, or the one band nearest 555 nm if none is visible.
    """
    bands = np.atleast_1d(np.asarray(wavelengths, dtype=np.float64))
    if bands.ndim != 1 or not np.isfinite(bands).all():
        raise UsageError(f"wavelengths: found {wavelengths!r} but expected finite values in nm.")
    if not shows_colour(bands):
        return np.repeat(_grey_weights(bands)[:, None], 3, axis=1)
    colour = colour_library()
    observer = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"]
    nm = np.asarray(observer.wavelengths, dtype=np.float64)
    daylight = colour.SDS_ILLUMINANTS["D65"]
    power = np.interp(nm, daylight.wavelengths, daylight.values)
    xyz = _hats(bands, nm) @ (power[:, None] * np.asarray(observer.values))
    rgb = xyz @ np.asarray(colour.RGB_COLOURSPACES["sRGB"].matrix_XYZ_to_RGB).T
    return np.asarray(rgb / rgb.sum(axis=0))


def display_matrix(
    n_channels: int, wavelengths: npt.ArrayLike | None = None, channels: Sequence[str] = ()
) -> FloatArray:
    """Return (n_channels, 3 or 1): values times this is linear sRGB, or one grey channel.

    With wavelengths, `rgb_matrix`. Without: three channels are R, G, B, in the order their
    names say if those are R, G and B; any other number becomes grey, the mean of all.
    """
    if wavelengths is not None:
        if len(np.atleast_1d(np.asarray(wavelengths))) != n_channels:
            raise UsageError(
                f"wavelengths: found {np.size(wavelengths)} but the values have {n_channels} "
                f"channels."
            )
        matrix = rgb_matrix(wavelengths)
        return matrix if shows_colour(wavelengths) else matrix[:, :1]
    if n_channels == 3:
        names = [name.strip().upper() for name in channels]
        known = sorted(names) == ["B", "G", "R"]
        return np.eye(3)[["RGB".index(name) for name in names]] if known else np.eye(3)
    return np.full((n_channels, 1), 1.0 / n_channels)


def to_rgb(
    values: npt.ArrayLike,
    wavelengths: npt.ArrayLike | None = None,
    channels: Sequence[str] = (),
) -> FloatArray:
    """Return linear sRGB (..., 3) of `values` (..., channels), grey where no colour is known.

    Values outside sRGB are returned negative, not clipped; NaN in a band that counts
    gives NaN.
    """
    array = np.asarray(values, dtype=np.float64)
    return three_channels(_weighted(array, display_matrix(array.shape[-1], wavelengths, channels)))


@dataclass(frozen=True, eq=False)
class ForDisplay:
    """A BRDF of any channels seen as three of linear sRGB, or as one of grey."""

    brdf: Evaluable
    matrix: FloatArray
    """(channels, 3 or 1), of `display_matrix`."""

    @classmethod
    def of(
        cls,
        brdf: Evaluable,
        wavelengths: npt.ArrayLike | None = None,
        channels: Sequence[str] = (),
    ) -> ForDisplay:
        """Return `brdf` as it is shown; its number of channels is found by asking it once."""
        straight = np.array([[0.0, 0.0, 1.0]])
        n_channels = brdf.evaluate(straight, straight).shape[1]
        return cls(brdf, display_matrix(n_channels, wavelengths, channels))

    def evaluate(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        """Return f_r (n, 3) or (n, 1), 1/sr, at direction pairs (n, 3)."""
        return _weighted(self.brdf.evaluate(wi, wo), self.matrix)


def _weighted(value: FloatArray, matrix: FloatArray) -> FloatArray:
    # A band without weight may be missing: 0 x NaN must not spread.
    counts = np.any(matrix != 0.0, axis=1)
    return np.asarray(value[..., counts] @ matrix[counts])


def _visible(wavelengths: FloatArray) -> FloatArray:
    inside = (wavelengths >= VISIBLE[0]) & (wavelengths <= VISIBLE[1])
    return np.asarray(wavelengths[inside])


def _grey_weights(bands: FloatArray) -> FloatArray:
    seen = (bands >= VISIBLE[0]) & (bands <= VISIBLE[1])
    if not seen.any():
        seen = np.arange(bands.size) == np.argmin(np.abs(bands - _EYE_PEAK))
    return np.asarray(seen / seen.sum())


def _hats(bands: FloatArray, nm: FloatArray) -> FloatArray:
    # (bands, nm): the spectrum of one band at 1 and all others at 0, interpolated
    hats = np.zeros((bands.size, nm.size))
    seen = np.flatnonzero((bands >= VISIBLE[0]) & (bands <= VISIBLE[1]))
    order = seen[np.argsort(bands[seen])]
    for position, band in enumerate(order):
        hats[band] = np.interp(nm, bands[order], np.eye(order.size)[position])
    return hats
