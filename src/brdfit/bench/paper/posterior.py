"""`Posterior` as a column of the tables: the method itself, its components worked out once.

Nothing of the method is written again here. Its basis belongs to the whole population and
which members may be leaned on is a matter of weights, so that one evaluation of the components
at the scene's directions serves every material.
"""

from __future__ import annotations

import time
from collections.abc import Hashable
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from brdfit.arrays import FloatArray, IntArray
from brdfit.bench.paper.contender import Answer, Case
from brdfit.bench.paper.scene import Scene
from brdfit.populations import population
from brdfit.reconstruct.members import MemberRows
from brdfit.reconstruct.posterior import Posterior
from brdfit.reconstruct.posterior.principal import PrincipalBasis, principal_basis
from brdfit.reconstruct.result import settings_record
from brdfit.samples import Samples

if TYPE_CHECKING:
    from brdfit.populations import Population

__all__ = ["KnownComponents", "Process"]

# Odd numbers without a pattern: the bits of six coordinates make one number.
_MIX = np.random.default_rng(7).integers(2**62, size=6, dtype=np.uint64) * np.uint64(2) + np.uint64(
    1
)


@dataclass(frozen=True, eq=False)
class KnownComponents(PrincipalBasis):
    """A basis that looks up directions at which its components are known.

    `wi`, `wo` (n, 3) and `components` (n, 1 + q); asked for any other direction, it asks the
    members, as every basis does.
    """

    wi: FloatArray
    wo: FloatArray
    components: FloatArray

    @classmethod
    def of(cls, basis: PrincipalBasis, scene: Scene) -> KnownComponents:
        """Work the components out at the universe and at the target of a scene."""
        everywhere = np.arange(scene.universe.size)
        places = [scene.directions(everywhere), scene.target]
        parts = [
            basis.of_members(MemberRows(tuple(logs)))
            for logs in (scene.at_universe, scene.at_target)
        ]
        wi, wo = (np.concatenate(one) for one in zip(*places, strict=True))
        found = cls(basis.population, basis.axes, basis.blends, wi, wo, np.concatenate(parts))
        _ = found._order  # sorted here once, not in every worker
        return found

    def at(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        """Return [mu | B] (n, 1 + q), float32, at directions (n, 3) above the horizon."""
        keys, order = self._order
        place = np.minimum(np.searchsorted(keys, _key(wi, wo)), keys.size - 1)
        row = order[place]
        same = (self.wi[row] == wi).all(axis=1) & (self.wo[row] == wo).all(axis=1)
        if not same.all():
            return super().at(wi, wo)
        return self.components[row]

    @cached_property
    def _order(self) -> tuple[FloatArray, IntArray]:
        key = _key(self.wi, self.wo)
        order = np.argsort(key, kind="stable")
        return key[order], order


def _key(wi: FloatArray, wo: FloatArray) -> FloatArray:
    bits = np.ascontiguousarray(np.hstack([wi, wo]) + 0.0).view(np.uint64)
    return np.asarray((bits * _MIX).sum(axis=1, dtype=np.uint64))


@dataclass(eq=False)
class Process:
    """The posterior. All cases share its components."""

    method: Posterior
    title: str = "Post"
    cost: int = 300
    _known: dict[int, KnownComponents] = field(default_factory=dict, repr=False)

    @property
    def metric(self) -> str | None:
        """It works on the logarithm, and has no choice."""
        return None

    def record(self) -> dict[str, Any]:
        """Return the settings as JSON-able values."""
        found = settings_record(self.method)
        return {key: value for key, value in found.items() if key != "population"}

    def share(self, case: Case) -> Hashable:
        """All cases share what is prepared."""
        return None

    def prepare(self, scene: Scene, case: Case) -> KnownComponents:
        """Return the components at every direction of the scene."""
        if id(scene) not in self._known:
            basis = principal_basis(population(self.method.population))
            self._known[id(scene)] = KnownComponents.of(basis, scene)
        return self._known[id(scene)]

    def reconstruct(
        self, scene: Scene, prepared: KnownComponents, case: Case, values: FloatArray
    ) -> Answer:
        """Return f_r (m, channels) at the target, and who was named."""
        others = self._others(scene, case.subject)
        wi, wo = scene.directions(case.rows)
        samples = Samples(wi=wi, wo=wo, value=values, channels=others.channels)
        start = time.perf_counter()
        result = replace(self.method, population=others).fit_on(samples, others, prepared)
        seconds = time.perf_counter() - start
        return Answer(
            values=result.evaluate(*scene.target),
            named=result.outliers,
            noise=result.history[-1]["noise"],
            seconds=seconds,
        )

    def _others(self, scene: Scene, subject: int) -> Population:
        every = population(self.method.population)
        return every.without([every.materials[subject]])
