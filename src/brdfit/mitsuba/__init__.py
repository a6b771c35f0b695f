"""Tables and reconstructions as materials in Mitsuba 3; the extra `mitsuba`.

    import mitsuba
    mitsuba.set_variant("llvm_ad_rgb")       # or scalar_rgb, scalar_spectral, ...
    import brdfit.mitsuba                    # registers the plugin, now and for later variants

    mitsuba.load_dict({"type": "brdfit", "filename": "paint.binary"})
    brdfit.mitsuba.bsdf(table)               # a table in memory, or a live reconstruction

In a scene file it is `<bsdf type="brdfit"><string name="filename" value="paint.binary"/></bsdf>`.
Its values are those of `Table.evaluate`; what Mitsuba's `eval` returns holds cos(theta_o) besides.
RGB and monochrome variants take any table, spectral ones those that have wavelengths.
"""

from __future__ import annotations

from typing import Any, Protocol

from brdfit.errors import UsageError
from brdfit.mitsuba.library import mitsuba_library
from brdfit.mitsuba.plugin import plugin_class
from brdfit.table import Table

__all__ = ["PLUGIN", "bsdf"]

PLUGIN = "brdfit"
"""The plugin's type in scene files and dictionaries."""

_classes: dict[str, Any] = {}


class _Tabulable(Protocol):
    def table(self) -> Table:
        """Return the dense table."""


def bsdf(brdf: Table | _Tabulable) -> Any:
    """Return a BSDF of the variant that is set, of a table or of a `Reconstruction`.

    Raises `UsageError` where no variant is set, or one that knows polarisation, and for tables
    that the variant cannot show: without a valid cell, or without wavelengths in a spectral one.
    """
    mi = mitsuba_library()
    if mi.variant() is None:
        raise UsageError('set a variant first, for instance mitsuba.set_variant("llvm_ad_rgb").')
    if mi.variant() not in _classes:
        raise UsageError(
            f"the variant {mi.variant()} tracks polarisation, of which a table says nothing. Set "
            f"the variant of the same name without 'polarized'."
        )
    table = brdf if isinstance(brdf, Table) else brdf.table()
    return _classes[mi.variant()](mi.Properties(PLUGIN), table)


def _register(before: object, now: object) -> None:
    mi = mitsuba_library()
    variant = mi.variant()
    if variant is None or variant in _classes or mi.is_polarized:
        return
    _classes[variant] = plugin_class(mi)
    mi.register_bsdf(PLUGIN, _classes[variant])


_register(None, None)
mitsuba_library().detail.add_variant_callback(_register)
