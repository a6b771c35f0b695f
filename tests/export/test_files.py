"""The files: valid for the libraries that own the formats, and honest about their error."""

from __future__ import annotations

import base64
import json
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from brdfit.albedo import Evaluable
from brdfit.errors import MissingExtra, UsageError
from brdfit.export import AnalyticSettings, GltfMaterial, write_export
from brdfit.export.write_gltf import gltf_material
from brdfit.models import Ggx
from brdfit.table import Table

Tabulate = Callable[[Evaluable], Table]

QUICK = AnalyticSettings(size=16, judged=24, steps=8)
SATIN = Ggx(diffuse=[0.3, 0.2, 0.1], f0=0.07, alpha=0.2)


def test_materialx_accepts_what_is_written(tabulate: Tabulate, tmp_path: Path) -> None:
    mx = pytest.importorskip("MaterialX", reason="the extra 'export' is not installed")
    path = tmp_path / "7 paint <x>.mtlx"
    exported = write_export(tabulate(SATIN), path, QUICK)
    document, library = mx.createDocument(), mx.createDocument()
    mx.loadLibraries(mx.getDefaultDataLibraryFolders(), mx.getDefaultDataSearchPath(), library)
    mx.readFromXmlFile(document, str(path))
    document.setDataLibrary(library)
    assert document.validate() == (True, "")
    assert document.getColorSpace() == "lin_rec709"
    (material,) = document.getMaterialNodes()
    (shader,) = mx.getShaderNodes(material)
    found = {one.getName(): one.getValue() for one in shader.getInputs()}
    expected = exported.fits[0].material.parameters()
    assert set(found) == set(expected)
    assert found["specular_roughness"] == pytest.approx(expected["specular_roughness"], abs=1e-5)
    assert list(found["base_color"].asTuple()) == pytest.approx(expected["base_color"], abs=1e-5)
    assert f"{exported.fits[0].perceptual_error:.3f}" in shader.getDocString()


def test_materialx_makes_a_shader_of_what_is_written(tabulate: Tabulate, tmp_path: Path) -> None:
    mx = pytest.importorskip("MaterialX", reason="the extra 'export' is not installed")
    shaders = pytest.importorskip("MaterialX.PyMaterialXGenShader")
    glsl = pytest.importorskip("MaterialX.PyMaterialXGenGlsl")
    path = tmp_path / "paint.mtlx"
    write_export(tabulate(SATIN), path, QUICK)
    document = mx.createDocument()
    mx.loadLibraries(mx.getDefaultDataLibraryFolders(), mx.getDefaultDataSearchPath(), document)
    mx.readFromXmlFile(document, str(path))
    generator = glsl.GlslShaderGenerator.create()
    context = shaders.GenContext(generator)
    context.registerSourceCodeSearchPath(mx.getDefaultDataSearchPath())
    (element,) = shaders.findRenderableElements(document)
    source = generator.generate("paint", element, context)
    assert "open_pbr_surface" in source.getSourceCode(shaders.PIXEL_STAGE)


def test_without_materialx_the_error_comes_before_the_work(
    tabulate: Tabulate, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "MaterialX", None)
    with pytest.raises(MissingExtra, match=r"brdfit\[export\]"):
        write_export(tabulate(SATIN), tmp_path / "paint.mtlx", QUICK)
    assert not list(tmp_path.iterdir())


def test_a_gltf_file_holds_the_material_on_a_sphere(tabulate: Tabulate, tmp_path: Path) -> None:
    path = tmp_path / "paint.gltf"
    exported = write_export(tabulate(SATIN), path, QUICK)
    document = json.loads(path.read_text())
    (material,) = document["materials"]
    fit = exported.fits[0]
    assert material["name"] == "paint"
    assert set(document.get("extensionsUsed", ())) == set(material.get("extensions", ()))
    assert "extensionsRequired" not in document
    core = material["pbrMetallicRoughness"]
    assert core["roughnessFactor"] == pytest.approx(
        fit.material.parameters()["roughnessFactor"], abs=1e-5
    )
    assert len(core["baseColorFactor"]) == 4
    said = material["extras"]["brdfit"]
    assert said["perceptual_error"] == pytest.approx(fit.perceptual_error, abs=1e-5)
    assert said["source"]["sha256"] == "0" * 64
    assert_sphere(document)


def assert_sphere(document: dict) -> None:  # type: ignore[type-arg]
    (buffer,) = document["buffers"]
    data = base64.b64decode(buffer["uri"].partition(",")[2])
    assert len(data) == buffer["byteLength"]
    views = document["bufferViews"]
    assert sum(view["byteLength"] for view in views) == len(data)
    vertices = np.frombuffer(data, "<f4", offset=0, count=views[0]["byteLength"] // 4).reshape(
        -1, 3
    )
    index = np.frombuffer(data, "<u2", offset=views[1]["byteOffset"])
    accessors = document["accessors"]
    assert accessors[0]["count"] == accessors[1]["count"] == len(vertices)
    assert accessors[2]["count"] == index.size
    assert index.max() < len(vertices)
    np.testing.assert_allclose(np.linalg.norm(vertices, axis=1), 1.0, rtol=1e-6)
    assert accessors[0]["min"] == vertices.min(axis=0).tolist()
    # seen from outside, corners run counter-clockwise
    a, b, c = vertices[index.reshape(-1, 3)].transpose(1, 0, 2)
    assert (np.einsum("ni,ni->n", np.cross(b - a, c - a), a + b + c) > 0.0).all()


@pytest.mark.parametrize(
    ("material", "extensions"),
    [
        (GltfMaterial((0.5, 0.5, 0.5), 0.5), []),
        (GltfMaterial((0.5, 0.5, 0.5), 0.5, metallic=1.0), []),
        (GltfMaterial((0.5, 0.5, 0.5), 0.5, reflectance=(0.08,) * 3), ["KHR_materials_ior"]),
        (GltfMaterial((0.5, 0.5, 0.5), 0.5, specular=0.5), ["KHR_materials_specular"]),
        (
            GltfMaterial((0.5, 0.5, 0.5), 0.5, clearcoat=1.0, clearcoat_roughness=0.1),
            ["KHR_materials_clearcoat"],
        ),
    ],
)
def test_an_extension_is_named_only_where_it_says_something(
    material: GltfMaterial, extensions: list[str]
) -> None:
    assert sorted(gltf_material(material, "x").get("extensions", {})) == extensions


def test_json_holds_every_model(tabulate: Tabulate, tmp_path: Path) -> None:
    path = tmp_path / "paint.json"
    write_export(tabulate(SATIN), path, QUICK)
    record = json.loads(path.read_text())
    assert record["schema"] == "brdfit.export/1"
    assert list(record["models"]) == ["ggx", "gltf", "openpbr"]
    for found in record["models"].values():
        assert found["tried"][found["form"]] == found["perceptual_error"]


def test_a_grey_table_becomes_a_grey_material(tabulate: Tabulate, tmp_path: Path) -> None:
    exported = write_export(tabulate(Ggx(diffuse=0.4, alpha=0.3)), tmp_path / "grey.gltf", QUICK)
    assert exported.conversion.kind == "grey"
    red, green, blue = exported.fits[0].material.parameters()["baseColorFactor"]
    assert red == pytest.approx(green, rel=1e-3)
    assert red == pytest.approx(blue, rel=1e-3)


def test_another_suffix_is_refused_with_those_there_are(tabulate: Tabulate, tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"\.mtlx.*\.gltf.*convert"):
        write_export(tabulate(SATIN), tmp_path / "paint.binary", QUICK)
