"""brdfit: few, irregular, partly wrong reflectance measurements -> a complete BRDF.

    samples = brdfit.read_samples("krylon_blue.astm")
    result = brdfit.fit(samples)
    result.evaluate(wi, wo)                     # (n, channels), 1/sr
    result.outliers, result.weights             # per sample
    brdfit.write_table(result.table(), "krylon_blue.binary")

Every public name is listed in `__all__`; a name is imported when it is first used, so that
`import brdfit` stays quick.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from brdfit.display import draw_with as _draw_with

if TYPE_CHECKING:
    from brdfit.batch import open_batch as open_batch
    from brdfit.errors import BrdfitError as BrdfitError
    from brdfit.formats import list_formats as list_formats
    from brdfit.formats import read_samples as read_samples
    from brdfit.formats import read_table as read_table
    from brdfit.formats import write_samples as write_samples
    from brdfit.formats import write_table as write_table
    from brdfit.geometry import directions_from_spherical as directions_from_spherical
    from brdfit.populations import Population as Population
    from brdfit.populations import population as population
    from brdfit.reconstruct import Compact as Compact
    from brdfit.reconstruct import CorrectionFunctions as CorrectionFunctions
    from brdfit.reconstruct import GlobalBasis as GlobalBasis
    from brdfit.reconstruct import LocalBasis as LocalBasis
    from brdfit.reconstruct import Outcome as Outcome
    from brdfit.reconstruct import PcaRidge as PcaRidge
    from brdfit.reconstruct import Posterior as Posterior
    from brdfit.reconstruct import Reconstruction as Reconstruction
    from brdfit.reconstruct import Tabulated as Tabulated
    from brdfit.reconstruct import fit as fit
    from brdfit.report.page import write_report as write_report
    from brdfit.samples import Samples as Samples
    from brdfit.table import Table as Table

# public name -> module that defines it
_HOME = {
    "BrdfitError": "errors",
    "Compact": "reconstruct",
    "CorrectionFunctions": "reconstruct",
    "GlobalBasis": "reconstruct",
    "LocalBasis": "reconstruct",
    "Outcome": "reconstruct",
    "PcaRidge": "reconstruct",
    "Posterior": "reconstruct",
    "Population": "populations",
    "Reconstruction": "reconstruct",
    "Samples": "samples",
    "Table": "table",
    "Tabulated": "reconstruct",
    "directions_from_spherical": "geometry",
    "fit": "reconstruct",
    "list_formats": "formats",
    "open_batch": "batch",
    "population": "populations",
    "read_samples": "formats",
    "read_table": "formats",
    "write_report": "report.page",
    "write_samples": "formats",
    "write_table": "formats",
}

__all__ = sorted(_HOME)


def __getattr__(name: str) -> Any:
    if name in _HOME:
        return getattr(import_module(f"brdfit.{_HOME[name]}"), name)
    raise AttributeError(f"module 'brdfit' has no attribute {name!r}")


def _show(what: object) -> str:
    html: str = import_module("brdfit.report.notebook").html_of(what)
    return html


# Samples, tables and results show themselves in notebooks; who draws them stands far above.
_draw_with(_show)


def __dir__() -> list[str]:
    return sorted([*globals(), *_HOME])
