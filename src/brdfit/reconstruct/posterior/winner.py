"""An explanation with the system that it solves: what it says at any direction."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from brdfit.arrays import FloatArray
from brdfit.reconstruct.posterior.kernel import Angles, Kernel
from brdfit.reconstruct.posterior.measurements import Measurements
from brdfit.reconstruct.posterior.prior import PopulationPrior
from brdfit.reconstruct.posterior.refine import Belief, Explanation, refine
from brdfit.reconstruct.posterior.search import Design
from brdfit.reconstruct.posterior.systems import Solution, System, Whole

__all__ = ["Winner", "at_rest", "merit", "whole"]

DEPARTURE = 5.0
"""Price in ln likelihood of an e-fold of residual amplitude: it decides where samples are few."""


@dataclass(frozen=True, eq=False)
class Winner:
    """The explanation that was kept, and the system that it solves."""

    system: System
    solution: Solution
    explanation: Explanation

    @classmethod
    def of(cls, system: System, explanation: Explanation) -> Winner:
        """Return the winner whose explanation solves `system`."""
        return cls(system, system.solution(explanation.coefficients), explanation)

    def mean(self, components: FloatArray, angles: Angles) -> FloatArray:
        """Return ln f_r (n, c) at [mu | B] (n, 1 + q) and angles."""
        combination, constant = self.system.prior.combination(self.solution.population)
        of_population = components.astype(np.float64) @ combination + constant
        local = self.system.kernel.between(angles, self.system.centres) @ self.solution.local
        return np.asarray(of_population + local)

    def variance(self, components: FloatArray, angles: Angles) -> FloatArray:
        """Return that of ln f_r (n,)."""
        features = self.system.prior.features(components)
        return self.system.variance(self.explanation.posterior, features, angles)

    def prior_variance(self, components: FloatArray) -> FloatArray:
        """Return that of ln f_r before any sample, the brightness known, (n,)."""
        features = self.system.prior.features(components)[:, :-1]
        return np.asarray((features**2).sum(axis=1) + self.system.kernel.amplitude**2)

    def judge(self, data: Measurements, design: Design) -> Belief:
        """Return what the solution makes of other samples than it was fitted to."""
        belief = self.explanation.belief
        mean = self.mean(design.components, design.angles)
        spread = self.variance(design.components, design.angles)
        spread += belief.width**2 * belief.unevenness.factor(data.places) + data.scatter
        verdict = belief.mixture.judge(data.y, mean, spread, data.informative(mean))
        return replace(belief, responsibility=verdict.responsibility, credit=verdict.credit)


def at_rest(
    data: Measurements,
    design: Design,
    system: System,
    belief: Belief,
    steps: int,
    patience: int = 1,
) -> Winner:
    """Return the explanation that `belief` leads to, after so many steps or `patience` times."""
    base = system.prior.log_mean(design.components)
    found = refine(data, base, system.weighted, belief, steps, patience * steps)
    return Winner.of(system, found)


def whole(design: Design, prior: PopulationPrior, kernel: Kernel) -> Whole:
    """Return the system in which every row is a centre."""
    features = prior.features(design.components)
    return Whole(prior, kernel, features, design.angles, features @ features.T)


def merit(winner: Winner) -> float:
    """Left-out likelihood, less what a material pays for leaving its population."""
    price = DEPARTURE * float(np.log(winner.system.kernel.amplitude))
    return winner.explanation.score - price
