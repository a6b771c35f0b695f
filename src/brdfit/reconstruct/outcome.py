"""How a fit ended: a named outcome whose text is the advice."""

from __future__ import annotations

import enum

__all__ = ["Outcome"]


class Outcome(enum.Enum):
    """How a fit ended. `value` is the name in files; `advice` says what it means."""

    CONVERGED = "converged"
    NO_IMPROVEMENT = "no_improvement"
    ITERATION_LIMIT = "iteration_limit"
    DIRECT = "direct"
    TOO_FEW_SAMPLES = "too_few_samples"
    MOSTLY_OUTLIERS = "mostly_outliers"

    @property
    def ok(self) -> bool:
        """True if nothing about the ending calls for attention."""
        return self in (Outcome.CONVERGED, Outcome.NO_IMPROVEMENT, Outcome.DIRECT)

    @property
    def advice(self) -> str:
        """One or two sentences for the person who has to decide what to do."""
        return _ADVICE[self]


_ADVICE = {
    Outcome.CONVERGED: "The fit came to rest: more iterations would not describe samples better.",
    Outcome.NO_IMPROVEMENT: (
        "Further corrections stopped bringing the estimate nearer to the samples; the nearest "
        "iterate was kept."
    ),
    Outcome.ITERATION_LIMIT: (
        "The iteration limit came before the fit settled. Allow more iterations where the method "
        "has that setting, and look at the residuals: the material may lie outside what the "
        "population can express, or its noise may differ from place to place."
    ),
    Outcome.DIRECT: "Solved in one step; there is nothing to iterate.",
    Outcome.TOO_FEW_SAMPLES: (
        "There are so few usable samples that most of the result is assumed, not measured "
        "(correction functions only scale the nearest material of the population). Measure more "
        "directions, above all near the specular peak."
    ),
    Outcome.MOSTLY_OUTLIERS: (
        "More than half of the samples disagree with the result. Either the declared convention "
        "is wrong (light and detector, degrees, cosine), or no material of the population is "
        "like this one. Check the convention first."
    ),
}
