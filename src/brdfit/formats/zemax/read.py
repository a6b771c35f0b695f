"""Read Zemax's tabular BSDF.

Header: Source, Symmetry, SpectralContent, ScatterType, then SampleRotation, AngleOfIncidence,
ScatterAzimuth and ScatterRadial, each with a count and its angles. Data: Monochrome, or
TristimulusX, Y and Z one after the other; DataBegin; for each rotation and each incidence TIS
and a row for each azimuth; DataEnd.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from brdfit.arrays import FloatArray, IntArray
from brdfit.errors import CorruptFile, FormatError, UsageError
from brdfit.formats.bsdf_text import Words
from brdfit.formats.text import TextFile, read_text
from brdfit.formats.xyz import linear_rgb_from_xyz
from brdfit.formats.zemax import CONVENTION
from brdfit.formats.zemax.geometry import directions_from_specular
from brdfit.samples import Flag, Samples

__all__ = ["read_samples"]

_ZEROS = ("missing", "measured")
_WORDS = {
    "Source": ("Measured", "Generated"),
    "Symmetry": ("PlaneSymmetrical", "Asymmetrical", "Asymmetrical4D"),
    "SpectralContent": ("Monochrome", "XYZ"),
    "ScatterType": ("BRDF", "BTDF"),
}
_ANGLES = {
    "SampleRotation": 360.0,
    "AngleOfIncidence": 90.0,
    "ScatterAzimuth": 360.0,
    "ScatterRadial": 180.0,
}
_BLOCKS = {
    "Monochrome": ("Monochrome",),
    "XYZ": ("TristimulusX", "TristimulusY", "TristimulusZ"),
}
_MOST_VALUES = 1 << 26


@dataclass(frozen=True)
class _Header:
    words: dict[str, str]
    angles: dict[str, FloatArray]

    @property
    def shape(self) -> tuple[int, int, int, int]:
        """Numbers of rotations, incidences, azimuths and radial angles."""
        sizes = [self.angles[name].size for name in _ANGLES]
        return (sizes[0], sizes[1], sizes[2], sizes[3])


def read_samples(path: Path, *, zeros: str) -> Samples:
    """Return every number of the file as a sample; `rows` count them from 1.

    `zeros`: the format has no mark for "not measured", and files have exact zeros where
    nothing was; "missing" rejects them, "measured" takes them for measurements under the
    noise floor. At radial angle 0 all azimuths are one direction: where they repeat the
    first one's value they are rejected as its copies. A file of several sample rotations
    is of an anisotropic material: they are read as repeated measurements, and a note says so.

    XYZ becomes linear sRGB. Raises `FormatError` for a BTDF.
    """
    if zeros not in _ZEROS:
        raise UsageError(f"zeros: found {zeros!r} but one of {', '.join(_ZEROS)} is needed.")
    text = read_text(path)
    words = Words(text)
    header = _header(words)
    values = _values(words, header)
    incidence, azimuth, radial = (
        np.deg2rad(header.angles[name])
        for name in ("AngleOfIncidence", "ScatterAzimuth", "ScatterRadial")
    )
    wi, wo = directions_from_specular(
        incidence[:, None, None], azimuth[None, :, None], radial[None, None, :]
    )
    n_rotations, channels = header.shape[0], values.shape[-1]
    flags, notes = _flags(header, values, zeros)
    if channels == 3:
        values = linear_rgb_from_xyz(values)
        notes.append("tristimulus values converted to linear sRGB, their white taken as D65")
    flat = values.reshape(-1, channels)
    return Samples(
        wi=np.tile(wi.reshape(-1, 3), (n_rotations, 1)),
        wo=np.tile(wo.reshape(-1, 3), (n_rotations, 1)),
        value=flat,
        flags=flags,
        rows=np.arange(1, len(flat) + 1),
        source=text.source("zemax", CONVENTION, notes, {**header.words, **_comments(text)}),
    )


def _flags(header: _Header, values: FloatArray, zeros: str) -> tuple[IntArray, list[str]]:
    """Return the flags (n,) and what is to be said of them."""
    notes: list[str] = []
    rejected = np.zeros(values.shape[:4], dtype=bool)
    if zeros == "missing":
        rejected |= (values == 0.0).all(axis=-1)
        if rejected.any():
            notes.append(
                f"{int(rejected.sum())} values are exactly 0, which stands for 'not measured' in "
                f"this format: rejected (zeros=measured keeps them)"
            )
    at_specular = header.angles["ScatterRadial"] == 0.0
    copies = np.zeros_like(rejected)
    same = (values == values[:, :, :1]).all(axis=-1)
    copies[:, :, 1:] = same[:, :, 1:] & at_specular
    if copies.any():
        notes.append(
            f"{int(copies.sum())} values at radial angle 0 repeat that of the first azimuth, which "
            f"is the same direction: rejected"
        )
    if header.shape[0] > 1:
        notes.append(
            f"{header.shape[0]} sample rotations of an anisotropic material: read as measurements "
            f"of one isotropic material"
        )
    return np.where((rejected | copies).reshape(-1), int(Flag.REJECTED), 0), notes


def _header(words: Words) -> _Header:
    found: dict[str, str] = {}
    angles: dict[str, FloatArray] = {}
    blocks = {name.lower() for names in _BLOCKS.values() for name in names} | {"databegin"}
    known = {name.lower(): name for name in (*_WORDS, *_ANGLES)}
    while words.peek().lower() not in blocks:
        where = words.where
        word = words.take("a keyword of the header, or DataBegin")
        name = known.get(word.lower())
        if name is None or name in found or name in angles:
            raise CorruptFile(
                f"{where}: found {word[:40]!r} in the header, but one of "
                f"{', '.join((*_WORDS, *_ANGLES))} was expected, each once."
            )
        if name in _WORDS:
            found[name] = words.one_of(name, _WORDS[name])
        else:
            angles[name] = words.angles(name, _ANGLES[name])
    angles.setdefault("SampleRotation", np.zeros(1))
    missing = [name for name in _ANGLES if name not in angles]
    if missing:
        raise CorruptFile(f"{words.where}: the data begin but {missing[0]} is missing above.")
    if found.get("ScatterType", "BRDF") != "BRDF":
        raise FormatError(
            f"{words.name}: holds a BTDF (transmission), but brdfit reads reflection only."
        )
    return _Header(found, angles)


def _values(words: Words, header: _Header) -> FloatArray:
    """Return the numbers (rotations, incidences, azimuths, radial angles, channels)."""
    names = _BLOCKS[header.words.get("SpectralContent", "Monochrome")]
    rotations, incidences, azimuths, radials = header.shape
    if rotations * incidences * azimuths * radials * len(names) > _MOST_VALUES:
        raise CorruptFile(
            f"{words.name}: the header announces {rotations} x {incidences} x {azimuths} x "
            f"{radials} values, more than can be right."
        )
    channels: list[FloatArray] = []
    for name in names:
        if words.peek().lower() == name.lower():
            words.take(name)
        elif len(names) > 1:
            words.expect(name)
        words.expect("DataBegin")
        blocks = []
        for _ in range(rotations * incidences):
            words.expect("TIS")
            words.number("the TIS")
            blocks.append(words.numbers(azimuths * radials, f"{azimuths} rows of {radials}"))
        if words.left:
            words.expect("DataEnd")
        channels.append(np.array(blocks).reshape(rotations, incidences, azimuths, radials))
    return np.stack(channels, axis=-1)


def _comments(text: TextFile) -> dict[str, str]:
    lines = [line.strip().lstrip("# \t") for _, line in text.lines if line.lstrip().startswith("#")]
    comments = "; ".join(line for line in lines if line and not set(line) <= set("=-"))
    return {"comments": comments[:4000]} if comments else {}
