"""Everything that all cases of the poster's tables share: cells, columns, pictures.

The *universe* is a stratified subset of the grid's cells: the measurements of data ratio 1.
Behind it, where the tables of few samples are made, lie their draws of random cells.
The *target* is the set of directions that the sphere of the perceptual error asks for: nothing
else of a reconstruction is ever seen, so nothing else is computed. The columns of the
population, ln f_r of every member, are worked out once at both.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from brdfit.arrays import FloatArray, IntArray, frozen
from brdfit.bench.outliers import Contaminated, contaminate
from brdfit.bench.paper.settings import PaperSettings
from brdfit.bench.real_files import generator
from brdfit.geometry import cos_incident_outgoing
from brdfit.grid import Grid
from brdfit.progress import Progress
from brdfit.render import SphereView

if TYPE_CHECKING:
    from brdfit.populations import Population

__all__ = ["Scene", "stratified"]

_CHUNK = 8192


def stratified(grid: Grid, count: int, rng: np.random.Generator) -> IntArray:
    """Return `count` cells above the horizon (flat, ascending), one from each of as many strata.

    The cells are put in an order in which neighbours in (theta_h, theta_d, phi_d) stay
    together, and cut into `count` runs of equal length; one cell is drawn from each run.
    """
    cells = grid.cells
    i, j, k = np.unravel_index(cells, grid.shape)
    # Blocks of 2 x 2 x 5 cells; within a row of blocks theta_d and phi_d go back and forth.
    row = i // 2
    column = np.where(row % 2, -(j // 2), j // 2)
    stack = np.where((row + column) % 2, -(k // 5), k // 5)
    order = cells[np.lexsort((k, j, i, stack, column, row))]
    edges = np.linspace(0, len(order), count + 1).astype(np.int64)
    chosen = edges[:-1] + np.floor(rng.random(count) * np.diff(edges)).astype(np.int64)
    return np.sort(order[chosen])


@dataclass(frozen=True, eq=False)
class Scene:
    """The shared arrays of a run.

    | name        | shape                 | meaning                                        |
    |-------------|-----------------------|------------------------------------------------|
    | `universe`  | (n + d,)              | flat cells that are measurements, the draws of |
    |             |                       | few samples behind them                        |
    | `target`    | (m, 3) twice          | directions (wi, wo) that the sphere asks for   |
    | `at_universe` | (channels, n + d, members) | ln f_r there, float32                   |
    | `at_target` | (channels, m, members) | ln f_r there, float32                         |
    | `materials` | (members,)            | number of the material of each member          |
    | `subjects`  | (s,)                  | members that are reconstructed, one a material |
    | `order`     | (n,)                  | the universe shuffled                          |
    | `draws`     | by (samples, draw)    | rows of a draw of few samples                  |

    The data of ratio r are the first r n rows of the shuffled universe.
    """

    settings: PaperSettings
    names: tuple[str, ...]
    view: SphereView
    universe: IntArray
    at_universe: FloatArray
    at_target: FloatArray
    materials: IntArray
    subjects: IntArray
    order: IntArray
    draws: Mapping[tuple[int, int], IntArray]

    @classmethod
    def build(cls, settings: PaperSettings, population: Population, progress: Progress) -> Scene:
        """Return the scene; the population's columns are the work."""
        from brdfit.render import Sphere, studio

        grid = settings.grid
        view = SphereView.build(Sphere(settings.image_size), studio())
        target = view.queries.wi, view.queries.wo
        count = max(1, round(settings.universe * grid.cells.size))
        universe = stratified(grid, count, generator(settings.seed, "universe"))
        draws, universe = _with_draws(settings, universe)
        material = np.unique(np.array(population.materials), return_inverse=True)[1]
        return cls(
            settings=settings,
            names=population.members,
            view=view,
            universe=frozen(universe),
            at_universe=_columns(
                population, *grid.directions(universe), progress, "columns of the samples"
            ),
            at_target=_columns(population, *target, progress, "columns of the sphere"),
            materials=frozen(np.ravel(material)),
            subjects=frozen(cls.subjects_of(settings, population)),
            order=frozen(generator(settings.seed, "order").permutation(count)),
            draws=draws,
        )

    @staticmethod
    def subjects_of(settings: PaperSettings, population: Population) -> list[int]:
        """Return the members that are reconstructed: the first of each material, or a few."""
        first = np.sort(np.unique(np.array(population.materials), return_index=True)[1])
        count = settings.materials
        if 0 < count < first.size:
            first = first[np.linspace(0, first.size - 1, count).round().astype(np.int64)]
        return [int(member) for member in first]

    @property
    def target(self) -> tuple[FloatArray, FloatArray]:
        """(wi, wo), (m, 3) each: the directions that the sphere asks for."""
        return self.view.queries.wi, self.view.queries.wo

    @property
    def n_channels(self) -> int:
        """Number of channels."""
        return int(self.at_universe.shape[0])

    def rows(self, data_ratio: float) -> IntArray:
        """Return the rows of the universe that are the data of this ratio, ascending."""
        return np.sort(self.order[: max(1, round(data_ratio * self.order.size))])

    def directions(self, rows: IntArray) -> tuple[FloatArray, FloatArray]:
        """Return (wi, wo), (rows, 3) each, of rows of the universe."""
        return self.settings.grid.directions(self.universe[rows])

    def others(self, subject: int) -> IntArray:
        """Return the members that a reconstruction of `subject` may lean on."""
        return np.flatnonzero(self.materials != self.materials[subject])

    def values(self, subject: int, rows: IntArray) -> FloatArray:
        """Return f_r (rows, channels) of a member at rows of the universe: its measurements."""
        return np.exp(self.at_universe[:, rows, subject].T.astype(np.float64))

    def reference(self, subject: int) -> FloatArray:
        """Return f_r (m, channels) of a member at the target."""
        return np.exp(self.at_target[:, :, subject].T.astype(np.float64))

    def measured(
        self, subject: int, rows: IntArray, data_ratio: float, outlier_ratio: float
    ) -> Contaminated:
        """Return the measurements of a member at rows of the universe, outliers among them.

        The same outliers whatever the method: they depend on the seed, the material and
        the two ratios.
        """
        key = (self.names[subject], f"d{data_ratio:g}", f"o{outlier_ratio:g}")
        rng = generator(self.settings.seed, "outliers", *key)
        return self._spoilt(self.settings.outliers, subject, rows, outlier_ratio, rng)

    def draw_of(self, subject: int, count: int) -> int:
        """Return which draw of `count` samples a member has."""
        return int(self.materials[subject]) % self.settings.draws_of(count)

    def few(self, subject: int, rows: IntArray, model: str, outlier_ratio: float) -> Contaminated:
        """Return the measurements of a member at the rows of a draw, outliers among them."""
        key = (self.names[subject], f"n{rows.size}", model, f"o{outlier_ratio:g}")
        rng = generator(self.settings.seed, "few", *key)
        return self._spoilt(model, subject, rows, outlier_ratio, rng)

    def _spoilt(
        self, model: str, subject: int, rows: IntArray, ratio: float, rng: np.random.Generator
    ) -> Contaminated:
        return contaminate(model, self.values(subject, rows), ratio, rng, self.theta_i[rows])

    @cached_property
    def theta_i(self) -> FloatArray:
        """(n + d,) incidence angles of the universe, radians."""
        cos_i, _ = cos_incident_outgoing(*self.settings.grid.half_diff(self.universe))
        return np.arccos(np.clip(cos_i, -1.0, 1.0))

    def perceptual_error(self, subject: int, values: FloatArray) -> float:
        """Return the perceptual error of f_r (m, channels) at the target against the member."""
        from brdfit.metrics import perceptual_error

        images = [self.view.disk(one)[:, None, :] for one in (self.reference(subject), values)]
        return perceptual_error(images[0], images[1])


