"""How a fit ended: a named outcome whose text is the advice."""

from __future__ import annotations

import enum

__all__ = ["Outcome"]


class Outcome(enum.Enum):
    """How a fit ended. `value` is the name in files; `advice` says what it means."""

    CONVERGED = "converged"
    HELD_OUT_STOP = "held_out_stop"
    ITERATION_LIMIT = "iteration_limit"
    DIRECT = "direct"
    TOO_FEW_SAMPLES = "too_few_samples"
    MOSTLY_OUTLIERS = "mostly_outliers"

    @property
    def ok(self) -> bool:
        """True if nothing about the ending calls for attention."""
        return self in (Outcome.CONVERGED, Outcome.HELD_OUT_STOP, Outcome.DIRECT)

    @property
    def advice(self) -> str:
        """One or two sentences for the person who has to decide what to do."""
        return _ADVICE[self]


_ADVICE = {
    Outcome.CONVERGED: "The correction became constant: more iterations would change nothing.",
    Outcome.HELD_OUT_STOP: (
        "Samples kept aside were predicted best at this iteration; later ones made them worse."
    ),
    Outcome.ITERATION_LIMIT: (
        "The iteration limit came before the correction settled. Allow more iterations, or look "
        "at the residuals: the material may lie outside what the population can express."
    ),
    Outcome.DIRECT: "Solved in one step; there is nothing to iterate.",
    Outcome.TOO_FEW_SAMPLES: (
        "There are fewer samples than the method can use: only a scaled material of the "
        "population was fitted. Measure more directions, above all near the specular peak."
    ),
    Outcome.MOSTLY_OUTLIERS: (
        "More than half of the samples disagree with the result. Either the declared convention "
        "is wrong (light and detector, degrees, cosine), or no material of the population is "
        "like this one. Check the convention first."
    ),
}
