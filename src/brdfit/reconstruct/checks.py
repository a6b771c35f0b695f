"""Checks of the settings of methods: the message names the setting and what was found."""

from __future__ import annotations

import math
from numbers import Integral, Real

from brdfit.errors import UsageError

__all__ = ["check_above", "check_count"]


def check_above(name: str, value: object, low: float) -> None:
    """Raise `UsageError` unless `value` is a finite number above `low`."""
    number = isinstance(value, Real) and not isinstance(value, bool)
    if not (number and math.isfinite(value) and value > low):  # type: ignore[arg-type, operator]
        raise UsageError(f"{name}: found {value!r} but it must be a finite number > {low:g}.")


def check_count(name: str, value: object, least: int) -> None:
    """Raise `UsageError` unless `value` is a whole number of at least `least`."""
    whole = isinstance(value, Integral) and not isinstance(value, bool)
    if not (whole and value >= least):  # type: ignore[operator]
        raise UsageError(f"{name}: found {value!r} but it must be a whole number >= {least}.")
