"""Write a table as an atlas."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from brdfit.errors import UsageError
from brdfit.files import atomic_path
from brdfit.formats.exr.layout import ATTRIBUTE, Atlas
from brdfit.formats.exr_file import write_exr
from brdfit.table import Table

__all__ = ["write_table"]


def write_table(table: Table, path: Path) -> None:
    """Write float32 without loss by compression; invalid cells are NaN.

    Raises `UsageError` for values that float32 cannot hold, and `MissingExtra` without OpenEXR.
    """
    atlas = Atlas.of(table)
    largest = np.abs(table.values[table.mask]).max(initial=0.0)
    if largest > np.finfo(np.float32).max:
        raise UsageError(
            f"{path.name}: the largest value is {largest:g} 1/sr, too large for float32. Write it "
            f"as .npz."
        )
    with np.errstate(invalid="ignore", over="ignore"):  # what invalid cells hold is not written
        planes = {
            name: atlas.picture(np.where(table.mask, table.values[..., channel], np.nan))
            for channel, name in enumerate(atlas.planes)
        }
    with atomic_path(path) as aside:
        write_exr(planes, {ATTRIBUTE: atlas.to_json()}, aside)
