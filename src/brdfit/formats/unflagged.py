"""Samples for a format that has no place for flags: what was rejected must not come back."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np

from brdfit.errors import DataQualityWarning, UsageError
from brdfit.samples import Flag, Samples

__all__ = ["without_stated_flags"]

_STATED = int(Flag.UNREADABLE | Flag.REJECTED)


def without_stated_flags(samples: Samples, path: Path) -> Samples:
    """Return the samples but those marked UNREADABLE or REJECTED, and count them in a warning.

    All other flags follow from directions and values, and are found again by whoever reads
    them. Raises `UsageError` where nothing is left.
    """
    marked = (samples.bits & _STATED) != 0
    if marked.all():
        raise UsageError(
            f"{path.name}: all {len(samples)} samples are marked as unreadable or rejected, so "
            f"there is nothing to write."
        )
    if not marked.any():
        return samples
    warnings.warn(
        f"{path.name}: {int(np.count_nonzero(marked))} of {len(samples)} samples are marked as "
        f"unreadable or rejected and were left out: the format has no mark for them. Write .csv, "
        f".parquet or .npz to keep them.",
        DataQualityWarning,
        stacklevel=4,
    )
    return samples.subset(~marked)
