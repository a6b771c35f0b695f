"""An OpenPBR surface as MaterialX, written and validated by MaterialX's own library."""

from __future__ import annotations

from pathlib import Path
from types import ModuleType
from typing import Any

from brdfit.errors import MissingExtra, UsageError
from brdfit.export.fitting import Analytic
from brdfit.export.openpbr_material import OpenPbrMaterial
from brdfit.export.record import rounded
from brdfit.files import atomic_path

__all__ = ["require_materialx", "write_materialx"]


def require_materialx() -> ModuleType:
    """Return the library, or raise `MissingExtra`."""
    try:
        import MaterialX
    except ImportError as error:
        raise MissingExtra("MaterialX", "export", "Writing .mtlx") from error
    module: ModuleType = MaterialX
    return module


def write_materialx(fits: list[Analytic], provenance: dict[str, Any], path: Path) -> None:
    """Write the one fit of `fits`; `UsageError` if MaterialX's own check refuses it."""
    (fit,) = fits
    mx = require_materialx()
    if not isinstance(fit.material, OpenPbrMaterial):
        raise UsageError(
            f"{path.name}: MaterialX holds the model 'openpbr' but the fit is {fit.model!r}."
        )
    library = mx.createDocument()
    mx.loadLibraries(mx.getDefaultDataLibraryFolders(), mx.getDefaultDataSearchPath(), library)
    document = mx.createDocument()
    document.setDataLibrary(library)
    document.setColorSpace("lin_rec709")
    name = mx.createValidName(path.stem)
    shader = document.addNode("open_pbr_surface", f"{name}_surface", "surfaceshader")
    for parameter, value in rounded(fit.material.parameters()).items():
        shader.setInputValue(parameter, mx.Color3(*value) if isinstance(value, list) else value)
    shader.setDocString(_said(fit, provenance))
    document.addMaterialNode(name, shader)
    valid, message = document.validate()
    if not valid:
        raise UsageError(f"{path.name}: MaterialX refuses what would be written: {message.strip()}")
    with atomic_path(path) as aside:
        aside.write_text(mx.writeToXmlString(document), encoding="utf-8")


def _said(fit: Analytic, provenance: dict[str, Any]) -> str:
    source = provenance["source"]
    text = (
        f"{provenance['generator']}: fitted to {source['name']} (SHA-256 "
        f"{source['sha256'] or 'unknown'}), {fit.form}; perceptual error "
        f"{fit.perceptual_error:.3f} (mean CIEDE2000 on the studio sphere)"
    )
    # the library writes these as they are, which no attribute may hold
    return text.replace("<", "(").replace(">", ")")
