"""A glTF 2.0 file of one material, on a sphere so that any viewer shows something.

The material stands first in `materials`; a tool that only wants it reads that and leaves the
mesh. Extensions are written where they say something that the core does not, and are never
required: a viewer without them shows the plain metallic-roughness material.
"""

from __future__ import annotations

import base64
import json
from pathlib import Path
from typing import Any

import numpy as np

from brdfit.arrays import FloatArray, IntArray
from brdfit.errors import UsageError
from brdfit.export.fitting import Analytic
from brdfit.export.gltf_material import GltfMaterial
from brdfit.export.record import fit_record, rounded
from brdfit.files import atomic_path

__all__ = ["gltf_material", "write_gltf"]

_MERIDIANS, _PARALLELS = 48, 24
_FLOAT, _UNSIGNED_SHORT = 5126, 5123
_VERTICES, _INDICES = 34962, 34963
_DEFAULT_IOR = 1.5


def write_gltf(fits: list[Analytic], provenance: dict[str, Any], path: Path) -> None:
    """Write the one fit of `fits`."""
    (fit,) = fits
    if not isinstance(fit.material, GltfMaterial):
        raise UsageError(f"{path.name}: glTF holds the model 'gltf' but the fit is {fit.model!r}.")
    material = gltf_material(fit.material, path.stem)
    material["extras"] = {"brdfit": {**provenance, **fit_record(fit)}}
    document = {
        "asset": {"version": "2.0", "generator": provenance["generator"]},
        **_used(material),
        "materials": [material],
        **_sphere(),
    }
    with atomic_path(path) as aside:
        aside.write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")


def gltf_material(material: GltfMaterial, name: str) -> dict[str, Any]:
    """Return the JSON object of a material."""
    found = rounded(material.parameters())
    core = {
        "baseColorFactor": [*found["baseColorFactor"], 1.0],
        "metallicFactor": found["metallicFactor"],
        "roughnessFactor": found["roughnessFactor"],
    }
    extensions: dict[str, Any] = {}
    if material.metallic < 1.0:
        if abs(material.ior - _DEFAULT_IOR) > 1e-3:
            extensions["KHR_materials_ior"] = {"ior": found["ior"]}
        specular = {
            "specularFactor": found["specularFactor"],
            "specularColorFactor": found["specularColorFactor"],
        }
        if specular != {"specularFactor": 1.0, "specularColorFactor": [1.0, 1.0, 1.0]}:
            extensions["KHR_materials_specular"] = specular
    if material.clearcoat > 0.0:
        extensions["KHR_materials_clearcoat"] = {
            "clearcoatFactor": found["clearcoatFactor"],
            "clearcoatRoughnessFactor": found["clearcoatRoughnessFactor"],
        }
    made: dict[str, Any] = {"name": name, "pbrMetallicRoughness": core}
    return made | ({"extensions": extensions} if extensions else {})


def _used(material: dict[str, Any]) -> dict[str, Any]:
    names = sorted(material.get("extensions", {}))
    return {"extensionsUsed": names} if names else {}


def _sphere() -> dict[str, Any]:
    """Return the scene: one node, one mesh, its data within the file."""
    position, index = _mesh()
    vertices = position.astype("<f4").tobytes()
    data = vertices + index.astype("<u2").tobytes()
    uri = "data:application/octet-stream;base64," + base64.b64encode(data).decode()
    count = len(position)
    return {
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "name": "sphere"}],
        "meshes": [
            {
                "primitives": [
                    # on a unit sphere the positions are the normals
                    {"attributes": {"POSITION": 0, "NORMAL": 1}, "indices": 2, "material": 0}
                ]
            }
        ],
        "accessors": [
            {
                **_accessor(0, _FLOAT, count, "VEC3"),
                "min": [float(low) for low in position.astype("<f4").min(axis=0)],
                "max": [float(high) for high in position.astype("<f4").max(axis=0)],
            },
            _accessor(0, _FLOAT, count, "VEC3"),
            _accessor(1, _UNSIGNED_SHORT, index.size, "SCALAR"),
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": len(vertices), "byteStride": 12}
            | {"target": _VERTICES},
            {
                "buffer": 0,
                "byteOffset": len(vertices),
                "byteLength": len(data) - len(vertices),
                "target": _INDICES,
            },
        ],
        "buffers": [{"byteLength": len(data), "uri": uri}],
    }


def _accessor(view: int, component: int, count: int, kind: str) -> dict[str, Any]:
    return {"bufferView": view, "componentType": component, "count": count, "type": kind}


def _mesh() -> tuple[FloatArray, IntArray]:
    """Return (positions (n, 3), indices (m,)) of the unit sphere, +y up, seen from outside."""
    theta = np.linspace(0.0, np.pi, _PARALLELS + 1)
    phi = np.linspace(0.0, 2.0 * np.pi, _MERIDIANS + 1)
    across, down = np.meshgrid(phi, theta)
    ring = np.sin(down)
    position = np.stack([ring * np.cos(across), np.cos(down), -ring * np.sin(across)], axis=-1)
    row, column = np.meshgrid(np.arange(_PARALLELS), np.arange(_MERIDIANS), indexing="ij")
    corner = (row * (_MERIDIANS + 1) + column).ravel()
    below = corner + _MERIDIANS + 1
    upper = np.stack([corner, below, corner + 1], axis=1)
    lower = np.stack([corner + 1, below, below + 1], axis=1)
    # at either pole one triangle of each pair is a line
    faces = [upper[row.ravel() > 0], lower[row.ravel() < _PARALLELS - 1]]
    return position.reshape(-1, 3), np.concatenate(faces).ravel()
