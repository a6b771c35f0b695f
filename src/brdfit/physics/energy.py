"""No surface reflects more than it receives: how much a table does, and the nearest that does not.

Among all tables with albedo a(theta) <= limit at every incidence, `limit_energy` returns the
one that differs least from the given f, in the sense of

    sum over cells of  m / s^2  (f' ln(f' / f) - f' + f),

m the measure of a cell and s the standard deviation of ln f there: a value that is well known
is dear to change. The albedo is linear in f', so the minimum has the form

    f' = f exp(-s^2 (lambda(theta_i) + lambda(theta_o))),     lambda >= 0,

with lambda(theta) = 0 wherever the limit does not bind, at the nodes of the grid's theta_d and
linear between. A node answers for the largest albedo within half a step. It is found by repeated
projections, each lowering the albedo at all angles that exceed the limit (for s = 1 that is the
symmetric scaling of Sinkhorn). f' is reciprocal where f is, has its symmetries, and is nowhere
above it.

No value is made black to spare another: ln f gives way by at most 3 s. Where that is not enough
the known values are wrong too, and a second pass lowers all with s > 0 alike. Where values with
s = 0 must stay, that pass has the same bound, and a third has none, at those incidences where the
values that stay leave room for any other light at all.

References: J.-D. Benamou et al., "Iterative Bregman Projections for Regularized Transportation
Problems", SIAM Journal on Scientific Computing 37(2), 2015 (the projections); R. Sinkhorn,
"A Relationship Between Arbitrary Positive Matrices and Doubly Stochastic Matrices", Annals of
Mathematical Statistics 35(2), 1964.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from brdfit.arrays import BoolArray, FloatArray, IntArray, frozen
from brdfit.errors import UsageError
from brdfit.geometry import cos_incident_outgoing
from brdfit.grid import Grid
from brdfit.physics.albedo_plan import AlbedoPlan
from brdfit.table import Table

__all__ = ["EnergyLimit", "limit_energy", "limited_incidences"]

_ITERATIONS = 60
# Half a Newton step and a little: light and detector both carry a lambda.
_STEP = 0.6
_TOLERANCE = 2e-4
# By how many standard deviations of ln f a value gives way before all give way.
_MOST = 3.0
_CHANGED = 0.999
_TINY = 1e-300


@dataclass(frozen=True, eq=False)
class EnergyLimit:
    """A table that nowhere reflects more than the limit, and what that changed.

    | name      | shape              | unit and range                                          |
    |-----------|--------------------|---------------------------------------------------------|
    | `theta_i` | (angles,)          | radians: the grid's theta_d and halfway between         |
    | `before`  | (angles, channels) | directional albedo of the table that was given          |
    | `after`   | (angles, channels) | the same of `table`                                     |
    """

    table: Table
    limit: float
    theta_i: FloatArray
    before: FloatArray
    after: FloatArray
    changed: int
    """Cells with a value that was lowered by more than 0.1 %."""
    strongest: float
    """The smallest factor that any value was multiplied by, in (0, 1]."""

    @property
    def excess(self) -> float:
        """How far the albedo is still above the limit; 0 unless values are held by s = 0."""
        return max(0.0, float(self.after.max()) - self.limit)


def limit_energy(
    table: Table, stddev: npt.ArrayLike | None = None, *, limit: float = 1.0
) -> EnergyLimit:
    """Return the table nearest to `table` whose directional albedo is at most `limit`.

    Parameters
    ----------
    table
        Any channels, each limited by itself. Negative values count as they are.
    stddev
        Standard deviation of ln f_r, shaped as the grid or as `table.values`, >= 0: where it
        is large a value gives way first, where it is 0 a value is never changed. Left out,
        all give way alike. NaN (not known) in cells that are not valid is of no consequence.
    limit
        Largest albedo, above 0.

    Raises `UsageError` for a `stddev` of another shape, negative, or not finite where the
    table is valid. A table that respects the limit is returned as it is.
    """
    if not limit > 0.0:
        raise UsageError(f"limit: found {limit} but an albedo that can be kept is above 0.")
    spread = _spread(table, stddev)
    plan = AlbedoPlan.build(table.grid, table.mask, limited_incidences(table.grid))
    before = plan.of(table)
    channels = np.flatnonzero((before > limit).any(axis=0))
    if channels.size == 0:
        return EnergyLimit(table, limit, plan.theta_i, before, before, 0, 1.0)

    seats = _Seats.of(table.grid)
    values = np.array(table.values.reshape(table.grid.size, -1))
    factor = np.ones_like(values, dtype=np.float64)
    for channel in channels:
        s = None if spread is None else spread[:, min(channel, spread.shape[1] - 1)]
        column = values[:, channel].astype(np.float64)
        factor[:, channel] = _factor(plan, seats, column, s, limit)
    factor[~table.mask.reshape(-1)] = 1.0
    values *= factor.astype(values.dtype)
    values = values.reshape(table.values.shape)
    values.flags.writeable = False
    limited = replace(table, values=values)
    changed = int((factor < _CHANGED).any(axis=1).sum())
    after = frozen(plan.of(limited))
    strongest = float(factor.min())
    return EnergyLimit(limited, limit, plan.theta_i, frozen(before), after, changed, strongest)


def limited_incidences(grid: Grid) -> FloatArray:
    """Return the angles (2 n_theta_d,) at which a limit is kept, radians.

    The nodes of theta_d, halfway between them, and halfway from the last to grazing: a table
    answers between and beyond its nodes too.
    """
    n = 2 * grid.n_theta_d
    return np.asarray(np.arange(n) / n * (np.pi / 2))


def _factor(
    plan: AlbedoPlan, seats: _Seats, f: FloatArray, s: FloatArray | None, limit: float
) -> FloatArray:
    """Return what each cell's value is multiplied by, (cells of the grid,)."""
    if s is None:
        return _Projection(plan, seats, f, np.ones(f.size), np.inf, limit).solve()
    factor = _Projection(plan, seats, f, s, _MOST, limit).solve()
    if (plan.albedo((f * factor)[plan.cells]) > limit).any():
        # Values that must stay may be all it takes: nothing is made black in vain.
        free = (s > 0.0).astype(np.float64)
        most = np.inf if free.all() else _MOST
        factor *= _Projection(plan, seats, f * factor, free, most, limit).solve()
    albedo, held = plan.albedo((f * factor)[plan.cells]), plan.albedo((f * (s == 0.0))[plan.cells])
    within_reach = held < limit * (1.0 - _TOLERANCE)
    if (albedo > limit)[within_reach].any():
        free = (s > 0.0).astype(np.float64)
        last = _Projection(plan, seats, f * factor, free, np.inf, limit, within_reach)
        factor *= last.solve()
    return factor


