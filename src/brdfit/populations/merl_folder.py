"""A folder of MERL `.binary` files as a population: the user's own copy of the database.

The files are told apart by SHA-256: a published table, one that was altered, one that is
not of the database. All are used; what is not published is said. The folder is read once,
table by table, into log columns on the MERL grid, and every later question is answered from
those: the memory in use stays small however many tables there are. Therefore values below
`VALUE_FLOOR` come back as `VALUE_FLOOR`, and a cell that a table lacks has the value of the
nearest cell that it has.

Database: W. Matusik, H. Pfister, M. Brand, L. McMillan, "A Data-Driven Reflectance Model",
ACM Transactions on Graphics 22(3), 2003.
"""

from __future__ import annotations

import csv
import os
from dataclasses import dataclass
from functools import cached_property, lru_cache
from importlib.resources import files
from pathlib import Path

import numpy as np

from brdfit.arrays import BoolArray, FloatArray, IntArray, as_directions
from brdfit.errors import BrdfitError, PopulationError
from brdfit.files import sha256_of_bytes, sha256_of_file
from brdfit.geometry import half_diff_from_directions
from brdfit.grid import MERL_GRID, Grid
from brdfit.populations.building import open_store
from brdfit.populations.cache import remember
from brdfit.populations.contract import member_values
from brdfit.progress import Progress, silent

__all__ = ["MerlFile", "MerlFolder", "published_sha256", "read_merl_folder"]

SUFFIX = ".binary"
CHANNELS = ("R", "G", "B")

# Raise it when a change of the evaluation changes values.
_VERSION = 1
# Directions of a block: eight corners each, for all members, are in memory at once.
_BLOCK = 8192


@dataclass(frozen=True)
class MerlFile:
    """One file of the folder and what its hash says."""

    path: Path
    sha256: str

    @property
    def material(self) -> str:
        """File name without its suffix."""
        return self.path.stem

    @property
    def verdict(self) -> str:
        """One of "published", "renamed", "altered", "unknown"."""
        known = published_sha256()
        if known.get(self.material) == self.sha256:
            return "published"
        if self.sha256 in known.values():
            return "renamed"
        return "altered" if self.material in known else "unknown"

    @property
    def explanation(self) -> str:
        """The verdict in words."""
        if self.verdict == "renamed":
            is_really = next(
                name for name, sha256 in published_sha256().items() if sha256 == self.sha256
            )
            return f"the published table of {is_really!r} under another name"
        return {
            "published": "the table of the database, unaltered",
            "altered": "named as a table of the database, but its content differs",
            "unknown": "not a table of the database",
        }[self.verdict]


@dataclass(frozen=True, eq=False)
class MerlFolder:
    """A `MemberSource` (and `TabulatedSource`) over the files of a folder."""

    name: str
    """Path of the folder as the user gave it."""
    tables: tuple[MerlFile, ...]
    """Sorted by material."""

    @cached_property
    def members(self) -> tuple[str, ...]:
        """File names without suffix."""
        return tuple(table.material for table in self.tables)

    @property
    def materials(self) -> tuple[str, ...]:
        """A table is a material."""
        return self.members

    @property
    def channels(self) -> tuple[str, ...]:
        """R, G, B."""
        return CHANNELS

    @property
    def bilateral(self) -> bool:
        """No: the tables were measured over all of phi_d."""
        return False

    @cached_property
    def fingerprint(self) -> str:
        """SHA-256 over names and hashes of the files, and the version of their evaluation."""
        lines = [f"merl {_VERSION}", *(f"{file.material} {file.sha256}" for file in self.tables)]
        return sha256_of_bytes("\n".join(lines).encode())

    @property
    def notes(self) -> tuple[str, ...]:
        """One sentence for each file that is not a published table under its own name."""
        return tuple(
            f"{table.path.name}: {table.explanation}"
            for table in self.tables
            if table.verdict != "published"
        )

    def prepare(self, progress: Progress = silent) -> None:
        """Read all tables, unless that was done before: seconds per table."""
        open_store(self, MERL_GRID, progress)

    def evaluate(self, wi: FloatArray, wo: FloatArray, pick: IntArray) -> FloatArray:
        """Return f_r (n, len(pick), 3), float32, at direction pairs (n, 3); 0 below the horizon.

        Trilinear between the cells above the horizon, as `Table.evaluate`.
        """
        wi, wo = as_directions("wi", wi), as_directions("wo", wo)
        below = (wi[:, 2] <= 0.0) | (wo[:, 2] <= 0.0)
        store = open_store(self, MERL_GRID)
        by_channel = np.empty((len(CHANNELS), len(wi), len(pick)), dtype=np.float32)
        for start in range(0, len(wi), _BLOCK):
            rows = slice(start, start + _BLOCK)
            index, weight = _existing_corners(wi[rows], wo[rows])
            for channel in range(len(CHANNELS)):
                logs = np.empty((index.size, len(pick)), dtype=np.float32)
                for positions, values in store.gather(channel, index.ravel()):
                    logs[positions] = values[:, pick]
                corners = np.exp(logs, out=logs).reshape(*index.shape, len(pick))
                by_channel[channel, rows] = np.einsum("nc,ncm->nm", weight, corners)
        by_channel[:, below] = 0.0
        return member_values(by_channel)

    def cell_values(self, member: int, grid: Grid, cells: IntArray) -> FloatArray:
        """Return f_r (len(cells), 3) of one table, holes filled from the nearest valid cell."""
        from brdfit.formats import read_table

        path = self.tables[member].path
        try:
            table = read_table(path)
        except (OSError, BrdfitError) as error:
            raise PopulationError(
                f"population {self.name!r}: {path.name} cannot be used ({error}) Repair it, or "
                f"take it out of the folder."
            ) from error
        if not table.mask.any() or table.n_channels != len(CHANNELS):
            raise PopulationError(
                f"population {self.name!r}: {path.name} has {int(table.mask.sum())} valid cells "
                f"and {table.n_channels} channels, but a member needs some and three."
            )
        if grid != table.grid:
            return table.evaluate(*grid.directions(cells))
        values = table.values.reshape(-1, len(CHANNELS))[cells]
        holes = ~table.mask.reshape(-1)[cells]
        if holes.any():
            values[holes] = table.evaluate(*grid.directions(cells[holes]))
        return np.asarray(values)


