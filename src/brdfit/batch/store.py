"""The store of a batch: a Zarr group that is whole after every block, whenever it stops.

    OUT.zarr/
        zarr.json        settings, population, versions, input: what made it
        coefficients, outcome, ...    one chunk a block of items (`record.FIELDS`)
        basis            (cells, 1 + k): [mean | B], so that no population is needed again
        done             (blocks,): 1 where the chunks of a block are all written

A block's mark is written last, and chunks appear under their names only when they are
complete: a run that is killed loses at most the blocks that it was working on. What a block
writes depends on the block alone, so that a run in pieces leaves the same bytes as one.
"""

from __future__ import annotations

import os
import shutil
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from brdfit.arrays import IntArray
from brdfit.batch.columns import require_zarr
from brdfit.batch.record import FAILED, FIELDS, OUTCOMES, PartResult, words
from brdfit.errors import UsageError
from brdfit.reconstruct.compact import LeadingBasis

__all__ = ["BatchStore", "Facts"]

_KEY = "brdfit_batch"
_VERSION = 1
_BASIS_CHUNK = 8192


@dataclass(frozen=True)
class Facts:
    """What a store is made of; two runs with the same facts make the same store."""

    count: int
    block: int
    width: int
    """Bytes of a name."""
    channels: tuple[str, ...]
    wavelengths: tuple[float, ...]
    taken_from: dict[str, Any]
    method: dict[str, Any]
    population: dict[str, Any]
    versions: dict[str, str]

    def attributes(self, basis: LeadingBasis) -> dict[str, Any]:
        """Return the attributes of the group, as JSON-able values."""
        return {
            _KEY: _VERSION,
            "count": self.count,
            "block": self.block,
            "width": self.width,
            "channels": list(self.channels),
            "wavelengths": list(self.wavelengths),
            "input": self.taken_from,
            "method": self.method,
            "population": self.population,
            "versions": self.versions,
            "grid": list(basis.grid.shape),
            "outcomes": {str(1 + code): outcome.value for code, outcome in enumerate(OUTCOMES)},
        }


class BatchStore:
    """An open store, to be written block by block."""

    def __init__(self, path: Path, group: Any) -> None:
        self.path = path
        self.group = group
        self.attributes: dict[str, Any] = dict(group.attrs)
        self._arrays: dict[str, Any] = {}

    @classmethod
    def open(cls, path: Path, mode: str = "r") -> BatchStore:
        """Return the store at `path`. Raises `UsageError` where there is none."""
        zarr = require_zarr()
        try:
            group = zarr.open_group(str(path), mode=mode)
        except (OSError, ValueError) as error:
            raise UsageError(f"{path}: found no store of a batch ({error}).") from error
        if group.attrs.get(_KEY) != _VERSION:
            raise UsageError(
                f"{path}: is a Zarr group, but not one that brdfit batch wrote (version "
                f"{_VERSION}). Name another output."
            )
        return cls(path, group)

    @classmethod
    def create(cls, path: Path, facts: Facts, basis: LeadingBasis) -> BatchStore:
        """Make an empty store; it appears when it is ready to be written."""
        zarr = require_zarr()
        if not path.parent.is_dir():
            raise UsageError(f"{path}: the folder {path.parent} does not exist; create it first.")
        aside = path.with_name(f".{path.name}.part")
        shutil.rmtree(aside, ignore_errors=True)
        group = zarr.create_group(str(aside), attributes=facts.attributes(basis))
        inner = {
            "coefficients": (len(facts.channels), basis.size),
            "position": (2,),
            "name": (facts.width,),
            "message": (240,),
        }
        for field in FIELDS:
            rest = inner.get(field.name, ())
            group.create_array(
                field.name,
                shape=(facts.count, *rest),
                chunks=(facts.block, *rest),
                dtype=field.dtype,
                fill_value=field.fill,
                attributes={"meaning": field.meaning},
            )
        blocks = -(-facts.count // facts.block)
        group.create_array("done", shape=(blocks,), chunks=(1,), dtype="uint8", fill_value=0)
        rows = group.create_array(
            "basis",
            shape=basis.rows.shape,
            chunks=(_BASIS_CHUNK, basis.size),
            dtype="float32",
            attributes={"meaning": "[mean | B] of ln f_r at the cells of the grid above horizon"},
        )
        rows[:] = basis.rows
        os.replace(aside, path)
        return cls.open(path, "r+")

    @property
    def block(self) -> int:
        """Items of a block."""
        return int(self.attributes["block"])

    @property
    def count(self) -> int:
        """Number of items."""
        return int(self.attributes["count"])

    def missing(self) -> IntArray:
        """Return the blocks that are not done."""
        return np.flatnonzero(self.group["done"][:] == 0)

    def rows(self, block: int) -> tuple[int, int]:
        """Return the first item of a block and the one after its last."""
        start = int(block) * self.block
        return start, min(start + self.block, self.count)

    def put(self, block: int, result: PartResult) -> None:
        """Write a block, and mark it as done."""
        start, stop = self.rows(block)
        for name, values in result.arrays.items():
            self._array(name)[start:stop] = values
        self._array("done")[block] = 1

    def _array(self, name: str) -> Any:
        """Return an array of the group; its description is read once."""
        if name not in self._arrays:
            self._arrays[name] = self.group[name]
        return self._arrays[name]

    def outcomes(self) -> tuple[dict[str, int], str]:
        """Return (how many items ended how, the name of the first that has a result)."""
        codes = np.asarray(self.group["outcome"][:])
        names = {**{int(c): n for c, n in self.attributes["outcomes"].items()}, FAILED: "failed"}
        counts = {n: int((codes == c).sum()) for c, n in names.items()}
        good = np.flatnonzero((codes != 0) & (codes != FAILED))
        name = words(np.asarray(self.group["name"][int(good[0])])) if good.size else ""
        return {n: count for n, count in counts.items() if count}, name

    def clear_remains(self) -> None:
        """Remove what a killed writer left beside the chunks."""
        for remains in self.path.rglob("*.partial"):
            remains.unlink(missing_ok=True)

    def differences(self, facts: Facts, basis: LeadingBasis) -> list[str]:
        """Return in words what of a store differs from what a run wants to make."""
        wanted = facts.attributes(basis)
        return [
            f"{name}: {self.attributes.get(name)} there, {wanted[name]} now"
            for name in ("input", "method", "population", "channels", "versions")
            if self.attributes.get(name) != wanted[name]
        ]
