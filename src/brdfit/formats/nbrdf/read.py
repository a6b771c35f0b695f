"""Read the weights of a network and evaluate it on the MERL grid."""

from __future__ import annotations

import difflib
from dataclasses import replace
from pathlib import Path

import numpy as np

from brdfit.arrays import FloatArray, IntArray
from brdfit.errors import UsageError
from brdfit.files import sha256_of_bytes
from brdfit.formats.drawing import Draw
from brdfit.formats.nbrdf import CONVENTION
from brdfit.formats.network_file import archived_networks, read_layers
from brdfit.grid import MERL_GRID
from brdfit.models.network import Networks
from brdfit.samples import Samples, Source
from brdfit.table import Table

__all__ = ["read_samples", "read_table"]

_CHANNELS = ("R", "G", "B")
_FEW = 8


def read_table(path: Path, material: str | None) -> Table:
    """Return the network at the nodes of the MERL grid, float32.

    `material` names one of an archive; it may be left out where there is one only. Raises
    `CorruptFile` for what is no network of the published shape, and `UsageError` for a
    material that is not there.
    """
    network, source = _read(path, material)
    values = np.zeros((MERL_GRID.size, 3), dtype=np.float32)
    values[MERL_GRID.cells] = _at(network, MERL_GRID.cells)
    note = "a network's values at the nodes of the MERL grid; it is defined between them too"
    return Table(
        values.reshape(*MERL_GRID.shape, 3),
        channels=_CHANNELS,
        source=replace(source, notes=(*source.notes, note)),
    )


def read_samples(path: Path, material: str | None, draw: Draw) -> Samples:
    """Return the network at nodes of the MERL grid; `rows` are 1-based cell numbers.

    Errors as of `read_table`.
    """
    network, source = _read(path, material)
    cells = MERL_GRID.cells
    chosen = cells[draw.of(cells.size, f"{path.name}: there are {cells.size:,} cells")]
    wi, wo = MERL_GRID.directions(chosen)
    return Samples(
        wi=wi,
        wo=wo,
        value=_at(network, chosen),
        channels=_CHANNELS,
        rows=chosen + 1,
        source=replace(
            source, notes=(*source.notes, *draw.notes(cells.size, "cells of the MERL grid"))
        ),
    )


def _read(path: Path, material: str | None) -> tuple[Networks, Source]:
    content = path.read_bytes()
    notes: tuple[str, ...] = ()
    if content.startswith(b"PK"):
        entries = archived_networks(content, path.name)
        name = _chosen(path.name, material, list(entries))
        notes = (f"{name}, one of {len(entries)} networks of the archive",)
        layers = read_layers(entries[name], name)
    else:
        if material is not None:
            raise UsageError(f"{path.name}: holds one network; material= is for an archive.")
        name = path.stem
        layers = read_layers(content, path.name)
    source = Source(
        name=path.name,
        format="nbrdf",
        sha256=sha256_of_bytes(content),
        convention=CONVENTION,
        notes=notes,
        metadata={"material": name},
    )
    return Networks.of([layers]), source


def _at(network: Networks, cells: IntArray) -> FloatArray:
    """Return f_r (len(cells), 3) at nodes of the MERL grid."""
    wi, wo = MERL_GRID.directions(cells)
    with np.errstate(over="ignore", invalid="ignore"):  # wild weights end as invalid values
        return np.asarray(network.evaluate(wi, wo)[:, :, 0].T)


def _chosen(name: str, material: str | None, known: list[str]) -> str:
    shown = ", ".join(known[:_FEW]) + (", ..." if len(known) > _FEW else "")
    if material is None:
        if len(known) == 1:
            return known[0]
        raise UsageError(
            f"{name}: holds {len(known)} materials; say which with material=..., on the "
            f"command line --material ({shown})."
        )
    if material not in known:
        close = difflib.get_close_matches(str(material), known, n=1)
        hint = f" Did you mean {close[0]!r}?" if close else ""
        raise UsageError(f"{name}: has no material {material!r}.{hint} It has {shown}.")
    return material
