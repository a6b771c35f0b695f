"""Read an atlas."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from brdfit.errors import CorruptFile, FormatError
from brdfit.files import sha256_of_bytes
from brdfit.formats.exr.layout import ATTRIBUTE, Atlas
from brdfit.formats.exr_file import read_exr, read_exr_header
from brdfit.formats.own import own_source
from brdfit.samples import Source
from brdfit.table import Table

__all__ = ["read_table"]


def read_table(path: Path) -> Table:
    """Return the table; cells that hold NaN are not valid.

    Raises `FormatError` for other OpenEXR pictures, `CorruptFile` where header and pixels
    disagree, and `MissingExtra` without OpenEXR.
    """
    header = read_exr_header(path)
    text = header.get(ATTRIBUTE)
    if not isinstance(text, str):
        raise FormatError(
            f"{path.name}: is an OpenEXR picture, but no table that brdfit wrote: its header has "
            f"no attribute {ATTRIBUTE!r}. A panorama is light, for brdfit render --environment."
        )
    atlas = Atlas.from_json(text, path.name)
    planes, _ = read_exr(path)
    missing = [name for name in atlas.planes if name not in planes]
    shapes = {plane.shape for plane in planes.values()} - {atlas.shape}
    if missing or shapes:
        found = "x".join(map(str, min(shapes))) if shapes else f"no channel {missing[0]!r}"
        raise CorruptFile(
            f"{path.name}: the header describes {len(atlas.planes)} channels of "
            f"{atlas.shape[0]}x{atlas.shape[1]} pixels, but the file has {found}. It was resized "
            f"or edited; write the table again."
        )
    values = np.stack([atlas.cells(planes[name]) for name in atlas.planes], axis=-1)
    return Table(
        values.astype(np.float32),
        grid=atlas.grid,
        wavelengths=None if atlas.wavelengths is None else np.array(atlas.wavelengths),
        channels=atlas.channels,
        source=own_source(
            atlas.source,
            Source(name=path.name, format="exr", sha256=sha256_of_bytes(path.read_bytes())),
        ),
    )
