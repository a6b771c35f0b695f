"""Analytic materials for tools that know no measured BRDF, and what that simplification costs.

    fitted = fit_analytic(table, "openpbr")      # or "gltf", "ggx"
    fitted.material.parameters()                 # what the tool's own parameters are
    fitted.perceptual_error                      # mean CIEDE2000 on a sphere, against the table
    write_export(table, Path("paint.mtlx"))      # .mtlx, .gltf, .json

A material that a tool describes by parameters cannot be every table: the parameters are those
whose rendered sphere comes closest, and every file says how close that is.
"""

from __future__ import annotations

from brdfit.export.fitting import Analytic, AnalyticSettings, fit_analytic
from brdfit.export.ggx_material import GgxMaterial
from brdfit.export.gltf_material import GltfMaterial
from brdfit.export.openpbr_material import OpenPbrMaterial
from brdfit.export.outputs import SUFFIXES, TARGETS, write_export

__all__ = [
    "SUFFIXES",
    "TARGETS",
    "Analytic",
    "AnalyticSettings",
    "GgxMaterial",
    "GltfMaterial",
    "OpenPbrMaterial",
    "fit_analytic",
    "write_export",
]
