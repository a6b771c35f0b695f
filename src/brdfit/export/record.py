"""What is said of a fit in every file that carries it."""

from __future__ import annotations

from typing import Any

from brdfit.export.fitting import Analytic

__all__ = ["fit_record", "rounded"]

_DIGITS = 6


def fit_record(fit: Analytic) -> dict[str, Any]:
    """Return form, parameters and errors of a fit as JSON-able values."""
    return {
        "model": fit.model,
        "form": fit.form,
        "parameters": rounded(fit.material.parameters()),
        "perceptual_error": rounded(fit.perceptual_error),
        "tried": rounded(dict(fit.tried)),
    }


def rounded(value: Any) -> Any:
    """Return `value` with floats of six decimals: what is beyond, no fit can tell."""
    if isinstance(value, float):
        return round(value, _DIGITS)
    if isinstance(value, list):
        return [rounded(item) for item in value]
    if isinstance(value, dict):
        return {name: rounded(item) for name, item in value.items()}
    return value
