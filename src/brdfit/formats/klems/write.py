"""Write a table as a Klems matrix: means over pairs of patches."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from brdfit.arrays import FloatArray
from brdfit.files import atomic_path
from brdfit.formats.klems.patches import FULL
from brdfit.formats.window_xml import written_document
from brdfit.formats.xyz import not_negative, refuse_other_channels, xyz_from_linear_rgb
from brdfit.table import Table

__all__ = ["write_table"]

# Places in a patch that stand for all of it: equal shares of its projected solid angle.
_POLAR = np.array([0.25, 0.25, 0.75, 0.75])
_AZIMUTH = np.array([-0.25, 0.25, -0.25, 0.25])


def write_table(table: Table, path: Path) -> None:
    """Write the means of `Table.evaluate`, four places in each patch of either direction."""
    refuse_other_channels(table, path, "a Klems matrix")
    values = not_negative(_means(table), path)
    planes = {"Visible": values[..., 0]}
    if table.n_channels == 3:
        x, y, z = np.moveaxis(xyz_from_linear_rgb(values), -1, 0)
        planes = {"Visible": y, "CIE-X": x, "CIE-Z": z}
    data = {
        name: "\n".join(",".join(f"{value:.7g}" for value in row) for row in plane)
        for name, plane in planes.items()
    }
    text = written_document(path.stem, "Columns", _definition(), _basis(), data)
    with atomic_path(path) as aside:
        aside.write_text(text, encoding="utf-8", newline="\n")


def _means(table: Table) -> FloatArray:
    """Return means (outgoing, incident, channels): a column for each direction of the light."""
    points = FULL.points(_POLAR, _AZIMUTH)
    wo = points.reshape(-1, 3)
    columns = []
    for patch in points * np.array([-1.0, -1.0, 1.0]):
        value = sum(table.evaluate(np.broadcast_to(wi, wo.shape), wo) for wi in patch)
        mean = np.asarray(value).reshape(FULL.size, len(_POLAR), -1).mean(axis=1) / len(patch)
        columns.append(mean)
    return np.stack(columns, axis=1)


def _definition() -> str:
    bands = "".join(
        "<AngleBasisBlock>\n"
        f"<Theta>{0.0 if band == 0 else 0.5 * (low + high):g}</Theta>\n"
        f"<nPhis>{count}</nPhis>\n"
        f"<ThetaBounds>\n<LowerTheta>{low:g}</LowerTheta>\n"
        f"<UpperTheta>{high:g}</UpperTheta>\n</ThetaBounds>\n"
        "</AngleBasisBlock>\n"
        for band, (low, high, count) in enumerate(
            zip(FULL.bounds[:-1], FULL.bounds[1:], FULL.counts, strict=True)
        )
    )
    return f"<AngleBasis>\n<AngleBasisName>{FULL.name}</AngleBasisName>\n{bands}</AngleBasis>\n"


def _basis() -> str:
    return (
        f"<ColumnAngleBasis>{FULL.name}</ColumnAngleBasis>\n"
        f"<RowAngleBasis>{FULL.name}</RowAngleBasis>\n"
    )
