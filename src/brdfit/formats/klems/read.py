"""Read Klems matrices as samples at the middles of their patches."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from xml.etree.ElementTree import Element

import numpy as np

from brdfit.arrays import FloatArray
from brdfit.errors import FormatError
from brdfit.formats.klems import CONVENTION
from brdfit.formats.klems.patches import BASES, Basis
from brdfit.formats.window_xml import numbers_of, read_document
from brdfit.formats.xyz import linear_rgb_from_xyz
from brdfit.samples import Samples

__all__ = ["read_samples"]


def read_samples(path: Path) -> Samples:
    """Return every pair of patches as a sample, the light running fastest.

    Each value is the mean over two patches of 10 degrees and more: a note says so. A matrix
    is of an anisotropic material if its values say so; they are read as measurements of one
    isotropic material. With CIE-X and CIE-Z beside Visible it becomes linear sRGB.
    """
    document = read_document(path, "klems", CONVENTION)
    visible = document.blocks["Visible"]
    incident = _basis(visible, "ColumnAngleBasis", path.name)
    outgoing = _basis(visible, "RowAngleBasis", path.name)
    notes = [*document.source.notes, "each value is a mean over two patches of directions"]
    planes = [_matrix(visible, document.structure, incident, outgoing, path.name)]
    if {"CIE-X", "CIE-Z"} <= set(document.blocks):
        x, z = (
            _matrix(document.blocks[name], document.structure, incident, outgoing, path.name)
            for name in ("CIE-X", "CIE-Z")
        )
        planes = [x, *planes, z]
        notes.append("tristimulus values converted to linear sRGB, their white taken as D65")
    value = np.stack(planes, axis=-1).reshape(-1, len(planes))
    wi = incident.middles() * np.array([-1.0, -1.0, 1.0])
    return Samples(
        wi=np.tile(wi, (outgoing.size, 1)),
        wo=np.repeat(outgoing.middles(), incident.size, axis=0),
        value=linear_rgb_from_xyz(value) if len(planes) == 3 else value,
        rows=np.arange(1, len(value) + 1),
        source=replace(document.source, notes=tuple(notes)),
    )


def _matrix(
    block: Element, structure: str, incident: Basis, outgoing: Basis, name: str
) -> FloatArray:
    """Return the matrix (outgoing, incident)."""
    text = block.findtext("ScatteringData")
    numbers = numbers_of(text, name, incident.size * outgoing.size)
    if structure == "rows":
        return numbers.reshape(incident.size, outgoing.size).T
    return numbers.reshape(outgoing.size, incident.size)


def _basis(block: Element, which: str, name: str) -> Basis:
    found = (block.findtext(which) or "").strip()
    if found.lower() not in BASES:
        known = ", ".join(basis.name for basis in BASES.values())
        raise FormatError(f"{name}: {which} is {found[:60]!r} but one of {known} is read.")
    return BASES[found.lower()]
