"""A fit's table held to what a surface can reflect, where nobody measured.

Beyond the measurements a population, or a method's own extrapolation, supplies the values, and
nothing keeps their directional albedo below 1. `limit_albedo` finds the nearest table that
respects the limit (`physics.limit_energy`: f' = f exp(-s^2 (lambda(theta_i) + lambda(theta_o)))
with lambda >= 0), s saying how freely a cell gives way:

    measured cells (`TrustMap`)     s = 0: not by a bit
    all others                      s = the stated standard deviation of ln f_r, or, of a method
                                    that states none, a value that grows with the distance to
                                    the nearest believed sample, from 0 to 0.5

So the least certain cells carry the change. s and the lambdas are the same for a pair of
directions and its reciprocal, factors are above zero: reciprocity and positivity stay. Where the
measured cells alone exceed the limit it cannot be kept; what is left over is counted.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from brdfit.arrays import BoolArray, FloatArray, IntArray, frozen
from brdfit.grid import Grid
from brdfit.physics import AlbedoPlan, limit_energy
from brdfit.physics.energy import EnergyLimit, limited_incidences
from brdfit.progress import Progress, silent
from brdfit.reconstruct.doubt import Doubt, stated_doubt
from brdfit.reconstruct.reach import FAR, NEAR, Reach
from brdfit.reconstruct.trust import Trust, TrustMap
from brdfit.table import Table

if TYPE_CHECKING:
    from brdfit.reconstruct.result import Reconstruction

__all__ = ["LimitedAlbedo", "limit_albedo"]

# s of a cell that the method supplies without saying how sure it is: a factor of 1.65.
_SUPPLIED = 0.5
_CHANGED = 0.999


@dataclass(frozen=True, eq=False)
class LimitedAlbedo:
    """The limited table, and at whose cost.

    | name      | shape   | meaning                                                   |
    |-----------|---------|-----------------------------------------------------------|
    | `classes` | of grid | `Trust` of each cell, 0 below the horizon; None where the |
    |           |         | limit was respected and nobody had to give way            |
    | `lowered` | of grid | which cells were lowered by more than 0.1 %               |
    | `held`    | (a, c)  | albedo of the measured cells alone, the others black      |
    """

    energy: EnergyLimit
    """The table, and the albedos before and after at every node of theta_d and halfway between."""
    classes: IntArray | None
    lowered: BoolArray
    held: FloatArray

    @property
    def table(self) -> Table:
        """The table; the given one itself where it respected the limit."""
        return self.energy.table

    @property
    def reached(self) -> bool:
        """Whether no incidence reflects more than the limit now."""
        return self.energy.excess == 0.0

    @property
    def sentence(self) -> str:
        """What happened, in words."""
        energy = self.energy
        before, after = float(energy.before.max()), float(energy.after.max())
        if self.classes is None:
            return f"no incidence reflects more than {energy.limit:g} (at most {before:.3f})"
        text = (
            f"{energy.changed:,} cells that nobody measured were lowered, the most to "
            f"{100 * energy.strongest:.2g}% of its value: the largest directional albedo was "
            f"{before:.3f} and is {after:.3f}"
        )
        if self.reached:
            return text
        over = np.degrees(energy.theta_i[(energy.after > energy.limit).any(axis=1)])
        alone = float(self.held.max())
        return (
            f"{text}; above {energy.limit:g} still at {over.size} of {energy.theta_i.size} "
            f"incidences, {over.min():.0f} to {over.max():.0f} degrees: measured cells are not "
            f"moved and reflect {alone:.3f} by themselves; `brdfit repair` limits them too, or "
            f"look at the scale of the measurements"
        )

    def record(self) -> dict[str, Any]:
        """Return the figures as JSON-able values."""
        energy, classes = self.energy, self.classes
        counts = {
            trust.name.lower(): 0 if classes is None else int(self.lowered[classes == trust].sum())
            for trust in (Trust.MEASURED, Trust.INTERPOLATED, Trust.SUPPLIED)
        }
        return {
            "limit": energy.limit,
            "reached": self.reached,
            "largest_before": float(energy.before.max()),
            "largest_after": float(energy.after.max()),
            "incidences_above_before": int((energy.before > energy.limit).any(axis=1).sum()),
            "incidences_above_after": int((energy.after > energy.limit).any(axis=1).sum()),
            "incidences": int(energy.theta_i.size),
            "largest_of_measured_cells_alone": (
                None if classes is None else float(self.held.max())
            ),
            "cells_lowered": counts,
            "smallest_factor": energy.strongest,
            "sentence": self.sentence,
        }


def limit_albedo(
    result: Reconstruction, table: Table, *, limit: float = 1.0, progress: Progress = silent
) -> LimitedAlbedo:
    """Return `table`, the dense form of `result`, with directional albedos of at most `limit`.

    Measured cells are not moved. A table that respects the limit is returned as it is, to the
    bit. Raises `UsageError` for a limit that is not above 0.
    """
    plan = AlbedoPlan.build(table.grid, table.mask, limited_incidences(table.grid))
    before = plan.of(table)
    if limit > 0.0 and before.max() <= limit:
        asked = EnergyLimit(table, limit, plan.theta_i, frozen(before), frozen(before), 0, 1.0)
        nobody = np.zeros(table.grid.shape, dtype=bool)
        return LimitedAlbedo(asked, None, nobody, frozen(before))
    classes, freedom = _freedom(result, table.grid, progress)
    energy = limit_energy(table, freedom, limit=limit)
    lowered = np.asarray((energy.table.values < _CHANGED * table.values).any(axis=3))
    stay = table.values * (classes == Trust.MEASURED)[..., None]
    held = frozen(plan.of(replace(table, values=stay)))
    found = LimitedAlbedo(energy, classes, lowered, held)
    source = replace(table.source, notes=(*table.source.notes, f"albedo: {found.sentence}"))
    noted = replace(energy.table, source=source)
    return replace(found, energy=replace(energy, table=noted))


def _freedom(result: Reconstruction, grid: Grid, progress: Progress) -> tuple[IntArray, FloatArray]:
    """Return the classes, shaped as the grid, and s, (*grid.shape, 1 or channels)."""
    stated = stated_doubt(result, progress)
    reach = result.trust_map.reach
    trust = TrustMap(reach, Doubt.of(result.model, stated) or result.model)
    classes = trust.on_grid(grid)
    wi_wo = grid.directions(grid.cells)
    at_cells = _by_distance(reach, grid) if stated is None else stated.evaluate(*wi_wo)
    free = np.zeros((grid.size, at_cells.shape[1]))
    free[grid.cells] = at_cells
    free[classes.reshape(-1) == Trust.MEASURED] = 0.0
    return classes, free.reshape(*grid.shape, -1)


def _by_distance(reach: Reach, grid: Grid) -> FloatArray:
    degrees = reach.degrees(*grid.half_diff(grid.cells))
    share = np.clip((degrees - NEAR) / (FAR - NEAR), 0.0, 1.0)
    return np.asarray(_SUPPLIED * share[:, None])
