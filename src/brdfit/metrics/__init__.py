"""How far a BRDF is from its reference, in BRDF space and on rendered images."""

from __future__ import annotations

from brdfit.metrics.ciede2000 import perceptual_error

__all__ = ["perceptual_error"]
