"""The list of metrics: what each is called, what it compares, and which way is better."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

import numpy.typing as npt

from brdfit.errors import UsageError
from brdfit.metrics.andersson2020 import flip
from brdfit.metrics.bt2124 import delta_e_itp
from brdfit.metrics.ciede2000 import perceptual_error
from brdfit.metrics.entries import Score
from brdfit.metrics.fores2012 import cube_root_rms
from brdfit.metrics.log_difference import log_rms, mean_abs_log
from brdfit.metrics.ngan2005 import cosine_rms
from brdfit.metrics.signal_to_noise import psnr
from brdfit.metrics.sun2018 import cube_root_cosine
from brdfit.metrics.wang2004 import ssim

__all__ = ["METRICS", "Metric", "evaluate_metric"]


@dataclass(frozen=True)
class Metric:
    """A metric; calling it calls its function."""

    name: str
    title: str
    """One line for a person."""
    compares: Literal["images", "values"]
    """images: (reference, test, mask) linear images -> float. values: (reference, test,
    cos_theta_i, cos_theta_o, weights) in BRDF space -> `Score`."""
    function: Callable[..., float | Score]
    unit: str = ""
    identical: float = 0.0
    """What a reference compared with itself gives."""
    higher_is_better: bool = False
    extra: str = ""
    """The optional extra that it needs; empty = none."""

    def __call__(self, *args: Any, **kwargs: Any) -> float | Score:
        """Return what `function` returns."""
        return self.function(*args, **kwargs)


_ALL = (
    Metric(
        "perceptual_error",
        "mean CIEDE2000 of displayed images",
        "images",
        perceptual_error,
        unit="Delta E00",
    ),
    Metric(
        "delta_e_itp",
        "mean Delta E ITP of high-dynamic-range images",
        "images",
        delta_e_itp,
        unit="Delta E ITP",
    ),
    Metric(
        "psnr",
        "peak signal-to-noise ratio of displayed images",
        "images",
        psnr,
        unit="dB",
        identical=float("inf"),
        higher_is_better=True,
    ),
    Metric(
        "ssim",
        "structural similarity of displayed images",
        "images",
        ssim,
        identical=1.0,
        higher_is_better=True,
        extra="metrics",
    ),
    Metric(
        "flip",
        "mean FLIP of displayed images",
        "images",
        flip,
        extra="metrics",
    ),
    Metric("log_rms", "root mean square of delta ln f", "values", log_rms),
    Metric("mean_abs_log", "mean |delta ln f|", "values", mean_abs_log),
    Metric(
        "cube_root_cosine",
        "cube-root difference, both cosines (Sun 2018)",
        "values",
        cube_root_cosine,
    ),
    Metric(
        "cube_root_rms",
        "cube-root cosine-weighted RMS (Fores 2012)",
        "values",
        cube_root_rms,
    ),
    Metric(
        "cosine_rms",
        "cosine-weighted RMS (Ngan 2005)",
        "values",
        cosine_rms,
        unit="1/sr",
    ),
)

METRICS: dict[str, Metric] = {metric.name: metric for metric in _ALL}
"""Every metric by name."""


def evaluate_metric(
    name: str, reference: npt.ArrayLike, test: npt.ArrayLike, *args: Any, **kwargs: Any
) -> float | Score:
    """Return the metric `name` of `test` against `reference`.

    Further arguments are the metric's own: see its docstring. Raises `UsageError` for a
    name that is not in `METRICS`.
    """
    if name not in METRICS:
        raise UsageError(f"metric: found {name!r} but there are {', '.join(METRICS)}.")
    return METRICS[name](reference, test, *args, **kwargs)
