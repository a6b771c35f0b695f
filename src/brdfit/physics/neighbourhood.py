"""Samples by where they lie: which others are near, mirrored, or the exchange of one."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from brdfit.arrays import FloatArray, IntArray
from brdfit.samples import Samples

__all__ = ["Neighbourhood", "mean_of_channels"]


def mean_of_channels(samples: Samples) -> FloatArray:
    """Return the mean (n,) over usable channels, 1/sr; 0 where none is."""
    value = np.where(samples.usable, samples.value, 0.0)
    return np.asarray(value.sum(axis=1) / np.maximum(samples.usable.sum(axis=1), 1))


@dataclass(frozen=True, eq=False)
class Neighbourhood:
    """The samples of one material, (n,) each, with ln of the mean over channels.

    Only where that mean is positive, over the channels that are usable.
    """

    rows: IntArray
    """Which samples these are."""
    theta_h: FloatArray
    theta_d: FloatArray
    phi_d: FloatArray
    """[0, 2 pi): it tells light from detector."""
    larger_angle: FloatArray
    """The larger of theta_i and theta_o, radians."""
    log_f: FloatArray

    @classmethod
    def of(cls, samples: Samples) -> Neighbourhood:
        """Return the neighbourhood of the samples whose mean over channels is positive."""
        level = mean_of_channels(samples)
        rows = np.flatnonzero(level > 0.0)
        theta_h, theta_d, phi_d = (angle[rows] for angle in samples.half_diff)
        lower = np.minimum(samples.wi[rows, 2], samples.wo[rows, 2])
        return cls(
            rows,
            theta_h,
            theta_d,
            phi_d,
            larger_angle=np.arccos(np.clip(lower, 0.0, 1.0)),
            log_f=np.log(level[rows]),
        )

    def __len__(self) -> int:
        return len(self.log_f)

    @cached_property
    def place(self) -> FloatArray:
        """(n, 4) points whose distances are angles in radians."""
        return self._place(self.phi_d)

    def _place(self, phi_d: FloatArray) -> FloatArray:
        # Turning phi_d by d moves the directions by about min(sin theta_h, sin theta_d) d.
        radius = np.minimum(np.sin(self.theta_h), np.sin(self.theta_d))
        return np.stack(
            [self.theta_h, self.theta_d, radius * np.cos(phi_d), radius * np.sin(phi_d)], axis=-1
        )

    @cached_property
    def _tree(self) -> Any:
        from scipy.spatial import cKDTree

        return cKDTree(self.place)

    def swapped(self, within: float) -> FloatArray:
        """Return |delta ln f| (pairs,) of samples and others at (wo, wi), `within` radians."""
        return self._difference(self.swapped_pairs(within))

    def mirrored(self, within: float) -> FloatArray:
        """Return |delta ln f| (pairs,) of samples and others at -phi_d, `within` radians."""
        return self._difference(self._pairs(self._place(-self.phi_d), within))

    def swapped_pairs(self, within: float) -> IntArray:
        """Return (2, pairs) of places in `rows` whose directions are each other's exchange."""
        return self._pairs(self._place(self.phi_d + np.pi), within)

    def _difference(self, pairs: IntArray) -> FloatArray:
        return np.asarray(np.abs(self.log_f[pairs[0]] - self.log_f[pairs[1]]))

    def _pairs(self, wanted: FloatArray, within: float) -> IntArray:
        away, other = self._tree.query(wanted, distance_upper_bound=within)
        # Where the wanted place is the sample's own, nothing is compared.
        moved = np.linalg.norm(wanted - self.place, axis=1) > 2.0 * within
        rows = np.flatnonzero(np.isfinite(away) & moved)
        return np.asarray(np.unique(np.sort(np.stack([rows, other[rows]]), axis=0), axis=1))

    def unexplained(self, rows: IntArray, neighbours: int = 14) -> FloatArray:
        """Return ln f of samples `rows` (m,) less what a plane through their neighbours says."""
        _, near = self._tree.query(self.place[rows], k=neighbours + 1)
        near = near[:, 1:]
        offset = self.place[near] - self.place[rows][:, None, :]
        scale = np.maximum(np.abs(offset).max(axis=(1, 2), keepdims=True), 1e-9)
        design = np.concatenate([np.ones((*near.shape, 1)), offset / scale], axis=2)
        normal = np.einsum("nki,nkj->nij", design, design) + 1e-6 * np.eye(5)
        right = np.einsum("nki,nk->ni", design, self.log_f[near])
        level = np.linalg.solve(normal, right[..., None])[:, 0, 0]
        # The plane's own noise, whose level is at row 0 of the inverse, is taken off.
        share = np.sqrt(1.0 + np.linalg.inv(normal)[:, 0, 0])
        return np.asarray((self.log_f[rows] - level) / share)
