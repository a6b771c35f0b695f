"""Methods: frozen settings in, a `Reconstruction` out.

    result = fit(samples)                                            # the default method
    result = fit(samples, method=CorrectionFunctions(error_metric="root"))

`METHODS` maps the name that the command line uses to the class of settings.
"""

from __future__ import annotations

from brdfit.progress import Progress, silent
from brdfit.reconstruct.compact import Compact
from brdfit.reconstruct.correction_functions import CorrectionFunctions
from brdfit.reconstruct.global_basis import GlobalBasis
from brdfit.reconstruct.local_basis import LocalBasis
from brdfit.reconstruct.outcome import Outcome
from brdfit.reconstruct.pca_ridge import PcaRidge
from brdfit.reconstruct.posterior import Posterior
from brdfit.reconstruct.result import Method, Reconstruction
from brdfit.reconstruct.tabulated import Tabulated
from brdfit.samples import Samples

__all__ = [
    "METHODS",
    "Compact",
    "CorrectionFunctions",
    "GlobalBasis",
    "LocalBasis",
    "Method",
    "Outcome",
    "PcaRidge",
    "Posterior",
    "Reconstruction",
    "Tabulated",
    "fit",
]

METHODS: dict[str, type] = {
    method.name: method
    for method in (
        Posterior,
        CorrectionFunctions,
        Compact,
        GlobalBasis,
        PcaRidge,
        LocalBasis,
        Tabulated,
    )
}
"""Name -> class of settings."""


def fit(
    samples: Samples, method: Method | None = None, progress: Progress = silent
) -> Reconstruction:
    """Return the complete BRDF that `samples` are measurements of.

    Parameters
    ----------
    samples
        Measurements with any number of channels; flagged ones are not used.
    method
        Settings of a method; left out, `Posterior()`.
    progress
        Told of long steps (`brdfit.progress`).

    Raises `SampleError` where there is nothing to fit, `PopulationError` where the method's
    population cannot be had. A fit that ends badly raises nothing: see `outcome`.
    """
    return (Posterior() if method is None else method).fit(samples, progress)