@dataclass(frozen=True, eq=False)
class _Seats:
    """Where theta_i and theta_o of every cell of a grid lie among its nodes of theta_d."""

    light: FloatArray
    detector: FloatArray

    @classmethod
    def of(cls, grid: Grid) -> _Seats:
        cosines = cos_incident_outgoing(
            grid.theta_h[:, None, None], grid.theta_d[None, :, None], grid.phi_d[None, None, :]
        )
        nodes = np.arange(grid.n_theta_d, dtype=np.float64)
        light, detector = (
            np.interp(np.arccos(np.clip(cosine, 0.0, 1.0)).ravel(), grid.theta_d, nodes)
            for cosine in cosines
        )
        return cls(light, detector)

    def sum_of(self, multipliers: FloatArray, rows: IntArray | slice) -> FloatArray:
        """Return lambda(theta_i) + lambda(theta_o) of the cells `rows`."""
        nodes = np.arange(multipliers.size)
        at_light = np.interp(self.light[rows], nodes, multipliers)
        return np.asarray(at_light + np.interp(self.detector[rows], nodes, multipliers))


@dataclass(frozen=True, eq=False)
class _Projection:
    """One channel: f of all cells, s, and by how many s a value may give way."""

    plan: AlbedoPlan
    seats: _Seats
    f: FloatArray
    s: FloatArray
    most: float
    limit: float
    within_reach: BoolArray | None = None
    """Incidences that are to respect the limit; None: all of them."""

    def solve(self) -> FloatArray:
        """Return the factor of every cell, (cells of the grid,)."""
        cells, target = self.plan.cells, self.limit * (1.0 - _TOLERANCE)
        f, s2 = self.f[cells], self.s[cells] ** 2
        multipliers = np.zeros(self.plan.grid.n_theta_d)
        for _ in range(_ITERATIONS):
            given = self._gives_way(multipliers, cells)
            scaled = f * np.exp(-given)
            everywhere = np.maximum(self.plan.albedo(scaled), _TINY)
            if self.within_reach is not None:
                everywhere = np.where(self.within_reach, everywhere, _TINY)
            worst = _worst_around_nodes(everywhere)
            albedo = everywhere[worst]
            # d ln(albedo) / d lambda = -(mean of s^2, weighted by what each cell reflects)
            free = s2 if self.most == np.inf else s2 * (given < self.most * self.s[cells])
            slope = self.plan.albedo(scaled * free)[worst] / albedo
            movable = (slope > _TINY) & (albedo > _TINY)
            step = np.where(movable, np.log(albedo / target) / np.where(movable, slope, 1.0), 0.0)
            better = np.maximum(0.0, multipliers + _STEP * step)
            if np.abs((better - multipliers) * slope).max() < _TOLERANCE * _STEP:
                break
            multipliers = better
        return np.asarray(np.exp(-self._gives_way(multipliers, slice(None))))

    def _gives_way(self, multipliers: FloatArray, rows: IntArray | slice) -> FloatArray:
        s = self.s[rows]
        wanted = s * s * self.seats.sum_of(multipliers, rows)
        return wanted if self.most == np.inf else np.minimum(wanted, self.most * s)


def _worst_around_nodes(albedo: FloatArray) -> IntArray:
    """Return where the largest albedo within half a step of each node is, (n_theta_d,)."""
    at = np.arange(0, albedo.size, 2)[:, None] + np.array([0, -1, 1])
    at[0, 1] = 0
    return np.asarray(at[np.arange(len(at)), np.argmax(albedo[at], axis=1)])


def _spread(table: Table, stddev: npt.ArrayLike | None) -> FloatArray | None:
    if stddev is None:
        return None
    spread = np.asarray(stddev, dtype=np.float64)
    shapes = (table.grid.shape, (*table.grid.shape, 1), table.values.shape)
    if spread.shape not in shapes:
        raise UsageError(
            f"stddev: found shape {spread.shape} but the table wants {table.grid.shape} or "
            f"{table.values.shape}."
        )
    spread = spread.reshape(table.grid.size, -1)
    seen = spread[table.mask.reshape(-1)]
    if not (np.isfinite(seen).all() and (seen >= 0.0).all()):
        raise UsageError(
            "stddev: found a value that is negative or not finite in a valid cell of the table; "
            "it is the standard deviation of ln f_r, 0 for a value that must stay."
        )
    return np.nan_to_num(spread)
