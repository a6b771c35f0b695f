"""A BSDF of Mitsuba 3 that looks a table up and draws directions by what it reflects."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from brdfit.errors import UsageError
from brdfit.formats import read_table
from brdfit.mitsuba.drawing import Drawing
from brdfit.mitsuba.lookup import Lookup
from brdfit.report.rgb import rgb_table
from brdfit.table import Table

__all__ = ["plugin_class"]


def plugin_class(mi: Any) -> Any:
    """Return the class of the plugin for the variant that is set."""
    import drjit as dr

    class Brdfit(mi.BSDF):  # type: ignore[misc]
        """`filename`: any table that brdfit reads. Light and viewer above the surface only."""

        def __init__(self, props: Any, table: Table | None = None) -> None:
            super().__init__(props)
            given, origin = _read(mi, props) if table is None else (table, "a table in memory")
            shown, conversion = _showable(given, bool(mi.is_spectral))
            self._lookup, self._drawing = Lookup(mi, dr, shown), Drawing(mi, dr, shown)
            self._text = f"{origin}, {' x '.join(map(str, shown.grid.shape))}{conversion}"
            flags = mi.BSDFFlags.GlossyReflection | mi.BSDFFlags.FrontSide
            self.m_components, self.m_flags = [flags], flags

        def _lit(self, ctx: Any, si: Any, wo: Any, active: Any) -> Any:
            wanted = ctx.is_enabled(mi.BSDFFlags.GlossyReflection, 0)
            return active & wanted & (si.wi.z > 0.0) & (wo.z > 0.0)

        def sample(self, ctx: Any, si: Any, sample1: Any, sample2: Any, active: Any = True) -> Any:
            bs = mi.BSDFSample3f()
            bs.wo = self._drawing.draw(si.wi, sample1, sample2)
            bs.eta = 1.0
            bs.sampled_type = mi.UInt32(int(mi.BSDFFlags.GlossyReflection))
            bs.sampled_component = mi.UInt32(0)
            value, bs.pdf = self.eval_pdf(ctx, si, bs.wo, active)
            drawn = bs.pdf > 0.0
            return bs, dr.select(drawn, value / dr.select(drawn, bs.pdf, 1.0), 0.0)

        def eval(self, ctx: Any, si: Any, wo: Any, active: Any = True) -> Any:
            value = self._lookup.evaluate(si.wi, wo, si.wavelengths)
            return dr.select(self._lit(ctx, si, wo, active), value * wo.z, 0.0)

        def pdf(self, ctx: Any, si: Any, wo: Any, active: Any = True) -> Any:
            return dr.select(self._lit(ctx, si, wo, active), self._drawing.density(si.wi, wo), 0.0)

        def eval_pdf(self, ctx: Any, si: Any, wo: Any, active: Any = True) -> Any:
            return self.eval(ctx, si, wo, active), self.pdf(ctx, si, wo, active)

        def to_string(self) -> str:
            return f"Brdfit[{self._text}]"

    return Brdfit


def _read(mi: Any, props: Any) -> tuple[Table, str]:
    """Return the table of the file that is named, and the file's name."""
    if "filename" not in props:
        raise UsageError("the plugin 'brdfit' needs 'filename': any table that brdfit reads.")
    # relative names are looked for beside the scene file too
    path = Path(str(mi.file_resolver().resolve(str(props["filename"]))))
    return read_table(path), path.name


def _showable(table: Table, spectral: bool) -> tuple[Table, str]:
    """Return the table as the variant shows it, and in words what was done for that."""
    if not table.mask.any():
        raise UsageError("the table has no valid cell, so there is nothing to render.")
    if not spectral:
        rgb, conversion = rgb_table(table)
        return rgb, f"; {conversion}" if str(conversion) else ""
    if table.wavelengths is None:
        raise UsageError(
            f"a spectral variant asks for values at wavelengths, but the table has the channels "
            f"{', '.join(table.channels)} without any: no spectrum follows from them. Set an RGB "
            f"variant, for instance llvm_ad_rgb."
        )
    return table, ""
