"""Find data that contradict the convention they were read with."""

from __future__ import annotations

from brdfit.samples import Samples

__all__ = ["warn_about_conventions"]


def warn_about_conventions(samples: Samples) -> None:
    """Give a `ConventionWarning` for each contradiction."""
