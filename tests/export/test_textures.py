"""Textures: every pixel from its own item, and the fit in closed form recovers what it is."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from brdfit.arrays import dot
from brdfit.errors import UsageError
from brdfit.export.texture_fit import TextureFit
from brdfit.formats.exr_file import read_exr
from brdfit.models import Ggx

pytest.importorskip("zarr", reason="stores need zarr: pip install 'brdfit[batch]'")
pytest.importorskip("OpenEXR", reason="maps need OpenEXR: pip install 'brdfit[exr]'")
pytest.importorskip("MaterialX", reason="materials need MaterialX: brdfit[export]")

from brdfit.batch import open_batch, open_input, run_batch
from brdfit.export.textures import write_textures
from brdfit.geometry import directions_from_spherical
from brdfit.populations import population
from brdfit.reconstruct import Compact

MATERIALS = [
    Ggx((0.5, 0.2, 0.1), (0.04, 0.04, 0.04), 0.3**2),
    Ggx((0.05, 0.1, 0.3), (0.1, 0.2, 0.3), 0.45**2),
    Ggx((0.0, 0.0, 0.0), (0.9, 0.7, 0.4), 0.2**2),
]


@pytest.mark.parametrize("material", MATERIALS)
def test_a_ggx_material_is_recovered(material):
    fit = TextureFit()
    points = fit.fit(material.evaluate(*fit.directions)[None])
    assert points.roughness[0] == pytest.approx(
        float(np.sqrt(np.ravel(material.alpha)[0])), abs=0.02
    )
    assert np.allclose(points.diffuse[0], material.diffuse, atol=0.02)
    assert np.allclose(points.specular[0], material.f0, rtol=0.15, atol=0.02)
    assert points.misfit[0] < 0.2


def test_a_point_without_values_has_no_parameters():
    fit = TextureFit()
    values = np.stack([MATERIALS[0].evaluate(*fit.directions)] * 3)
    values[1] = np.nan
    points = fit.fit(values)
    assert np.isnan(points.roughness).tolist() == [False, True, False]
    assert np.isnan(points.diffuse).all(axis=1).tolist() == [False, True, False]
    assert np.array_equal(points.diffuse[0], points.diffuse[2])


WIDTH, HEIGHT, N = 5, 4, 24


@pytest.fixture(scope="module")
def patch(tmp_path_factory):
    """Return a store of 18 items on 5 x 4 pixels: one pixel has none, and one item failed."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    rng = np.random.default_rng(3)
    theta, phi = np.arccos(rng.uniform(0.2, 1.0, (2, N))), rng.uniform(-np.pi, np.pi, (2, N))
    wi, wo = directions_from_spherical(theta, phi)
    pixels = [p for p in range(WIDTH * HEIGHT) if p != 7]
    rows = []
    for item, pixel in enumerate(pixels):
        value = MATERIALS[pixel % 2].evaluate(wi, wo) * np.exp(0.01 * rng.normal(size=(N, 3)))
        if item == 3:
            value[:] = np.nan
        rows.append(np.column_stack([np.full(N, item), np.full(N, pixel), wi, wo, value]))
    table = np.concatenate(rows)
    columns = {"item": table[:, 0].astype(int)}
    columns |= {"x": table[:, 1].astype(int) % WIDTH + 10, "y": table[:, 1].astype(int) // WIDTH}
    names = ["wi_x", "wi_y", "wi_z", "wo_x", "wo_y", "wo_z", "R", "G", "B"]
    columns |= {name: table[:, 2 + k] for k, name in enumerate(names)}
    folder = tmp_path_factory.mktemp("textures")
    pq.write_table(pa.table(columns), folder / "patch.parquet")
    published = population("published")
    method = Compact(population=published.subset(published.unique_materials[::10]), components=12)
    run_batch(open_input(folder / "patch.parquet"), folder / "patch.zarr", method)
    return folder / "patch.zarr"


@pytest.fixture(scope="module")
def folder(patch):
    """Return the textures of the patch."""
    write_textures(open_batch(patch), patch.with_name("maps"))
    return patch.with_name("maps")


def plane(path, name="Y"):
    return read_exr(Path(path))[0][name]


def test_every_pixel_has_what_its_item_says_and_the_others_nothing(patch, folder):
    batch = open_batch(patch)
    empty = np.zeros((HEIGHT, WIDTH), dtype=bool)
    empty.reshape(-1)[[7, 3]] = True
    for name, column in (("uncertainty", "deviation"), ("outlier_share", "outlier_share")):
        found = plane(folder / f"{name}.exr")
        assert np.array_equal(np.isnan(found), empty)
        pixels = [p for p in range(WIDTH * HEIGHT) if p != 7]
        expected = batch.column(column)
        assert np.array_equal(found.reshape(-1)[pixels], expected, equal_nan=True)
    base = plane(folder / "base_color.exr", "R").reshape(-1)
    even, odd = base[[0, 2, 4, 6]], base[[1, 5, 9]]
    assert even.min() > 2.0 * odd.max()  # 0.5 and 0.05


def test_the_atlas_evaluates_exactly(patch, folder, random_directions):
    wi, wo = random_directions(20)
    batch = open_batch(patch)
    pixel, item = 9, batch["8"]
    z = np.stack([
        [plane(path, c).reshape(-1)[pixel] for c in "RGB"]
        for path in sorted((folder / "coefficients").iterdir())
    ])  # fmt: skip
    mean, phi = batch.basis.at(wi, wo)
    assert np.allclose(mean[:, None] + phi @ z, np.log(item.evaluate(wi, wo)), atol=1e-4)
    kept = np.load(folder / "basis.npz")
    assert np.array_equal(kept["rows"], batch.basis.rows)


def test_the_material_names_maps_that_are_there(folder):
    library = pytest.importorskip("MaterialX")
    document = library.createDocument()
    library.readFromXmlFile(document, str(folder / "material.mtlx"))
    files = [node.getInputValue("file") for node in document.getNodes("image")]
    assert sorted(files) == ["base_color.exr", "roughness.exr", "specular.exr"]
    assert all((folder / file).is_file() for file in files)
    assert len(document.getMaterialNodes()) == 1


def test_the_record_says_what_made_them_and_the_preview_is_a_picture(patch, folder):
    record = json.loads((folder / "record.json").read_text())
    assert record["input"] == open_batch(patch).attributes["input"]
    assert (record["height"], record["width"]) == (HEIGHT, WIDTH)
    assert (folder / "preview.png").read_bytes()[:4] == b"\x89PNG"


def test_textures_replace_textures_and_nothing_else(patch, folder, tmp_path):
    before = (folder / "base_color.exr").read_bytes()
    write_textures(open_batch(patch), folder)
    assert (folder / "base_color.exr").read_bytes() == before
    (tmp_path / "holiday.jpg").write_bytes(b"mine")
    with pytest.raises(UsageError, match="other files"):
        write_textures(open_batch(patch), tmp_path)
    assert [p.name for p in tmp_path.iterdir()] == ["holiday.jpg"]
    with pytest.raises(UsageError, match="does not exist"):
        write_textures(open_batch(patch), tmp_path / "no" / "where")


def test_the_directions_that_are_asked_are_above_the_horizon():
    wi, wo = TextureFit().directions
    assert np.allclose(dot(wi, wi), 1.0)
    assert (np.minimum(wi[:, 2], wo[:, 2]) > 0.0).all()
