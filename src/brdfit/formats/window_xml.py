"""The XML of LBNL's WINDOW that Radiance reads: what Klems matrices and tensor trees share.

A document holds a layer with blocks of numbers, each for a wavelength (Visible, and for
colour CIE-X and CIE-Z) and a side. Radiance's front, +z, is WINDOW's back:
`Reflection Back` is what a ray sees that meets the front of a Radiance surface.

Reference: G. Ward, `bsdf.h` and the readers beside it in the source of Radiance.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree
from xml.sax.saxutils import escape

import numpy as np

from brdfit.arrays import FloatArray
from brdfit.errors import CorruptFile, FormatError
from brdfit.files import sha256_of_bytes
from brdfit.samples import Source

__all__ = ["Document", "numbers_of", "read_document", "structure_in", "written_document"]

SIDES = ("reflection back", "reflection front")
"""Sides that are read, the preferred first."""

_STRUCTURE = re.compile(rb"<IncidentDataStructure>\s*(\w+)\s*<", re.IGNORECASE)


@dataclass(frozen=True)
class Document:
    """The blocks of one side, by wavelength."""

    structure: str
    """IncidentDataStructure, lower case: columns, rows, tensortree3, tensortree4."""
    side: str
    blocks: Mapping[str, ElementTree.Element]
    """Wavelength as written ("Visible", ...) -> WavelengthDataBlock."""
    source: Source
    tree: ElementTree.Element
    """The whole document."""


def structure_in(head: bytes) -> str:
    """Return the IncidentDataStructure in the first bytes of a file, lower case, or ""."""
    match = _STRUCTURE.search(head)
    return match[1].decode("ascii", errors="replace").lower() if match else ""


def read_document(path: Path, format: str, convention: str) -> Document:
    """Read the reflecting side of a document.

    Raises `CorruptFile` where it is no XML, and `FormatError` where it holds no reflection.
    A document type declaration is refused: it can make a small file a huge one.
    """
    content = path.read_bytes()
    if b"<!DOCTYPE" in content or b"<!ENTITY" in content:
        raise FormatError(f"{path.name}: has a document type declaration, which is not read.")
    try:
        tree = ElementTree.fromstring(content)
    except (ElementTree.ParseError, ValueError, LookupError) as error:
        raise CorruptFile(
            f"{path.name}: is not well-formed XML ({error}). It looks truncated or damaged."
        ) from error
    for element in tree.iter():
        element.tag = element.tag.rpartition("}")[2]
    sides: dict[str, dict[str, ElementTree.Element]] = {}
    for data in tree.iter("WavelengthData"):
        wavelength = (data.findtext("Wavelength") or "").strip()
        for block in data.iter("WavelengthDataBlock"):
            side = (block.findtext("WavelengthDataDirection") or "").strip().lower()
            sides.setdefault(side, {}).setdefault(wavelength, block)
    side = next((side for side in SIDES if "Visible" in sides.get(side, {})), "")
    if not side:
        found = ", ".join(sorted(filter(None, sides))) or "none"
        raise FormatError(
            f"{path.name}: holds no visible reflection (sides found: {found}); brdfit reads "
            f"reflection only."
        )
    source = Source(
        name=path.name,
        format=format,
        sha256=sha256_of_bytes(content),
        convention=convention,
        notes=(f"side read: {side}",),
    )
    return Document(structure_in(content), side, sides[side], source, tree)


def numbers_of(text: str | None, name: str, expected: int) -> FloatArray:
    """Return the numbers of a ScatteringData, separated by blanks or commas."""
    words = (text or "").replace(",", " ").split()
    if len(words) != expected:
        raise CorruptFile(
            f"{name}: a ScatteringData has {len(words)} numbers but {expected} were expected. The "
            f"file looks truncated, or its angle basis is not the one that it names."
        )
    try:
        return np.array(words, dtype=np.float64)
    except ValueError as error:
        raise CorruptFile(
            f"{name}: a ScatteringData holds a word that is no number ({error})."
        ) from error


def written_document(
    name: str, structure: str, definition: str, basis: str, data: Mapping[str, str]
) -> str:
    """Return a document with one block for each wavelength of `data` -> its numbers.

    `definition` goes into DataDefinition, `basis` names the angle basis in each block.
    """
    blocks = "".join(
        "<WavelengthData>\n"
        "<LayerNumber>System</LayerNumber>\n"
        f'<Wavelength unit="Integral">{wavelength}</Wavelength>\n'
        "<SourceSpectrum>CIE Illuminant D65 1nm.ssp</SourceSpectrum>\n"
        "<DetectorSpectrum>ASTM E308 1931 Y.dsp</DetectorSpectrum>\n"
        "<WavelengthDataBlock>\n"
        "<WavelengthDataDirection>Reflection Back</WavelengthDataDirection>\n"
        f"{basis}"
        "<ScatteringDataType>BRDF</ScatteringDataType>\n"
        f"<ScatteringData>\n{numbers}\n</ScatteringData>\n"
        "</WavelengthDataBlock>\n"
        "</WavelengthData>\n"
        for wavelength, numbers in data.items()
    )
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        '<WindowElement xmlns="http://windows.lbl.gov">\n'
        "<WindowElementType>System</WindowElementType>\n"
        "<Optical>\n<Layer>\n"
        f"<Material>\n<Name>{escape(name)}</Name>\n<Manufacturer>brdfit</Manufacturer>\n"
        "</Material>\n"
        f"<DataDefinition>\n<IncidentDataStructure>{structure}</IncidentDataStructure>\n"
        f"{definition}</DataDefinition>\n"
        f"{blocks}"
        "</Layer>\n</Optical>\n</WindowElement>\n"
    )
