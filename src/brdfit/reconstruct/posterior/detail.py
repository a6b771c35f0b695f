"""Detail: what many samples say beyond the population and the smooth residual.

    ln f_r(x) = m(x) + F(x) z + e(x) + q(x),     q ~ GP(0, a^2 kappa),   known by its neighbours

A smooth residual on some thousand rows cannot hold what a hundred thousand say. What it leaves
over, y - mean, is kriged from the nearest believed samples (`linalg.neighbours`), at the nodes
of a lattice (`linalg.lattice`): from then on q is that lattice, for one direction and for a
million alike. Nearness is a matter of a metric, one of a short list, in

    (stretch sqrt(theta_h / (pi/2)),  theta_d / (pi/2),  r cos 2 phi_d,  r sin 2 phi_d)

with r = around sin theta_d, or that times sin theta_h, and where it serves L of `section`
besides: a lobe's flank is far from its foot. `judging` finds metric, a, noise and who
is believed; if samples are no more likely with detail than without, there is none.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from brdfit.arrays import FloatArray
from brdfit.grid import Grid
from brdfit.linalg import Lattice, node_positions
from brdfit.progress import Progress, silent
from brdfit.reconstruct.posterior.calibration import Calibration
from brdfit.reconstruct.posterior.judging import Crossed, Rows, brought_to_rest
from brdfit.reconstruct.posterior.kernel import Angles, taken
from brdfit.reconstruct.posterior.measurements import Measurements
from brdfit.reconstruct.posterior.refine import Belief
from brdfit.reconstruct.posterior.section import Section
from brdfit.reconstruct.posterior.stages import Judged
from brdfit.reconstruct.slabs import Carried

__all__ = ["FEWEST", "Detail", "add_detail"]

FEWEST = 3000
"""Samples below which there is no detail: the smooth residual is as free as they allow."""
MOST = 100_000
"""Samples, evenly drawn, that decide it; all others are judged by it."""
# Nodes along sqrt(theta_h), theta_d and phi_d, and from how many samples on they are the finer.
_COARSE, _FINE, _MANY = (64, 46, 24), (90, 64, 36), 30_000
# Shares of the variance that are told apart.
_SMALLEST = 1e-6
_CHUNK = 65_536


@dataclass(frozen=True, eq=False)
class Detail:
    """q on a lattice, and how sure it is."""

    lattice: Lattice
    """Channels: q, one a channel of the samples; ln v; ln of the local factor of variances."""
    amplitude: float
    """a, ln f_r."""
    belief: Belief
    """Of the rows that decided: who is believed, the noise s, and the mixture."""
    calibration: Calibration
    likelihood: float
    """How much likelier a sample is than without, ln, mean."""

    def at(self, angles: Angles) -> FloatArray:
        """Return q (n, c) at (theta_h, theta_d, phi_d), each (n,), radians."""
        return self.lattice.at(_positions(angles))[:, :-2]

    def on_grid(self, grid: Grid) -> Carried:
        """Return q at the nodes of a grid."""
        coefficients = np.moveaxis(self.lattice.coefficients[..., :-2], -1, 1)
        axes = _unit(grid.theta_h, grid.theta_d, grid.phi_d)
        return Carried.of(np.ascontiguousarray(coefficients), *self.lattice.matrices(*axes))

    def variance(self, angles: Angles, of_smooth: FloatArray) -> FloatArray:
        """Return the variance of ln f_r (n,), from that of population and smooth residual.

        Among samples that of the kriging; far from all of them that of the rest besides.
        """
        v, factor = _certainty(self.lattice.at(_positions(angles)))
        return np.asarray(v * (factor * self.amplitude**2 + of_smooth))

    def judge(self, data: Measurements, before: FloatArray, angles: Angles) -> Judged:
        """Return what is made of rows that had no say; `before` (n, c) is ln f_r without q."""
        read = self.lattice.at(_positions(angles))
        v, factor = _certainty(read)
        mean = before + read[:, :-2]
        spread = factor * (v * self.amplitude**2 + self.belief.width**2) + data.scatter
        verdict = self.belief.mixture.judge(data.y, mean, spread, data.informative(mean))
        return Judged(verdict.responsibility, mean)


def add_detail(
    data: Measurements,
    judged: Judged,
    angles: Angles,
    belief: Belief,
    section: Section | None = None,
    progress: Progress = silent,
) -> tuple[Detail | None, Judged]:
    """Return the detail of `data` beyond `judged.mean`, or None, and what is made of all rows.

    `belief` is the mixture and the noise of the stages before, `section` what the population
    alone says. Rows beyond `MOST` have no say.
    """
    if len(data) < FEWEST:
        return None, judged
    some = data.spread_out(MOST)
    chosen = taken(angles, some)
    rows = Rows.of(data.take(some), judged.mean[some], chosen, section)
    if rows.whole.sum() < FEWEST:
        return None, judged
    found = brought_to_rest(rows, belief, progress)
    if found is None:
        return None, judged
    detail = _detail(rows, found, judged.responsibility[some])
    return detail, _verdict(detail, data, judged, angles, some)


def _detail(rows: Rows, found: Crossed, before: FloatArray) -> Detail:
    """Put q on a lattice; `before` (n,) is who was believed by the stages before."""
    shape = _FINE if len(found.pool) > _MANY else _COARSE
    u, v, turn = node_positions(shape).T
    nodes = (u**2 * (np.pi / 2), v * (np.pi / 2), turn * np.pi)
    kriged = found.system.at(found.metric.places(nodes))
    logs = np.log(np.maximum(kriged.variance, _SMALLEST)), np.log(found.factor_of(kriged))
    values = np.column_stack([kriged.mean, *logs]).reshape(*shape, -1)
    belief = found.belief
    believed = np.maximum(belief.responsibility, before)
    calibration = Calibration.of(found.surprise(rows), believed, belief.mixture.freedom)
    return Detail(Lattice.through(values), found.amplitude, belief, calibration, found.gain)


def _verdict(
    detail: Detail, data: Measurements, judged: Judged, angles: Angles, some: np.ndarray
) -> Judged:
    responsibility, mean = np.empty(len(data)), np.empty_like(judged.mean)
    for start in range(0, len(data), _CHUNK):
        rows = np.arange(start, min(start + _CHUNK, len(data)))
        found = detail.judge(data.take(rows), judged.mean[rows], taken(angles, rows))
        responsibility[rows], mean[rows] = found.responsibility, found.mean
    responsibility[some] = detail.belief.responsibility
    # Whom population and smooth residual believe is not called wrong: of flakes that are seen
    # one by one neighbours are a poor witness.
    return Judged(np.maximum(responsibility, judged.responsibility), mean)


def _certainty(read: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return v and the local factor, each (n,), of what is read from the lattice (n, c + 2)."""
    v, factor = np.exp(read[:, -2:]).T
    return np.minimum(v, 1.0), factor


def _positions(angles: Angles) -> FloatArray:
    return np.stack(_unit(*angles), axis=1)


def _unit(theta_h: FloatArray, theta_d: FloatArray, phi_d: FloatArray) -> Angles:
    """Return where angles are in the box of the lattice."""
    return np.sqrt(theta_h / (np.pi / 2)), theta_d / (np.pi / 2), phi_d / np.pi
