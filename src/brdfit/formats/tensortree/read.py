"""Read Radiance's tensor trees, isotropic (TensorTree3) and anisotropic (TensorTree4).

A node is { values } with 1, 2^d, 4^d, ... numbers, the last coordinate running fastest, or {
2^d nodes }, bit i of whose index says on which side of the middle of coordinate i they lie.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from brdfit.arrays import FloatArray
from brdfit.errors import CorruptFile
from brdfit.formats.tensortree import CONVENTION
from brdfit.formats.tensortree.square import directions_of
from brdfit.formats.window_xml import Document, read_document
from brdfit.samples import Samples

__all__ = ["read_samples"]

_TOKEN = re.compile(r"[{}]|[^\s,{}]+")
_DEEPEST = 12
_MOST_LEAVES = 1 << 25


def read_samples(path: Path) -> Samples:
    """Return the leaves as samples at their middles.

    Leaves of the half of a TensorTree3 that no incidence reaches are left out: the format
    fills it with zeros. A TensorTree4 is of an anisotropic material; its leaves are read as
    measurements of one isotropic material, and a note says so.
    """
    document = read_document(path, "tensortree", CONVENTION)
    dimensions = 4 if document.structure == "tensortree4" else 3
    middle, visible = _leaves(document, "Visible", dimensions)
    notes = list(document.source.notes)
    value = visible[:, None]
    if {"CIE-u", "CIE-v"} & set(document.blocks):
        notes.append("its trees of chromaticity are not read: luminance only")
    if dimensions == 3:
        reached = middle[:, 0] < 0.5
        middle, value = middle[reached], value[reached]
        sin_i = 1.0 - 2.0 * middle[:, 0]
        wi = np.stack([-sin_i, 0.0 * sin_i, np.sqrt(np.maximum(1.0 - sin_i**2, 0.0))], axis=-1)
    else:
        notes.append("anisotropic: read as measurements of one isotropic material")
        wi = directions_of(middle[:, 0], middle[:, 1]) * np.array([-1.0, -1.0, 1.0])
    return Samples(
        wi=wi,
        wo=directions_of(middle[:, -2], middle[:, -1]),
        value=value,
        rows=np.arange(1, len(value) + 1),
        source=replace(document.source, notes=tuple(notes)),
    )


def _leaves(document: Document, wavelength: str, dimensions: int) -> tuple[FloatArray, FloatArray]:
    """Return the middles (n, dimensions) in the unit cube and values (n,) of all leaves."""
    text = document.blocks[wavelength].findtext("ScatteringData") or ""
    name = document.source.name
    parts, total = [], 0
    for corner, size, words in _nodes(text, name, dimensions):
        values = _floats(words, name)
        total += len(values)
        if total > _MOST_LEAVES:
            raise CorruptFile(f"{name}: the tree has more than {_MOST_LEAVES:,} leaves.")
        cells = round(len(values) ** (1.0 / dimensions))
        if cells**dimensions != len(values) or cells & (cells - 1):
            raise CorruptFile(
                f"{name}: a node of the tree has {len(values)} values but 1, {2**dimensions}, "
                f"{4**dimensions}, ... were expected."
            )
        axis = (np.arange(cells) + 0.5) / cells
        grid = np.stack(np.meshgrid(*[axis] * dimensions, indexing="ij"), axis=-1)
        parts.append((corner[:dimensions] + size * grid.reshape(-1, dimensions), values))
    return np.concatenate([p[0] for p in parts]), np.concatenate([p[1] for p in parts])


def _nodes(text: str, name: str, dimensions: int) -> Iterator[tuple[FloatArray, float, list[str]]]:
    """Yield (corner, size, words) of each node that holds values."""
    tokens = _TOKEN.findall(text)
    branches = 1 << dimensions
    # for each open node: its corner, and how many nodes within it were closed
    corners: list[FloatArray] = []
    children: list[int] = []
    words: list[str] = []
    closed = False
    for token in tokens:
        if closed:
            raise CorruptFile(f"{name}: the tree ends, but {token[:40]!r} follows it.")
        if token == "{":
            if len(corners) > _DEEPEST or words:
                raise CorruptFile(
                    f"{name}: the tree is nested too deep, or mixes nodes and values."
                )
            corners.append(_corner(corners, children))
            children.append(0)
        elif token == "}":
            if not corners:
                raise CorruptFile(f"{name}: the tree closes a node that it did not open.")
            corner, count = corners.pop(), children.pop()
            if bool(words) == bool(count) or (count and count != branches):
                raise CorruptFile(
                    f"{name}: a node of the tree has {count} nodes and {len(words)} values but "
                    f"{branches} nodes, or values, were expected."
                )
            if words:
                yield corner, 0.5 ** len(corners), words
                words = []
            if children:
                children[-1] += 1
            closed = not corners
        else:
            if not corners or children[-1]:
                raise CorruptFile(f"{name}: found {token[:40]!r} outside a node of the tree.")
            words.append(token)
    if not closed:
        raise CorruptFile(f"{name}: the tree is not closed. The file looks truncated.")


def _corner(corners: list[FloatArray], children: list[int]) -> FloatArray:
    """Return the corner of the next node to open."""
    if not corners:
        return np.zeros(4)
    half = 0.5 ** len(corners)
    bits = (children[-1] >> np.arange(4)) & 1
    return np.asarray(corners[-1] + half * bits)


def _floats(words: list[str], name: str) -> FloatArray:
    try:
        return np.array(words, dtype=np.float64)
    except ValueError as error:
        raise CorruptFile(f"{name}: the tree holds a word that is no number ({error}).") from error