def read_merl_folder(
    folder: str | os.PathLike[str], name: str | None = None, progress: Progress = silent
) -> MerlFolder:
    """Return the population of the `.binary` files in `folder` (not in folders below it).

    Hashes are computed once and remembered for as long as names, sizes and times of the
    files stay. Raises `PopulationError` where there are no such files.
    """
    folder = Path(folder)
    paths = sorted(path for path in folder.iterdir() if path.suffix.lower() == SUFFIX)
    if not paths:
        raise PopulationError(
            f"{folder}: found no {SUFFIX} file but a population folder holds MERL tables, one "
            f"file per material. Give the folder that the files are in, not the one above."
        )
    states = [(str(path.resolve()), path.stat()) for path in paths]
    listing = "\n".join(f"{path}|{at.st_size}|{at.st_mtime_ns}" for path, at in states)

    def digest() -> dict[str, np.ndarray]:
        label = f"checking the files of {folder.name}"
        progress(label, 0, len(paths))
        hashes = []
        for done, path in enumerate(paths, start=1):
            hashes.append(sha256_of_file(path))
            progress(label, done, len(paths))
        return {"sha256": np.array(hashes)}

    hashes = remember("folder-hashes", listing, digest)["sha256"]
    tables = tuple(MerlFile(path, str(sha256)) for path, sha256 in zip(paths, hashes, strict=True))
    return MerlFolder(name or str(folder), tables)


@lru_cache(maxsize=1)
def published_sha256() -> dict[str, str]:
    """Return material -> SHA-256 of the 100 tables of the database."""
    text = files("brdfit.populations").joinpath("data/merl_sha256.csv").read_text()
    lines = (line for line in text.splitlines() if not line.startswith("#"))
    return {row["material"]: row["sha256"] for row in csv.DictReader(lines)}


@lru_cache(maxsize=1)
def _rows_of_cells() -> IntArray:
    """Return the row of each flat cell of the MERL grid; -1 below the horizon."""
    rows = np.full(MERL_GRID.size, -1, dtype=np.int64)
    rows[MERL_GRID.cells] = np.arange(MERL_GRID.cells.size)
    return rows


def _existing_corners(wi: FloatArray, wo: FloatArray) -> tuple[IntArray, FloatArray]:
    """Return (rows, weights), each (n, 8), of interpolation among cells above the horizon.

    Where none of the eight exists, the nearest smaller theta_d that does answers.
    """
    index, weight = MERL_GRID.corners(*half_diff_from_directions(wi, wo))
    rows = _rows_of_cells()[index]
    share = np.where(rows >= 0, weight, 0.0)
    lost = ~(share.sum(axis=1) > 0.0)
    if lost.any():
        heaviest = index[lost, np.argmax(weight[lost], axis=1)]
        i, j, k = np.unravel_index(heaviest, MERL_GRID.shape)
        # Above the horizon there is all of theta_d up to a limit, for each (theta_h, phi_d).
        limit = MERL_GRID.above_horizon.sum(axis=1)[i, k] - 1
        inside = np.ravel_multi_index((i, np.minimum(j, limit), k), MERL_GRID.shape)
        rows[lost, 0] = _rows_of_cells()[inside]
        share[lost, 0] = 1.0
    exists: BoolArray = share > 0.0
    # A corner without weight is read from where its neighbour is read.
    rows = np.where(exists, rows, rows.max(axis=1, keepdims=True))
    return rows, share / share.sum(axis=1, keepdims=True)
