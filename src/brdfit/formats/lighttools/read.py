"""Read LightTools' tabular BSDF.

Header: Symmetry, SpectralContent, ScatterAzimuth and ScatterRadial with their angles;
DataBegin; then blocks of AOI, POI, Side, Wavelength, ScatterType, for XYZ TristimulusValue, and
TIS with the numbers, the radial angle running fastest; DataEnd. Blocks of the back side and of
transmission are not read, and counted.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from brdfit.arrays import FloatArray
from brdfit.errors import CorruptFile, FormatError, UsageError
from brdfit.formats.bsdf_text import Words
from brdfit.formats.lighttools import CONVENTION
from brdfit.formats.text import read_text
from brdfit.formats.xyz import linear_rgb_from_xyz
from brdfit.geometry import directions_from_spherical
from brdfit.samples import Samples

__all__ = ["read_samples"]

_TRISTIMULUS = ("TrisX", "TrisY", "TrisZ")
_MOST_VALUES = 1 << 26


@dataclass(frozen=True)
class _Block:
    aoi: float
    poi: float
    channel: float
    """Wavelength in nm, or 0, 1, 2 for X, Y, Z."""
    read: bool
    """Reflection at the front."""
    values: FloatArray
    """(azimuths x radial angles,)"""


@dataclass(frozen=True)
class _Header:
    tristimulus: bool
    azimuths: FloatArray
    radials: FloatArray


def read_samples(path: Path, *, light_azimuth: float) -> Samples:
    """Return every number of the front's BRDF as a sample; blocks at one AOI and POI are channels.

    `light_azimuth`: azimuth of the light at POI 0, degrees. Raises `FormatError` where the
    file holds no reflection at the front.
    """
    if not isinstance(light_azimuth, int | float) or not np.isfinite(light_azimuth):
        raise UsageError(f"light_azimuth: found {light_azimuth!r} but degrees are needed.")
    text = read_text(path)
    words = Words(text)
    header = _header(words)
    blocks = _blocks(words, header)
    used = [block for block in blocks if block.read]
    if not used:
        raise FormatError(
            f"{text.name}: none of its {len(blocks)} blocks is a BRDF of the front side."
        )
    notes = []
    if len(used) < len(blocks):
        notes.append(f"{len(blocks) - len(used)} blocks of transmission or the back are not read")
    lights, channels, values = _arranged(text.name, used, header)
    if header.tristimulus:
        values = linear_rgb_from_xyz(values)
        notes.append("tristimulus values converted to linear sRGB, their white taken as D65")
    wi, wo = _directions(lights, header, float(light_azimuth))
    spectral = not header.tristimulus and min(channels) > 0.0
    return Samples(
        wi=wi,
        wo=wo,
        value=values,
        wavelengths=np.array(channels) if spectral else None,
        rows=np.arange(1, len(values) + 1),
        source=text.source("lighttools", CONVENTION, notes),
    )


def _directions(
    lights: list[tuple[float, float]], header: _Header, light_azimuth: float
) -> tuple[FloatArray, FloatArray]:
    """Return (wi, wo), each (n, 3), in the order of the numbers."""
    aoi, poi = np.deg2rad(np.array(lights)).T
    azimuth, radial = np.meshgrid(
        np.deg2rad(header.azimuths), np.deg2rad(header.radials), indexing="ij"
    )
    wo = directions_from_spherical(radial, azimuth).reshape(-1, 3)
    wi = directions_from_spherical(aoi, poi + np.deg2rad(light_azimuth))
    return np.repeat(wi, len(wo), axis=0), np.tile(wo, (len(lights), 1))


def _arranged(
    name: str, blocks: list[_Block], header: _Header
) -> tuple[list[tuple[float, float]], list[float], FloatArray]:
    """Return (lights, channels, values (lights x directions, channels)); NaN where missing."""
    lights = list(dict.fromkeys((block.aoi, block.poi) for block in blocks))
    channels = sorted({block.channel for block in blocks})
    if header.tristimulus:
        channels = [0.0, 1.0, 2.0]
    size = header.azimuths.size * header.radials.size
    if len(lights) * len(channels) * size > _MOST_VALUES:
        raise CorruptFile(
            f"{name}: {len(lights)} directions of light and {len(channels)} wavelengths make more "
            f"values than can be right; the blocks do not belong together."
        )
    values = np.full((len(lights), size, len(channels)), np.nan)
    for block in blocks:
        place = lights.index((block.aoi, block.poi)), channels.index(block.channel)
        if not np.isnan(values[place[0], :, place[1]]).all():
            raise CorruptFile(
                f"{name}: two blocks have AOI {block.aoi:g}, POI {block.poi:g} and the same "
                f"channel. One of them is wrong."
            )
        values[place[0], :, place[1]] = block.values
    return lights, channels, values.reshape(-1, len(channels))


def _header(words: Words) -> _Header:
    tristimulus = False
    angles: dict[str, FloatArray] = {}
    while words.peek().lower() != "databegin":
        word = words.take("DataBegin").lower()
        if word == "spectralcontent":
            found = words.one_of("SpectralContent", ("Monochrome", "XYZ", "Spectral"))
            tristimulus = found == "XYZ"
        elif word == "scatterazimuth":
            angles["azimuth"] = words.angles("ScatterAzimuth", 360.0)
        elif word == "scatterradial":
            angles["radial"] = words.angles("ScatterRadial", 180.0)
        # other keywords and their words say nothing that is needed
    words.expect("DataBegin")
    missing = {"azimuth", "radial"} - set(angles)
    if missing:
        raise CorruptFile(
            f"{words.name}: the data begin, but ScatterAzimuth and ScatterRadial were expected "
            f"above them; missing: {', '.join(sorted(missing))}."
        )
    return _Header(tristimulus, angles["azimuth"], angles["radial"])


def _blocks(words: Words, header: _Header) -> list[_Block]:
    blocks: list[_Block] = []
    size = header.azimuths.size * header.radials.size
    while words.left and words.peek().lower() != "dataend":
        blocks.append(_block(words, header, size))
    if not blocks:
        raise CorruptFile(f"{words.name}: no block of data follows DataBegin.")
    return blocks


def _block(words: Words, header: _Header, size: int) -> _Block:
    aoi = poi = wavelength = 0.0
    side, kind, tristimulus = "Front", "BRDF", ""
    while True:
        where = words.where
        word = words.take("a keyword of a block").lower()
        if word == "aoi":
            aoi = words.number("the angle of incidence")
        elif word == "poi":
            poi = words.number("the azimuth of the plane of incidence")
        elif word == "wavelength":
            wavelength = words.number("the wavelength")
        elif word == "side":
            side = words.one_of("Side", ("Front", "Back"))
        elif word == "scattertype":
            kind = words.one_of("ScatterType", ("BRDF", "BTDF"))
        elif word == "tristimulusvalue":
            tristimulus = words.one_of("TristimulusValue", _TRISTIMULUS)
        elif word == "tis":
            words.number("the TIS")
            break
        else:
            raise CorruptFile(
                f"{where}: found {word[:40]!r} but one of AOI, POI, Side, Wavelength, ScatterType, "
                f"TristimulusValue, TIS was expected. The block before is too long, or damaged."
            )
    if header.tristimulus and not tristimulus:
        raise CorruptFile(f"{where}: a block of an XYZ file has no TristimulusValue.")
    values = words.numbers(size, f"{header.azimuths.size} rows of {header.radials.size}")
    channel = float(_TRISTIMULUS.index(tristimulus)) if header.tristimulus else wavelength
    read = side == "Front" and kind == "BRDF"
    if read and not (0.0 <= aoi <= 90.0 and abs(poi) <= 360.0 and 0.0 <= channel < 1e6):
        raise CorruptFile(
            f"{where}: a block has AOI {aoi:g}, POI {poi:g}, wavelength {channel:g}; degrees from "
            f"0 to 90 and to 360, and nm, were expected."
        )
    return _Block(aoi, poi, channel, read, values)