def _with_draws(
    settings: PaperSettings, universe: IntArray
) -> tuple[dict[tuple[int, int], IntArray], IntArray]:
    """Return (rows of every draw, the universe with the cells of the draws behind it)."""
    if "few" not in settings.parts:
        return {}, universe
    draws: dict[tuple[int, int], IntArray] = {}
    cells, start = [universe], universe.size
    for count in sorted({count for count, _ in settings.few}):
        for draw in range(settings.draws_of(count)):
            rng = generator(settings.seed, "draw", str(count), str(draw))
            cells.append(np.sort(rng.choice(settings.grid.cells, count, replace=False)))
            draws[count, draw] = np.arange(start, start + count)
            start += count
    return draws, np.concatenate(cells)


def _columns(
    population: Population, wi: FloatArray, wo: FloatArray, progress: Progress, label: str
) -> FloatArray:
    columns = np.empty((len(population.channels), len(wi), len(population)), dtype=np.float32)
    progress(label, 0, len(wi))
    for start in range(0, len(wi), _CHUNK):
        block = slice(start, start + _CHUNK)
        columns[:, block] = np.moveaxis(population.log_values(wi[block], wo[block]), 2, 0)
        progress(label, min(start + _CHUNK, len(wi)), len(wi))
    columns.flags.writeable = False
    return columns
