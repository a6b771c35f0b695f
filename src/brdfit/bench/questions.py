"""The questions of `brdfit bench sweep`: which values of a constant are compared.

A *candidate* gives some settings of a method; what it does not give is the default. A
question that is asked under several error metrics counts each of them alike, so that the
answer does not depend on the metric.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from itertools import product
from typing import Any

from brdfit.bench.paper.contender import Contender
from brdfit.bench.paper.contenders import Corrected, Interpolated, Splined
from brdfit.reconstruct.correction_functions import CorrectionFunctions
from brdfit.reconstruct.local_basis import LocalBasis
from brdfit.reconstruct.tabulated import Tabulated

__all__ = ["QUESTIONS", "Question", "Settings", "Variant", "contender", "defaults", "variants"]

Settings = dict[str, Any]
"""Settings of a method by name; those that are left out are the defaults."""

_BOTH = ("log", "linear")


@dataclass(frozen=True)
class Variant:
    """A method with settings: what is run. Equal ones of several questions are run once."""

    method: str
    """Its name in the tables: our, loc, tab."""
    changed: tuple[tuple[str, Any], ...]
    """Settings that differ from the defaults, sorted by name."""

    @classmethod
    def of(cls, method: str, settings: Settings, default: Settings) -> Variant:
        """Return the variant of these settings, whatever of them is the default already."""
        changed = {name: value for name, value in settings.items() if value != default[name]}
        return cls(method, tuple(sorted(changed.items())))

    @property
    def key(self) -> str:
        """A stable name: part of the key of its records."""
        told = ",".join(f"{name}={value}" for name, value in self.changed)
        return f"{self.method}|{told or 'default'}"


@dataclass(frozen=True)
class Question:
    """Values of one constant, or of some that interact, to be compared."""

    title: str
    method: str
    candidates: tuple[Settings, ...]
    metrics: tuple[str, ...] = ()
    """Error metrics under which every candidate is run; none is the method's default."""
    reason: str = ""
    """Why it is asked, a sentence for the page."""

    def runs(self, candidate: Settings, default: Settings) -> list[Variant]:
        """Return what is run for a candidate."""
        metrics = [{"error_metric": metric} for metric in self.metrics] or [{}]
        return [Variant.of(self.method, candidate | metric, default) for metric in metrics]

    def record(self) -> dict[str, Any]:
        """Return the question as JSON-able values."""
        return asdict(self)


def _grid(**values: Sequence[Any]) -> tuple[Settings, ...]:
    return tuple(dict(zip(values, row, strict=True)) for row in product(*values.values()))


_SIZES = ((12, 8, 6), (16, 10, 8), (24, 12, 8))

QUESTIONS = (
    Question(
        "Correction functions: gamma and softening",
        "our",
        _grid(gamma=(8.0, 16.0, 32.0), softening=(0.35, 0.7, 1.4, 2.8)),
        _BOTH,
        "How fast the weight of a sample falls with its deviation, at the end (gamma) and while "
        "the estimate is still poor (softening). They interact.",
    ),
    Question(
        "Correction functions: damping",
        "our",
        _grid(damping=(None, 1e-5, 1e-4, 1e-3, 1e-2)),
        _BOTH,
        "None is generalised cross-validation, which chooses from 1e-4 upwards anew for every "
        "correction.",
    ),
    Question(
        "Correction functions: iterations",
        "our",
        _grid(iterations=(2, 4, 8, 16, 32)),
        _BOTH,
        "Largest number of corrections. The iterate of the smallest robust loss is kept, so "
        "that more of them must not make the result worse.",
    ),
    Question(
        "Correction functions: robust start",
        "our",
        _grid(robust_start=(True, False)),
        _BOTH,
        "Whether the initial estimate defends itself against outliers.",
    ),
    Question(
        "Correction functions: error metric",
        "our",
        _grid(error_metric=("linear", "root", "log")),
        (),
        "Of the initial estimate and of the correction basis; all else at its default.",
    ),
    Question(
        "Local basis: smoothing and size",
        "loc",
        tuple(
            {"n_theta_h": size[0], "n_theta_d": size[1], "n_phi_d": size[2], "smoothing": smoothing}
            for size in _SIZES
            for smoothing in (1e-3, 1e-2, 1e-1, 1.0)
        ),
        (),
        "Weight of the roughness, and the number of splines along each angle.",
    ),
    Question(
        "Tabulated: kernel",
        "tab",
        _grid(kernel=("linear", "thin_plate_spline", "cubic")),
        (),
        "Radial basis function of the interpolant.",
    ),
)
"""What is asked, in the order of the page."""


def contender(variant: Variant) -> Contender:
    """Return the column of the paper's tables that runs a variant."""
    settings = dict(variant.changed)
    if variant.method == "our":
        return Corrected(CorrectionFunctions(**settings))
    if variant.method == "loc":
        return Splined(LocalBasis(**settings))
    return Interpolated(Tabulated(**settings))


def defaults(questions: Sequence[Question]) -> dict[str, Settings]:
    """Return the default settings of every method that is asked about."""
    methods = sorted({question.method for question in questions})
    return {method: contender(Variant(method, ())).record() for method in methods}


def variants(questions: Sequence[Question]) -> list[Variant]:
    """Return everything that is to be run, once each."""
    default = defaults(questions)
    found = [
        variant
        for question in questions
        for candidate in question.candidates
        for variant in question.runs(candidate, default[question.method])
    ]
    return list(dict.fromkeys(found))
