"""Delta E ITP: colour difference of high-dynamic-range images.

References: Recommendation ITU-R BT.2124-0 (2019), "Objective metric for the assessment of the
potential visibility of colour differences in television"; Report ITU-R BT.2408 (reference
white of 203 cd/m^2). Among image metrics, the one that follows judgements of rendered BRDF
approximations best ("Perceived quality of BRDF models", Computer Graphics Forum 2025,
doi:10.1111/cgf.70162).
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from brdfit.arrays import FloatArray
from brdfit.metrics.images import ImagePair
from brdfit.tone import colour_library

__all__ = ["delta_e_itp"]

_PQ_PEAK = 10_000.0

# Linear BT.709/sRGB to linear BT.2020 primaries (Recommendation ITU-R BT.2087-0).
_BT2020_FROM_SRGB = np.array(
    [[0.6274, 0.3293, 0.0433], [0.0691, 0.9195, 0.0114], [0.0164, 0.0880, 0.8956]]
)


def delta_e_itp(
    reference: npt.ArrayLike,
    test: npt.ArrayLike,
    mask: npt.ArrayLike | None = None,
    *,
    white: float = 203.0,
) -> float:
    """Return the mean Delta E ITP of two linear images over the mask; 0 is identical.

    Highlights are not clipped at the screen's white, so an error in the specular peak
    counts here where the perceptual error no longer sees it.

    | name        | shape                   | unit and range                               |
    |-------------|-------------------------|----------------------------------------------|
    | `reference` | (height, width, 1 or 3) | linear sRGB, any scale                       |
    | `test`      | (height, width, 1 or 3) | the same scale as the reference              |
    | `mask`      | (height, width) or None | pixels that count; None = all                |
    | `white`     |                         | cd/m^2 of an exposed value of 1              |

    Notes: ITP needs absolute luminance. Both images are exposed as for the perceptual
    error (0.8 over the reference's 95th percentile), then 1 is shown at `white`, and
    limited to [0, 10,000] cd/m^2, the range of PQ. With I, T = C_T / 2 and P = C_P of
    ICtCp,

        Delta E ITP = 720 sqrt(dI^2 + dT^2 + dP^2),

    1 = just noticeable in the most critical state of adaptation.
    """
    pair = ImagePair.of(reference, test, mask)
    difference = colour_library().difference.delta_E_ITP(
        *(_ictcp(pixels, white) for pixels in pair.linear_pixels)
    )
    return float(np.mean(difference))


def _ictcp(linear: FloatArray, white: float) -> FloatArray:
    wide = np.clip((linear @ _BT2020_FROM_SRGB.T) * white, 0.0, _PQ_PEAK)
    ictcp = colour_library().RGB_to_ICtCp(wide, method="ITU-R BT.2100-2 PQ", L_p=_PQ_PEAK)
    return np.asarray(ictcp, dtype=np.float64)
