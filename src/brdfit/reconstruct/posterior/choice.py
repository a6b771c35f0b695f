"""Which kernel the residual has: the one under which left-out samples are most likely.

Few are tried, a few steps each and on some of the samples: shapes first, then amplitudes and
what counts as distance beside the angles (`kernel`).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from itertools import chain

from brdfit.reconstruct.posterior.kernel import Kernel
from brdfit.reconstruct.posterior.measurements import Measurements
from brdfit.reconstruct.posterior.prior import PopulationPrior
from brdfit.reconstruct.posterior.refine import Belief
from brdfit.reconstruct.posterior.search import Design, Search
from brdfit.reconstruct.posterior.section import Section
from brdfit.reconstruct.posterior.systems import Whole
from brdfit.reconstruct.posterior.winner import at_rest, merit, whole

__all__ = ["best_kernel"]


@dataclass(frozen=True, eq=False)
class _Trial:
    """What kernels are compared on, and how long each is tried."""

    data: Measurements
    design: Design
    belief: Belief
    whole: Whole
    steps: int

    @classmethod
    def of(
        cls,
        data: Measurements,
        design: Design,
        prior: PopulationPrior,
        belief: Belief,
        search: Search,
    ) -> _Trial:
        """Return the trial on these samples, of some of the channels."""
        system = whole(design, prior, Kernel(1.0, 1.0, 1.0))
        data = data.channels(search.screening_channels)
        return cls(data, design, belief, system, search.screening_steps)

    def tried(self, kernel: Kernel) -> tuple[float, Kernel]:
        """Return (the merit of a kernel, the kernel)."""
        system = replace(self.whole, kernel=kernel)
        return merit(at_rest(self.data, self.design, system, self.belief, self.steps)), kernel

    def best(self, kernels: Iterable[Kernel], search: Search) -> tuple[float, Kernel]:
        """Return (merit, kernel) of the best of `kernels`, at the best amplitude."""
        best = max(map(self.tried, kernels), key=_by_merit)
        amplitudes = (self.tried(replace(best[1], amplitude=a)) for a in search.amplitudes[1:])
        best = max(chain([best], amplitudes), key=_by_merit)
        return max(best, self.tried(replace(best[1], grazing=search.grazing)), key=_by_merit)


def _by_merit(found: tuple[float, Kernel]) -> float:
    return found[0]


def best_kernel(
    data: Measurements,
    design: Design,
    prior: PopulationPrior,
    belief: Belief,
    section: Section | None,
    search: Search,
) -> Kernel:
    """Return the kernel under which left-out samples are most likely, after a few steps.

    One that follows the lobe has to be worth it.
    """
    some = data.spread_out(search.screening_rows)
    trial = _Trial.of(data.take(some), design.take(some), prior, belief.take(some), search)
    amplitude = search.amplitudes[0]
    plain = trial.best(
        (Kernel(*shape, amplitude, section=section) for shape in search.shapes), search
    )
    if section is None:
        return plain[1]
    following = trial.best(
        (
            Kernel(*shape, amplitude, lobe=search.lobe, section=section)
            for shape in search.following
        ),
        search,
    )
    return (following if following[0] > plain[0] + search.worth * trial.belief.count else plain)[1]
