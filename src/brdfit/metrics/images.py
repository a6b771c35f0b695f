"""What every metric of rendered images starts from: a checked pair under one exposure."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from brdfit.arrays import BoolArray, FloatArray
from brdfit.errors import UsageError
from brdfit.tone import exposure_scale, srgb_encode, three_channels

__all__ = ["ImagePair"]


@dataclass(frozen=True, eq=False)
class ImagePair:
    """Two linear images (height, width, 3) of one scene, and where to look.

    Both are multiplied by 0.8 over the 95th percentile of the reference's pixel values
    inside the mask, all channels together.
    """

    reference: FloatArray
    test: FloatArray
    mask: BoolArray

    @classmethod
    def of(
        cls, reference: npt.ArrayLike, test: npt.ArrayLike, mask: npt.ArrayLike | None = None
    ) -> ImagePair:
        """Return the exposed pair of images (height, width, 1 or 3) in linear sRGB, any scale.

        Raises `UsageError` where shapes disagree, or where a pixel inside the mask is not
        finite: a mean over the rest would hide that it is missing.
        """
        a, b = (np.asarray(image, dtype=np.float64) for image in (reference, test))
        if a.ndim != 3 or a.shape[:2] != b.shape[:2] or b.ndim != 3:
            raise UsageError(
                f"images: found shapes {a.shape} and {b.shape} but both must be "
                f"(height, width, channels) of the same height and width."
            )
        look = np.ones(a.shape[:2], dtype=bool) if mask is None else np.asarray(mask, dtype=bool)
        if look.shape != a.shape[:2] or not look.any():
            raise UsageError(
                f"images: the mask has shape {look.shape} and {int(look.sum())} pixels but the "
                f"images are {a.shape[:2]} and at least one pixel must be looked at."
            )
        for name, image in (("reference", a), ("test", b)):
            bad = int(np.count_nonzero(~np.isfinite(image[look]).all(axis=-1)))
            if bad:
                raise UsageError(
                    f"images: {bad} of {int(look.sum())} pixels of the {name} are not finite. "
                    f"Look for missing values in the BRDF that was rendered."
                )
        scale = exposure_scale(a, look)
        return cls(three_channels(a) * scale, three_channels(b) * scale, look)

    @cached_property
    def displayed(self) -> tuple[FloatArray, FloatArray]:
        """Both images as a screen shows them: clipped to [0, 1], with the sRGB curve."""
        return srgb_encode(self.reference), srgb_encode(self.test)

    @cached_property
    def linear_pixels(self) -> tuple[FloatArray, FloatArray]:
        """Both images' pixels (n, 3) inside the mask: linear, exposed, not clipped."""
        return self.reference[self.mask], self.test[self.mask]
