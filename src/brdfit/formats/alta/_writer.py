"""Write samples as ALTA text."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from brdfit.errors import UsageError
from brdfit.files import atomic_path
from brdfit.formats.unflagged import without_stated_flags
from brdfit.samples import Samples

__all__ = ["write_samples"]


def write_samples(samples: Samples, path: Path) -> None:
    """Write both vectors, the detector's first, and the values with all their digits.

    Raises `UsageError` for channels that ALTA has no name for: it knows one value, or R, G, B.
    """
    samples = without_stated_flags(samples, path)
    colour = tuple(name.lower() for name in samples.channels) in (
        ("r", "g", "b"),
        ("red", "green", "blue"),
    )
    if samples.n_channels != 1 and (not colour or samples.wavelengths is not None):
        raise UsageError(
            f"{path.name}: the samples have {samples.n_channels} channels but ALTA text holds one, "
            f"or R, G and B. Write .csv or .npz, or ASTM E1392 for wavelengths."
        )
    source = samples.source
    digest = f", SHA-256 {source.sha256}" if source.sha256 else ""
    lines = [
        f"# written by brdfit from {' '.join(source.name.split())} ({source.format}{digest})",
        f"#DIM 6 {samples.n_channels}",
        "#PARAM_IN CARTESIAN",
        f"#PARAM_OUT {'RGB_COLOR' if colour else 'INV_STERADIAN'}",
    ]
    rows = np.hstack([samples.wo, samples.wi, samples.value])
    lines += ["\t".join(map(repr, row)) for row in rows.tolist()]
    with atomic_path(path) as aside:
        aside.write_text("\n".join(lines) + "\n", encoding="utf-8", newline="\n")
