"""How far a BRDF is from its reference, on rendered images and in BRDF space.

Image metrics take (reference, test, mask): linear images, see `brdfit.render`, and where to
look. Metrics of values take (reference, test, cos_theta_i, cos_theta_o, weights) and say how
many entries they skipped. `METRICS` lists all; lower is better unless a metric says otherwise.
Image metrics are the better judges of what people see.
"""

from __future__ import annotations

from brdfit.metrics.andersson2020 import flip
from brdfit.metrics.bt2124 import delta_e_itp
from brdfit.metrics.ciede2000 import difference_map, perceptual_error
from brdfit.metrics.entries import Score
from brdfit.metrics.fores2012 import cube_root_rms
from brdfit.metrics.log_difference import log_rms, mean_abs_log
from brdfit.metrics.ngan2005 import cosine_rms
from brdfit.metrics.registry import METRICS, Metric, evaluate_metric
from brdfit.metrics.signal_to_noise import psnr
from brdfit.metrics.sun2018 import cube_root_cosine
from brdfit.metrics.wang2004 import ssim

__all__ = [
    "METRICS",
    "Metric",
    "Score",
    "cosine_rms",
    "cube_root_cosine",
    "cube_root_rms",
    "delta_e_itp",
    "difference_map",
    "evaluate_metric",
    "flip",
    "log_rms",
    "mean_abs_log",
    "perceptual_error",
    "psnr",
    "ssim",
]
