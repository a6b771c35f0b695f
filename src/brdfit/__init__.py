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

if TYPE_CHECKING:
    from brdfit.errors import BrdfitError as BrdfitError
    from brdfit.samples import Samples as Samples

# public name -> module that defines it
_HOME = {
    "BrdfitError": "errors",
    "Samples": "samples",
}

__all__ = sorted(_HOME)


def __getattr__(name: str) -> Any:
    if name in _HOME:
        return getattr(import_module(f"brdfit.{_HOME[name]}"), name)
    raise AttributeError(f"module 'brdfit' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted([*globals(), *_HOME])
