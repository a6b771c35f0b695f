"""Write a table as an isotropic tensor tree: one grid of 64^3 leaves.

The first coordinate is 0.5 - 0.5 sin theta_i: only the lower half of its range occurs. Of colour
the luminance is written: what Radiance expects in trees of chromaticity is not documented, and
what we tried it showed in other colours.
"""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np

from brdfit.arrays import FloatArray
from brdfit.errors import DataQualityWarning
from brdfit.files import atomic_path
from brdfit.formats.tensortree.square import directions_of
from brdfit.formats.window_xml import written_document
from brdfit.formats.xyz import not_negative, refuse_other_channels
from brdfit.table import Table
from brdfit.tone import LUMINANCE

__all__ = ["write_table"]

_CELLS = 64
_BASIS = "<AngleBasis>LBNL/Shirley-Chiu</AngleBasis>\n"


def write_table(table: Table, path: Path) -> None:
    """Write the values of `Table.evaluate` at the middles of the leaves."""
    refuse_other_channels(table, path, "a tensor tree")
    values = not_negative(_sampled(table), path)
    if table.n_channels == 3:
        values = (values @ np.array(LUMINANCE))[..., None]
        warnings.warn(
            f"{path.name}: the colour is lost: a tensor tree is written with luminance only. "
            f"Write a Klems matrix (format='klems') or .npz to keep it.",
            DataQualityWarning,
            stacklevel=3,
        )
    text = written_document(
        path.stem, "TensorTree3", "", _BASIS, {"Visible": _tree(values[..., 0])}
    )
    with atomic_path(path) as aside:
        aside.write_text(text, encoding="utf-8", newline="\n")


def _sampled(table: Table) -> FloatArray:
    """Return values (incidences, x, y, channels) of the half that occurs."""
    middles = (np.arange(_CELLS) + 0.5) / _CELLS
    sin_i = 1.0 - 2.0 * middles[: _CELLS // 2]
    wi = np.stack([-sin_i, np.zeros_like(sin_i), np.sqrt(1.0 - sin_i**2)], axis=-1)
    wo = directions_of(*np.meshgrid(middles, middles, indexing="ij")).reshape(-1, 3)
    values = [table.evaluate(np.broadcast_to(w, wo.shape), wo) for w in wi]
    return np.stack(values).reshape(len(wi), _CELLS, _CELLS, table.n_channels)


def _tree(plane: FloatArray) -> str:
    rows = [" ".join(f"{value:.7g}" for value in row) for row in plane.reshape(-1, _CELLS)]
    rows += [" ".join(["0"] * _CELLS)] * len(rows)
    return "{\n" + "\n".join(rows) + "\n}"
