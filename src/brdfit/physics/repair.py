"""What can be put right in measurements or a table, each change counted and named.

A repair never hides what it did: `Repair.changes` says what was changed, how many values and by
how much, and the same sentences stand in the notes of the source of what comes out.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from brdfit.arrays import BoolArray, IntArray
from brdfit.geometry import cos_incident_outgoing
from brdfit.physics.energy import limit_energy
from brdfit.physics.filling import filled
from brdfit.physics.neighbourhood import Neighbourhood
from brdfit.physics.verdicts import GRAZING
from brdfit.samples import Samples
from brdfit.table import Table

__all__ = ["Change", "Repair", "repair_samples", "repair_table"]

# Doubt in ln f that decides what gives way to the energy limit: invented or grazing, and measured.
_DOUBTFUL, _RELIABLE = 0.3, 0.05
_PAIR = np.radians(0.25)


@dataclass(frozen=True)
class Change:
    """One thing that was put right, or looked at and left."""

    name: str
    count: int
    """Cells or samples that were changed; 0 if nothing had to be."""
    sentence: str
    figures: dict[str, Any]

    def record(self) -> dict[str, Any]:
        """Return everything as JSON-able values."""
        return {
            "name": self.name,
            "count": self.count,
            "sentence": self.sentence,
            "figures": self.figures,
        }


@dataclass(frozen=True)
class Repair:
    """What came out, and the changes in the order in which they were made."""

    content: Samples | Table
    changes: tuple[Change, ...]

    @property
    def changed(self) -> int:
        """How many changes had anything to do."""
        return sum(change.count > 0 for change in self.changes)

    def record(self) -> dict[str, Any]:
        """Return the changes as JSON-able values."""
        return {"changes": [change.record() for change in self.changes]}


def repair_table(
    table: Table, *, fill: bool = True, symmetrize: bool = False, limit: float = 1.0
) -> Repair:
    """Return `table` with what can be put right put right.

    Negative values, in their channel only, and cells that hold nothing are filled from their
    neighbours; if `fill` is false, cells with a negative value hold nothing afterwards, since a
    table knows no holes in a channel. phi_d and -phi_d are averaged if `symmetrize` says so;
    values give way until no incidence reflects more than `limit`, first those that were filled
    in and those beyond 75 degrees, then, if that is not enough, all alike.
    """
    negative = table.mask[..., None] & (table.values < 0.0)
    measured = table.mask & ~negative.any(axis=3)
    changes = [_negative(table, negative, fill)]
    if not fill and negative.any():
        table = replace(table, valid=measured)
    if fill:
        table, change = _filled(table, negative)
        changes.append(change)
    if symmetrize:
        table, change = _symmetrized(table)
        changes.append(change)
    table, change = _limited(table, measured, limit)
    changes.append(change)
    return Repair(_noted(table, changes), tuple(changes))


def repair_samples(samples: Samples) -> Repair:
    """Return `samples` with the values of exchanged directions averaged.

    Pairs whose directions are each other's exchange within 0.25 degrees get the mean of both in
    every channel that is usable in both. What cannot be used stays in its row, flagged.
    """
    near = Neighbourhood.of(samples)
    pairs = near.rows[_disjoint(near.swapped_pairs(_PAIR))]
    value = np.array(samples.value)
    both = samples.usable[pairs[0]] & samples.usable[pairs[1]]
    first, second = value[pairs[0]], value[pairs[1]]
    mean = 0.5 * (first + second)
    value[pairs[0]] = np.where(both, mean, first)
    value[pairs[1]] = np.where(both, mean, second)
    with np.errstate(divide="ignore", invalid="ignore"):
        apart = np.abs(first - second) / mean
    most = float(np.max(apart[both & (mean > 0.0)], initial=0.0))
    count = int((both & (first != second)).any(axis=1).sum())
    sentence = (
        f"{count:,} pairs of samples with light and detector exchanged got the mean of both "
        f"(they were apart by at most {most:.1%} of it)"
        if count
        else "no samples have light and detector exchanged and differ: nothing was averaged"
    )
    change = Change("reciprocity", count, sentence, {"pairs": count, "largest_difference": most})
    repaired = samples.with_value(value) if count else samples
    return Repair(_noted(repaired, [change]), (change,))


def _disjoint(pairs: IntArray) -> IntArray:
    """Return those of `pairs` (2, n) that share no member with one before them."""
    taken: set[int] = set()
    keep = []
    for number, pair in enumerate(pairs.T.tolist()):
        if taken.isdisjoint(pair):
            taken.update(pair)
            keep.append(number)
    return pairs[:, keep]


def _negative(table: Table, negative: BoolArray, fill: bool) -> Change:
    cells = int(negative.any(axis=3).sum())
    if not cells:
        return Change("negative", 0, "no cell holds a negative value", {"lowest": 0.0})
    lowest = float(table.values[negative].min())
    told = "those values, but not their other channels," if fill else "those cells"
    sentence = (
        f"{cells:,} cells hold a negative value in some channel, down to {lowest:.3g} 1/sr: {told} "
        f"were taken for missing"
    )
    return Change("negative", cells, sentence, {"lowest": lowest, "values": int(negative.sum())})


def _filled(table: Table, negative: BoolArray) -> tuple[Table, Change]:
    lost = table.grid.above_horizon & (~table.mask | negative.any(axis=3))
    count = int(lost.sum())
    good = table.mask[..., None] & ~negative
    if count == 0 or not good.any():
        why = "no cell was missing" if count == 0 else "no cell holds a value to fill from"
        return table, Change("fill", 0, f"{why}: nothing was filled", {})
    share = float(table.grid.solid_angle[lost].sum())
    sentence = (
        f"{count:,} cells ({share:.1%} of the domain) were filled from their neighbours: nobody "
        f"measured them"
    )
    partly = count - table.missing
    if partly:
        sentence += f"; {partly:,} of them in the negative channels only"
    empty = [n for c, n in enumerate(table.channels) if not good[..., c].any()]
    if empty:
        sentence += f"; {', '.join(empty)} holds no value to fill from and stays as it is"
    figures = {"share": share, "missing": table.missing, "empty_channels": empty}
    return filled(table, negative), Change("fill", count, sentence, figures)


def _symmetrized(table: Table) -> tuple[Table, Change]:
    opposite = (-np.arange(table.grid.n_phi_d)) % table.grid.n_phi_d
    mirrored, both = table.values[:, :, opposite], table.mask & table.mask[:, :, opposite]
    mean = np.where(both[..., None], 0.5 * (table.values + mirrored), table.values)
    moved = both & (table.values != mirrored).any(axis=3)
    with np.errstate(divide="ignore", invalid="ignore"):
        apart = np.abs(table.values - mirrored)[moved] / (2.0 * mean[moved])
    most = float(np.nanmax(apart, initial=0.0))
    count = int(moved.sum())
    sentence = f"{count:,} cells got the mean of phi_d and -phi_d (at most {most:.1%} away from it)"
    change = Change("symmetry", count, sentence, {"largest_difference": most})
    return replace(table, values=mean.astype(table.values.dtype)), change


def _limited(table: Table, measured: BoolArray, limit: float) -> tuple[Table, Change]:
    doubt = np.where(measured & ~_grazing(table), _RELIABLE, _DOUBTFUL)
    result = limit_energy(table, doubt, limit=limit)
    before, after = float(result.before.max()), float(result.after.max())
    figures = {"albedo_before": before, "albedo_after": after, "smallest_factor": result.strongest}
    if result.changed == 0:
        sentence = f"no incidence reflects more than {limit:g} (at most {before:.3f})"
        return table, Change("energy", 0, sentence, figures)
    lowered = (result.table.values < 0.999 * table.values).any(axis=3)
    reliable = int((lowered & (doubt == _RELIABLE)).sum())
    sentence = (
        f"{result.changed:,} cells were lowered, the most to {result.strongest:.0%} of its value, "
        f"so that the largest directional albedo is {after:.3f} where it was {before:.3f}; "
        f"{reliable:,} of them were measured, within {GRAZING:g} degrees"
    )
    return result.table, Change(
        "energy", result.changed, sentence, figures | {"reliable": reliable}
    )


def _grazing(table: Table) -> BoolArray:
    grid = table.grid
    cosines = cos_incident_outgoing(
        grid.theta_h[:, None, None], grid.theta_d[None, :, None], grid.phi_d[None, None, :]
    )
    return np.asarray(np.minimum(*cosines) < np.cos(np.radians(GRAZING)))


def _noted(content: Any, changes: list[Change]) -> Any:
    said = tuple(f"repair: {change.sentence}" for change in changes if change.count)
    if not said:
        return content
    source = replace(content.source, notes=(*content.source.notes, *said))
    return replace(content, source=source)
