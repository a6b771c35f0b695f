"""Encodings of BRDF values: the domain in which a combination lives and is judged."""

from __future__ import annotations

from brdfit.transform.error_metric import ERROR_METRICS, ErrorMetric, error_metric

__all__ = ["ERROR_METRICS", "ErrorMetric", "error_metric"]
