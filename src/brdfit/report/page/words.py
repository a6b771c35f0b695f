"""Numbers as a person reads them."""

from __future__ import annotations

import math

__all__ = ["count", "factor", "number", "percent", "size_of_file", "weight"]

_SUPERSCRIPT = str.maketrans("-0123456789", "\u207b⁰¹²³⁴⁵⁶⁷⁸⁹")


def number(value: float | None, digits: int = 3) -> str:
    """Return `digits` significant digits, without an exponent from 0.0001 to 100,000."""
    if value is None or math.isnan(value):
        return "not known"
    if math.isinf(value):
        return "infinite" if value > 0 else "-infinite"
    if value == 0.0:
        return "0"
    rounded = float(f"{value:.{digits - 1}e}")
    size = math.floor(math.log10(abs(rounded)))
    if size < -4 or size >= 5:
        mantissa = f"{rounded / 10.0**size:.{digits - 1}f}".rstrip("0").rstrip(".")
        return f"{mantissa} × 10{str(size).translate(_SUPERSCRIPT)}"
    return f"{rounded:.{max(digits - 1 - size, 0)}f}"


def count(value: float) -> str:
    """Return a whole number with separated thousands."""
    return f"{int(value):,}"


def percent(share: float | None, digits: int = 2) -> str:
    """Return a share in [0, 1] as per cent, with `digits` significant digits."""
    if share is None or math.isnan(share):
        return "not known"
    if share == 0.0:
        return "0 %"
    decimals = max(digits - 1 - math.floor(math.log10(abs(share) * 100.0)), 0)
    return f"{share * 100.0:.{min(decimals, 3)}f} %"


def factor(log_ratio: float | None) -> str:
    """Return exp(`log_ratio`) as "2.3 times too high", for ln(value / expected)."""
    if log_ratio is None or not math.isfinite(log_ratio):
        return "not comparable"
    ratio = math.exp(min(abs(log_ratio), 700.0))
    side = "high" if log_ratio > 0.0 else "low"
    if ratio < 1.095:
        return f"{percent(ratio - 1.0)} too {side}"
    return f"{number(ratio, 2)} times too {side}"


def size_of_file(size: int | None) -> str:
    """Return bytes in a unit that fits; nothing for None."""
    if size is None:
        return ""
    for unit, scale in (("MB", 1_000_000), ("kB", 1_000)):
        if size >= scale:
            return f"{size / scale:.3g} {unit}"
    return f"{size} bytes"


def weight(value: float) -> str:
    """Return a weight in [0, 1] with three decimals; what is less is as good as nothing."""
    return "under 0.001" if 0.0 < value < 0.0005 else f"{value:.3f}"
