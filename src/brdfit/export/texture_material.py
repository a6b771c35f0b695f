"""A MaterialX material whose parameters are pictures beside it.

`UsdPreviewSurface` in its specular workflow takes just what was fitted: a diffuse colour, a
reflectance at normal incidence, and the roughness of a GGX lobe.
"""

from __future__ import annotations

from pathlib import Path

from brdfit.errors import UsageError
from brdfit.export.write_materialx import require_materialx

__all__ = ["write_texture_material"]

_INPUTS = (
    ("diffuseColor", "color3", "base_color.exr"),
    ("specularColor", "color3", "specular.exr"),
    ("roughness", "float", "roughness.exr"),
)


def write_texture_material(path: Path, said: str) -> None:
    """Write the material at `path`; `UsageError` if MaterialX's own check refuses it."""
    mx = require_materialx()
    library = mx.createDocument()
    mx.loadLibraries(mx.getDefaultDataLibraryFolders(), mx.getDefaultDataSearchPath(), library)
    document = mx.createDocument()
    document.setDataLibrary(library)
    document.setColorSpace("lin_rec709")
    shader = document.addNode("UsdPreviewSurface", "patch_surface", "surfaceshader")
    shader.setInputValue("useSpecularWorkflow", 1)
    for name, kind, file in _INPUTS:
        image = document.addNode("image", f"{file.removesuffix('.exr')}_map", kind)
        image.setInputValue("file", file, "filename")
        image.setInputValue("filtertype", "linear")
        shader.addInput(name, kind).setConnectedNode(image)
    shader.setDocString(said)
    document.addMaterialNode("patch", shader)
    valid, message = document.validate()
    if not valid:
        raise UsageError(f"{path.name}: MaterialX refuses what would be written: {message.strip()}")
    path.write_text(mx.writeToXmlString(document), encoding="utf-8")
