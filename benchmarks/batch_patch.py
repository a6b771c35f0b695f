"""A synthetic patch: every point a mixture of decoded networks, measured in a few directions."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from brdfit.arrays import FloatArray
from brdfit.geometry import directions_from_spherical
from brdfit.populations import Population
from brdfit.samples import Samples

CHUNK = 2048


@dataclass(frozen=True, eq=False)
class Patch:
    """Points in rows of 512 pixels; each mixes three of the materials, smoothly over the patch.

    Of every point `samples` measurements, the same directions for all; 2 % noise, and of a
    share of the measurements all channels times a factor drawn log-uniformly from [1/10, 10].
    """

    materials: Population
    count: int
    samples: int = 64
    wrong: float = 0.2
    seed: int = 20261127
    width: int = 512

    @cached_property
    def directions(self) -> tuple[FloatArray, FloatArray]:
        """(wi, wo) of the measurements."""
        return random_directions(self.samples, self.seed)

    @cached_property
    def members(self) -> FloatArray:
        """f_r (samples, members, 3) of the materials at the measurements."""
        return self.materials.evaluate(*self.directions).astype(np.float64)

    def mixture(self, points: np.ndarray) -> tuple[np.ndarray, FloatArray]:
        """Return (members (n, 3), shares (n, 3)) of points."""
        rng = np.random.default_rng(self.seed)
        total = len(self.materials)
        x, y = points % self.width / self.width, points // self.width / self.width
        waves = rng.normal(size=(3, 4)) * 3.0
        level = [np.sin(a * x + b * y + c) + 0.3 * np.sin(9.0 * d * x) for a, b, c, d in waves]
        share = np.exp(2.0 * np.stack(level, axis=1))
        patch = ((3 * x).astype(int) + 3 * (3 * y).astype(int)) % total
        picks = rng.permutation(total)
        member = np.stack([picks[(patch * 3 + k) % total] for k in range(3)], axis=1)
        return member, share / share.sum(axis=1, keepdims=True)

    def measured(self, start: int, stop: int) -> FloatArray:
        """Return values (n, samples, 3) of points `start` to `stop`."""
        member, share = self.mixture(np.arange(start, stop))
        value = np.einsum("snkc,nk->nsc", self.members[:, member], share)
        return self._spoiled(value, start)

    def _spoiled(self, value: FloatArray, start: int) -> FloatArray:
        """Return values (n, samples, 3) with noise and outliers; `start` seeds them."""
        rng = np.random.default_rng([self.seed, start])
        value = np.maximum(value, 1e-5) * np.exp(0.02 * rng.normal(size=value.shape))
        order = np.argsort(rng.random(value.shape[:2]), axis=1)
        wrong = order < round(self.wrong * self.samples)
        factor = np.exp(rng.uniform(-np.log(10.0), np.log(10.0), wrong.shape))
        return value * np.where(wrong, factor, 1.0)[..., None]

    def scattered(self, count: int) -> list[Samples]:
        """Return the first points, each measured in directions of its own."""
        pairs = [random_directions(self.samples, point) for point in range(count)]
        value = np.empty((count, self.samples, 3))
        for point, (member, share) in enumerate(zip(*self.mixture(np.arange(count)), strict=True)):
            used = self.materials.evaluate(*pairs[point])[:, member].astype(np.float64)
            value[point] = np.einsum("skc,k->sc", used, share)
        value = self._spoiled(value, 0)
        return [Samples(wi=wi, wo=wo, value=v) for (wi, wo), v in zip(pairs, value, strict=True)]

    def truth(self, points: np.ndarray, wi: FloatArray, wo: FloatArray) -> FloatArray:
        """Return f_r (points, n, 3) at other directions."""
        member, share = self.mixture(points)
        values = self.materials.evaluate(wi, wo).astype(np.float64)
        return np.einsum("snkc,nk->nsc", values[:, member], share)

    def item(self, point: int) -> Samples:
        """Return the measurements of a point, as they stand in the table."""
        start = point // CHUNK * CHUNK
        value = self.measured(start, min(start + CHUNK, self.count))[point - start]
        return Samples(wi=self.directions[0], wo=self.directions[1], value=value)

    def write(self, path: Path) -> Path:
        """Write a long table as Parquet, a row group for every 2048 points."""
        import pyarrow.parquet as pq

        writer = None
        for table in self._tables():
            writer = writer or pq.ParquetWriter(path, table.schema)
            writer.write_table(table)
        assert writer is not None
        writer.close()
        return path

    def _tables(self) -> Iterator[object]:
        import pyarrow as pa

        for start in range(0, self.count, CHUNK):
            stop = min(start + CHUNK, self.count)
            value = self.measured(start, stop).reshape(-1, 3)
            item = np.repeat(np.arange(start, stop), self.samples)
            columns = {"item": item, "x": item % self.width, "y": item // self.width}
            for name, w in zip(("wi", "wo"), self.directions, strict=True):
                tiled = np.tile(w, (stop - start, 1))
                columns |= {f"{name}_{axis}": tiled[:, k] for k, axis in enumerate("xyz")}
            yield pa.table(columns | {c: value[:, k] for k, c in enumerate("RGB")})


def random_directions(n: int, seed: int) -> tuple[FloatArray, FloatArray]:
    """Return n pairs (wi, wo), uniform over the hemisphere down to 84 degrees."""
    rng = np.random.default_rng(seed)
    theta, phi = np.arccos(rng.uniform(0.1, 1.0, (2, n))), rng.uniform(-np.pi, np.pi, (2, n))
    wi, wo = directions_from_spherical(theta, phi)
    return wi, wo
