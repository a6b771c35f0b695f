"""Many items with their samples end to end, and what the solver sees of them.

Nothing here depends on how many items stand together. Items that share all their directions
share their features; others are filled up to the longest with rows that say nothing. Items
in which every row knows all channels or none share the weights of a row among the channels.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from brdfit.arrays import BoolArray, FloatArray, IntArray
from brdfit.errors import UsageError
from brdfit.reconstruct.compact.basis import LeadingBasis
from brdfit.reconstruct.compact.solve import Items
from brdfit.samples import Samples

__all__ = ["Block", "Problem", "problems"]

# Items of 64 samples solved side by side: their matrices stay in the processor's cache.
_AT_ONCE = 256
_NARROWEST, _FLOOR = 0.7, 0.02


@dataclass(frozen=True, eq=False)
class Block:
    """`samples` of many items of the same channels, one after the other."""

    samples: Samples
    starts: IntArray
    """(items + 1,): item i has the rows from starts[i] to starts[i + 1]."""

    @classmethod
    def of(cls, items: Sequence[Samples]) -> Block:
        """Return the block of several measurements with the same channels."""
        first = items[0]
        odd = [s for s in items if s.channels != first.channels]
        if odd:
            raise UsageError(
                f"{odd[0].source.name}: found channels {', '.join(odd[0].channels)} but "
                f"{first.source.name} has {', '.join(first.channels)}; items that are fitted "
                f"together have the same channels."
            )
        sigma = None
        if any(s.sigma is not None for s in items):
            sigma = np.concatenate([_sigma(s) for s in items])
        joined = replace(
            first,
            wi=np.concatenate([s.wi for s in items]),
            wo=np.concatenate([s.wo for s in items]),
            value=np.concatenate([s.value for s in items]),
            sigma=sigma,
            flags=np.concatenate([s.bits for s in items]),
            rows=None,
        )
        return cls(joined, np.concatenate([[0], np.cumsum([len(s) for s in items])]))

    def __len__(self) -> int:
        return len(self.starts) - 1

    @cached_property
    def item_of(self) -> IntArray:
        """(rows,) the item of each row."""
        return np.repeat(np.arange(len(self)), np.diff(self.starts))

    @cached_property
    def used(self) -> BoolArray:
        """(rows,) samples with a usable channel."""
        return np.asarray(self.samples.usable.any(axis=1))

    @cached_property
    def failures(self) -> dict[int, str]:
        """Item -> why it cannot be fitted."""
        bright = self.per_item(self.samples.positive)
        found: dict[int, str] = {}
        for item in np.flatnonzero((bright == 0).any(axis=1)):
            dark = [n for n, b in zip(self.samples.channels, bright[item], strict=True) if not b]
            count = int(self.starts[item + 1] - self.starts[item])
            found[int(item)] = (
                f"found {count} samples but no usable positive value in channel "
                f"{', '.join(dark)}: nothing says how bright it is"
            )
        return found

    def per_item(self, rows: BoolArray) -> IntArray:
        """Return how often a mask (rows, ...) is true in each item."""
        total = np.concatenate([np.zeros((1, *rows.shape[1:]), np.int64), np.cumsum(rows, axis=0)])
        return np.asarray(total[self.starts[1:]] - total[self.starts[:-1]])

    @cached_property
    def shared_rows(self) -> IntArray | None:
        """Row numbers within an item that anybody uses, if all items have the same directions."""
        counts = np.diff(self.starts)
        if len(self) == 0 or (counts != counts[0]).any():
            return None
        pair = np.hstack([self.samples.wi, self.samples.wo]).reshape(len(self), counts[0], 6)
        if not np.array_equal(pair, np.broadcast_to(pair[:1], pair.shape), equal_nan=True):
            return None
        used = self.used.reshape(len(self), counts[0])
        return np.flatnonzero(used.any(axis=0))


def _sigma(samples: Samples) -> FloatArray:
    unknown = np.full(samples.value.shape, np.nan)
    return unknown if samples.sigma is None else samples.sigma


@dataclass(frozen=True, eq=False)
class Problem:
    """Items for the solver, which of the block they are, and where their rows come from."""

    index: IntArray
    """(b,)"""
    rows: IntArray
    """(b, n) rows of the block; -1 where a short item is filled up."""
    items: Items
    scatter: FloatArray
    """(b, n) variance of ln f_r besides s^2."""
    known: BoolArray
    """(b, n) rows that are used."""


def problems(block: Block, basis: LeadingBasis, floor: float) -> Iterator[Problem]:
    """Yield every item that can be fitted, some at a time; `floor` is absolute noise, 1/sr."""
    values = _Values.of(block, floor)
    can = np.setdiff1d(np.arange(len(block)), list(block.failures))
    shared = block.shared_rows
    design = None
    if shared is not None and can.size:
        first = shared + block.starts[0]
        design = basis.at(block.samples.wi[first], block.samples.wo[first])
    partial = block.per_item(values.partial) > 0
    for kind in (can[~partial[can]], can[partial[can]]):
        if shared is None:  # neighbours of alike length are filled up least
            length = block.per_item(block.used)
            kind = kind[np.argsort(length[kind], kind="stable")]
        if not kind.size:
            continue
        grouped = not partial[kind[0]]
        at_once = _at_once(block, grouped)
        for start in range(0, kind.size, at_once):
            index = kind[start : start + at_once]
            rows = _rows(block, index, shared)
            at = design or _design(block.samples, rows, basis)
            items = values.items(rows, *at, basis, grouped)
            known = items.known.max(axis=(1, 2)) > 0.0
            yield Problem(index, rows, items, items.scatter, known)


def _at_once(block: Block, grouped: bool) -> int:
    """Return how many items are solved side by side: fewer where each takes more room."""
    longest = int(np.diff(block.starts).max(initial=1))
    systems = 1 if grouped else block.samples.n_channels
    return max(1, int(_AT_ONCE / max(systems, longest / 64)))


def _rows(block: Block, index: IntArray, shared: IntArray | None) -> IntArray:
    if shared is not None:
        return np.asarray(block.starts[index][:, None] + shared)
    own = [
        start + np.flatnonzero(block.used[start:stop])
        for start, stop in zip(block.starts[index], block.starts[index + 1], strict=True)
    ]
    rows = np.full((len(own), max(map(len, own))), -1)
    for row, found in zip(rows, own, strict=True):
        row[: len(found)] = found
    return rows


def _design(samples: Samples, rows: IntArray, basis: LeadingBasis) -> tuple[FloatArray, FloatArray]:
    """Return (mean (b, n), phi (b, n, k)) of items with directions of their own."""
    there = rows.ravel() >= 0
    at = rows.ravel()[there]
    mean, phi = np.zeros(rows.size), np.zeros((rows.size, basis.size))
    mean[there], phi[there] = basis.at(samples.wi[at], samples.wo[at])
    return mean.reshape(rows.shape), phi.reshape(*rows.shape, -1)


@dataclass(frozen=True, eq=False)
class _Values:
    """ln f_r of all rows of a block, and what is known of each."""

    y: FloatArray
    """(rows, c): ln f_r, ln of the bound where censored, 0 where unknown."""
    known: BoolArray
    bound: BoolArray
    scatter: FloatArray
    """(rows,)"""

    @classmethod
    def of(cls, block: Block, floor: float) -> _Values:
        samples = block.samples
        positive, bound = samples.positive, samples.censored
        value = np.where(positive, samples.value, 1.0)
        if bound.any():
            value, bound = _with_bounds(block, value)
        known = positive | bound
        y = np.log(value)
        y[~known] = 0.0
        count = np.maximum(known.sum(axis=1), 1)
        scatter = (floor / np.exp(y.sum(axis=1) / count)) ** 2
        if samples.sigma is not None:
            stated = np.where(known & np.isfinite(samples.sigma), samples.sigma, 0.0)
            relative = stated / np.maximum(np.exp(y), 1e-12)
            scatter += np.minimum((relative**2).sum(axis=1) / count, 100.0)
        return cls(y, known, bound, scatter)

    @property
    def partial(self) -> BoolArray:
        """(rows,) rows that know some of the channels, or only a bound of one."""
        some = self.known.any(axis=1) & ~self.known.all(axis=1)
        return np.asarray(some | self.bound.any(axis=1))

    def items(
        self,
        rows: IntArray,
        mean: FloatArray,
        phi: FloatArray,
        basis: LeadingBasis,
        grouped: bool,
    ) -> Items:
        """Return what the solver sees of rows (b, n); `grouped` channels share their weights."""

        def channels_first(array: FloatArray | BoolArray) -> FloatArray:
            taken = np.moveaxis(np.asarray(array)[rows], 2, 1).astype(np.float64)
            return taken[:, None] if grouped else taken[:, :, None]

        there = rows >= 0
        known = channels_first(self.known) * there[:, None, None]
        y = channels_first(self.y)
        bounded = bool(self.bound.any())
        bound = channels_first(self.bound) * known if bounded else np.zeros_like(known)
        return Items(
            y=(y - (mean if mean.ndim == 1 else mean[:, None, None])) * known,
            known=known,
            bound=bound,
            background=_background(y, known > 0.0),
            scatter=np.where(there, self.scatter[rows], 0.0),
            features=phi,
            spread=basis.spread,
            bounded=bounded and bool(bound.any()),
            complete=bool(known.all()),
        )


def _with_bounds(block: Block, value: FloatArray) -> tuple[FloatArray, BoolArray]:
    """Return (value, bound), both (rows, c), with censored values at their item's noise floor.

    The floor of an item is the 1st percentile of its positive values (`Samples.noise_floor`).
    """
    samples = block.samples
    value, bound = value.copy(), np.zeros(value.shape, dtype=bool)
    for item in np.flatnonzero(block.per_item(samples.censored).any(axis=1)):
        rows = slice(int(block.starts[item]), int(block.starts[item + 1]))
        for channel in np.flatnonzero(samples.censored[rows].any(axis=0)):
            bright = samples.value[rows, channel][samples.positive[rows, channel]]
            if bright.size:
                bound[rows, channel] = samples.censored[rows, channel]
                value[rows, channel][bound[rows, channel]] = np.percentile(bright, 1.0)
    return value, bound


def _background(y: FloatArray, known: BoolArray) -> FloatArray:
    """Return ln of the density that no prediction explains, shaped as y (b, g, m, n).

    A normal about the median of an item's values, as broad as they are, and a thin floor.
    """
    b = len(y)
    values = np.where(known, y, np.nan).reshape(b, -1)
    count = known.reshape(b, -1).sum(axis=1)
    ordered = np.sort(values, axis=1)  # unknown ones last
    item = np.arange(b)
    centre = 0.5 * (ordered[item, (count - 1) // 2] + ordered[item, count // 2])
    mean = np.nansum(values, axis=1) / count
    variance = np.nansum((values - mean[:, None]) ** 2, axis=1) / count
    breadth = np.maximum(np.sqrt(variance), _NARROWEST)
    off, broad = y - centre[:, None, None, None], breadth[:, None, None, None]
    density = (1.0 - _FLOOR) * _normal(off, broad) + _FLOOR * _normal(off, 5.0)
    return np.asarray(np.log(density + 1e-30))


def _normal(x: FloatArray, width: FloatArray | float) -> FloatArray:
    return np.asarray(np.exp(-0.5 * (x / width) ** 2) / (width * np.sqrt(2.0 * np.pi)))
