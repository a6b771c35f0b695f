"""Write samples as ASTM E1392 text, as Cornell's files are laid out."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from brdfit.arrays import FloatArray
from brdfit.errors import UsageError
from brdfit.files import atomic_path
from brdfit.formats.columns import guess_columns
from brdfit.formats.unflagged import without_stated_flags
from brdfit.geometry import spherical_from_directions
from brdfit.samples import Samples

__all__ = ["write_samples"]

_ANGLES = ("theta_i", "phi_i", "theta_s", "phi_s")
_FORMAT = "astm"


def write_samples(samples: Samples, path: Path) -> None:
    """Write angles in radians and every value with the digits that bring it back.

    Standard deviations are columns named sigma_ and the channel. The header of samples that
    came from such a file is kept; that of others says where they came from. Raises
    `UsageError` for channels whose names could not be read again.
    """
    samples = without_stated_flags(samples, path)
    names = [*_ANGLES, *_columns(samples, path)]
    sigma = [] if samples.sigma is None else [samples.sigma]
    rows = np.hstack([_angles(samples), samples.value, *sigma])
    lines = [*_header(samples), f"NUM_POINTS {len(samples)}", f"VARS {','.join(names)}", ""]
    lines += [",".join(map(repr, row)) for row in rows.tolist()]
    with atomic_path(path) as aside:
        aside.write_text("\n".join(lines) + "\n", encoding="utf-8", newline="\n")


def _columns(samples: Samples, path: Path) -> list[str]:
    waves = samples.wavelengths
    names = list(samples.channels) if waves is None else [f"{wave!r}nm" for wave in waves.tolist()]
    sigma = [] if samples.sigma is None else [f"sigma_{name}" for name in names]
    guess = guess_columns([*_ANGLES, *names, *sigma])
    fine = not isinstance(guess, str) and len(guess.values) == len(names)
    if not fine or any(mark in name for name in names for mark in ',\n\r"'):
        raise UsageError(
            f"{path.name}: the channels {', '.join(names[:6])} have names that ASTM E1392 could "
            f"not be read by; it wants wavelengths, R, G, B, or value. Write .csv or .npz."
        )
    return [*names, *sigma]


def _angles(samples: Samples) -> FloatArray:
    """Return (n, 4) radians."""
    (theta_i, phi_i), (theta_s, phi_s) = map(spherical_from_directions, (samples.wi, samples.wo))
    return np.stack([theta_i, phi_i, theta_s, phi_s], axis=1)


def _header(samples: Samples) -> list[str]:
    source = samples.source
    if source.format == _FORMAT:
        kept = {key: value for key, value in source.metadata.items() if key != "NUM_POINTS"}
        # a key that stood in several lines was joined; one line says as much
        return [f"{key} {_line(value)}".rstrip() for key, value in kept.items()]
    origin = f"{source.name} ({source.format})"
    digest = f", SHA-256 {source.sha256}" if source.sha256 else ""
    return [
        f"LAB_COMMENTS written by brdfit from {_line(origin)}{digest}",
        f"SAMPLE_NAME {_line(Path(source.name).stem)}",
        "MEAS_NAME BRDF",
    ]


def _line(text: str) -> str:
    return " ".join(text.split())
