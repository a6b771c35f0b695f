"""Read the weights of a network and evaluate it on the MERL grid."""

from __future__ import annotations

import difflib
from pathlib import Path

import numpy as np

from brdfit.arrays import FloatArray
from brdfit.errors import UsageError
from brdfit.files import sha256_of_bytes
from brdfit.formats.nbrdf import CONVENTION
from brdfit.formats.network_file import archived_networks, read_layers
from brdfit.grid import MERL_GRID
from brdfit.models.network import Networks
from brdfit.samples import Source
from brdfit.table import Table

__all__ = ["read_table"]

_FEW = 8


def read_table(path: Path, material: str | None) -> Table:
    """Return the network at the nodes of the MERL grid, float32.

    `material` names one of an archive; it may be left out where there is one only. Raises
    `CorruptFile` for what is no network of the published shape, and `UsageError` for a
    material that is not there.
    """
    content = path.read_bytes()
    note: tuple[str, ...] = ()
    if content.startswith(b"PK"):
        entries = archived_networks(content, path.name)
        name = _chosen(path.name, material, list(entries))
        note = (f"{name}, one of {len(entries)} networks of the archive",)
        layers = read_layers(entries[name], name)
    else:
        if material is not None:
            raise UsageError(f"{path.name}: holds one network; material= is for an archive.")
        name = path.stem
        layers = read_layers(content, path.name)
    return Table(
        _on_grid(Networks.of([layers])),
        channels=("R", "G", "B"),
        source=Source(
            name=path.name,
            format="nbrdf",
            sha256=sha256_of_bytes(content),
            convention=CONVENTION,
            notes=(
                *note,
                "a network's values at the nodes of the MERL grid; it is defined between them too",
            ),
            metadata={"material": name},
        ),
    )


def _on_grid(networks: Networks) -> FloatArray:
    cells = MERL_GRID.cells
    wi, wo = MERL_GRID.directions(cells)
    values = np.zeros((MERL_GRID.size, 3), dtype=np.float32)
    with np.errstate(over="ignore"):
        values[cells] = networks.evaluate(wi, wo)[:, :, 0].T
    return values.reshape(*MERL_GRID.shape, 3)


def _chosen(name: str, material: str | None, known: list[str]) -> str:
    shown = ", ".join(known[:_FEW]) + (", ..." if len(known) > _FEW else "")
    if material is None:
        if len(known) == 1:
            return known[0]
        raise UsageError(
            f"{name}: holds {len(known)} materials; say which with material=... ({shown})."
        )
    if material not in known:
        close = difflib.get_close_matches(str(material), known, n=1)
        hint = f" Did you mean {close[0]!r}?" if close else ""
        raise UsageError(f"{name}: has no material {material!r}.{hint} It has {shown}.")
    return material
