"""Read UTIA's `.bin`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from brdfit.arrays import FloatArray
from brdfit.errors import CorruptFile, UsageError
from brdfit.files import sha256_of_bytes
from brdfit.formats.drawing import Draw
from brdfit.formats.utia.layout import CONVENTION, FILE_BYTES, PHIS, SHAPE, THETAS, directions
from brdfit.samples import Samples, Source

__all__ = ["Meaning", "read_samples"]

_ENCODINGS = ("linear", "srgb")


@dataclass(frozen=True)
class Meaning:
    """f_r of a stored number v: scale * decoded(v / white)."""

    encoding: str
    """"linear", or "srgb": the curve of sRGB (IEC 61966-2-1) is undone."""
    white: float
    scale: float

    def __post_init__(self) -> None:
        if self.encoding not in _ENCODINGS:
            raise UsageError(
                f"encoding: found {self.encoding!r} but one of {', '.join(_ENCODINGS)} is needed."
            )
        for name in ("white", "scale"):
            value = getattr(self, name)
            number = isinstance(value, int | float) and not isinstance(value, bool)
            if not number or not 0.0 < value < float("inf"):
                raise UsageError(f"{name}: found {value!r} but a number above zero is needed.")

    def decoded(self, stored: FloatArray) -> FloatArray:
        """Return f_r, shaped as `stored`; what is negative stays so."""
        relative = stored / self.white
        if self.encoding == "srgb":
            size = np.abs(relative)
            curve = np.where(size <= 0.04045, size / 12.92, ((size + 0.055) / 1.055) ** 2.4)
            relative = np.copysign(curve, relative)
        return np.asarray(self.scale * relative)

    def __str__(self) -> str:
        if self == Meaning("linear", 1.0, 1.0):
            return (
                "the database does not say the unit of its numbers: they are taken as f_r, linear "
                "sRGB (encoding=, white= and scale= say otherwise)"
            )
        return (
            f"f_r is {self.scale:g} times the number over {self.white:g}, {self.encoding}, as the "
            f"options say"
        )


def read_samples(path: Path, meaning: Meaning, count: int | None, seed: int) -> Samples:
    """Return all 82,944 pairs of directions, or `count` of them drawn by `seed`.

    `rows` are 1-based numbers of the pair in a plane. The material may be anisotropic: the
    azimuths are kept as they are, and a note says what an isotropic method makes of them, and
    how much the values of pairs that differ by a common turn vary. At theta = 0 all azimuths
    are one direction.

    Raises `CorruptFile` unless the file has the one size or the other.
    """
    content = path.read_bytes()
    kind = next((kind for kind, size in FILE_BYTES.items() if size == len(content)), None)
    if kind is None:
        doubles, singles = FILE_BYTES.values()
        raise CorruptFile(
            f"{path.name}: has {len(content):,} bytes but a UTIA file of 6 x 48 x 6 x 48 "
            f"directions and three planes has {doubles:,} (float64) or {singles:,} (float32). It "
            f"is truncated, of another resolution, or of another format; fetch it again."
        )
    stored = np.frombuffer(content, kind).reshape(SHAPE).astype(np.float64)
    values = meaning.decoded(np.moveaxis(stored, 0, -1))
    notes = [str(meaning), _anisotropy(values)]
    w = directions()
    n = len(w)
    draw = Draw(count, seed)
    pairs = draw.of(n * n, f"{path.name}: the file has {n * n:,} pairs of directions")
    notes += draw.notes(n * n, "pairs of directions")
    return Samples(
        wi=w[pairs // n],
        wo=w[pairs % n],
        value=values.reshape(-1, 3)[pairs],
        rows=pairs + 1,
        source=Source(
            name=path.name,
            format="utia",
            sha256=sha256_of_bytes(content),
            convention=CONVENTION,
            notes=tuple(notes),
        ),
    )


def _anisotropy(values: FloatArray) -> str:
    """Return a note on how much a common turn of both directions changes the values."""
    grey = values.mean(axis=-1).reshape(THETAS, PHIS, THETAS, PHIS)
    # phi_v counted from phi_i
    turned = np.stack([np.roll(grey[:, k], -k, axis=-1) for k in range(PHIS)], axis=1)
    usable = np.isfinite(turned).all(axis=1) & (turned > 0.0).all(axis=1)
    with np.errstate(all="ignore"):
        spread = np.log(turned).std(axis=1)[usable]
    vary = f"by {np.median(spread):.0%} (median)" if spread.size else "by an unknown amount"
    return (
        f"both directions turned together, the values vary {vary}: a method for isotropic "
        f"materials takes all turns for measurements of one and the same"
    )
