"""Tables written as RGL measurements: the container, the microsurface, Mitsuba's own reading."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import brdfit
from brdfit.albedo import directional_albedo
from brdfit.arrays import FloatArray, dot, normalize
from brdfit.errors import DataQualityWarning, UsageError
from brdfit.formats.rgl.container import read_fields, written_fields
from brdfit.formats.rgl.measurement import measurement_from_bytes, measurement_to_bytes
from brdfit.formats.rgl.microsurface import Microsurface
from brdfit.formats.rgl.parameterisation import Parameterisation
from brdfit.formats.rgl.probes import Probes
from brdfit.formats.rgl.tabulate import Resolution, tabulated
from brdfit.formats.rgl.warp import bilinear
from brdfit.formats.rgl.write import LADDER
from brdfit.grid import Grid
from brdfit.samples import Source
from brdfit.table import Table

from small_files import tiny_table

FILES = ("aurora_white", "chm_mint", "paper_white")


class Beckmann:
    """A metal of Beckmann normals without shadowing: f_r = D / (4 cos_i cos_o) of albedo < 1."""

    def __init__(self, alpha: float) -> None:
        self.alpha = alpha

    def ndf(self, cos_m: FloatArray) -> FloatArray:
        tan2 = 1.0 / cos_m**2 - 1.0
        return np.exp(-tan2 / self.alpha**2) / (np.pi * self.alpha**2 * cos_m**4)

    def evaluate(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        wm = normalize(wi + wo)
        cos_i, cos_o = wi[:, 2], wo[:, 2]
        # the projected area stands for shadowing, as the model that is inverted has it
        area = np.maximum(cos_i, cos_o)
        return (self.ndf(wm[:, 2]) / (4.0 * area * np.minimum(cos_i, cos_o)))[:, None]


def lambert(albedo: tuple[float, ...] = (0.2, 0.5, 0.8)) -> Table:
    grid = Grid(12, 12, 12)
    values = np.broadcast_to(np.asarray(albedo) / np.pi, (*grid.shape, len(albedo)))
    return Table(values, grid=grid)


def glossy(roughness: float = 0.25) -> Table:
    grid = Grid(60, 30, 36)
    theta_h = np.broadcast_to(grid.theta_h[:, None, None], grid.shape)
    lobe = np.exp(-((np.tan(np.minimum(theta_h, 1.5)) / roughness) ** 2)) / roughness**2
    return Table(0.05 + 0.2 * lobe[..., None] * np.array([1.0, 0.8, 0.4]), grid=grid)


def test_what_is_written_into_the_container_is_read_back() -> None:
    rng = np.random.default_rng(0)
    fields: dict[str, np.ndarray[Any, Any]] = {
        "a": rng.uniform(size=(2, 3)).astype("<f4"),
        "größe": np.arange(5, dtype="<u8"),
        "bytes": np.arange(7, dtype=np.uint8),
        "transposed": rng.uniform(size=(4, 3)).T,
        "big_endian": np.arange(3, dtype=">i2"),
    }
    back = read_fields(written_fields(fields), "made.bsdf")
    assert list(back) == list(fields)
    for name, array in fields.items():
        assert back[name].shape == array.shape
        assert back[name].dtype.kind == array.dtype.kind
        np.testing.assert_array_equal(back[name], array)


def test_a_measurement_comes_back_at_single_precision() -> None:
    made = tabulated(tiny_table(), Resolution(5, 8, 12))
    back = measurement_from_bytes(measurement_to_bytes(made), "made.bsdf")
    for name in ("theta_i", "ndf", "sigma", "vndf"):
        np.testing.assert_array_equal(getattr(back, name), getattr(made, name))
    np.testing.assert_allclose(back.values, made.values, rtol=1e-7)
    assert made.bits is not None
    np.testing.assert_array_equal(back.bits, made.bits)
    assert back.jacobian


def test_the_real_files_are_written_as_they_were_read(shared_data: Path) -> None:
    for path in sorted((shared_data / "rgl").glob("*.bsdf")):
        read = measurement_from_bytes(path.read_bytes(), path.name)
        again = measurement_from_bytes(measurement_to_bytes(read), path.name)
        for name in ("theta_i", "ndf", "sigma", "vndf", "values", "bits", "description"):
            np.testing.assert_array_equal(getattr(again, name), getattr(read, name))


def test_power_iteration_finds_the_normals_of_a_microfacet_model() -> None:
    # backscatter of F D / (4 sigma cos): the iteration must return D, and sigma its projection
    true = Beckmann(0.3)
    found = Microsurface.of(true)
    theta = np.linspace(0.0, 1.0, found.ndf.size) ** 2 * (np.pi / 2)
    near = theta < np.deg2rad(35.0)
    ratio = found.ndf[near] / true.ndf(np.cos(theta[near]))
    assert np.abs(ratio / ratio[0] - 1.0).max() < 0.12
    # the areas of the normals, projected, add up to 1; so does a random draw of them
    assert found.sigma[0] == pytest.approx(1.0, abs=1e-3)
    rng = np.random.default_rng(1)
    cos_m, phi = rng.uniform(0.0, 1.0, 200_000), rng.uniform(-np.pi, np.pi, 200_000)
    wm = brdfit.directions_from_spherical(np.arccos(cos_m), phi)
    ndf = np.interp(np.sqrt(np.arccos(cos_m) * 2 / np.pi), np.linspace(0, 1, theta.size), found.ndf)
    for at in (30, 90, 150):
        w = np.array([np.sin(theta[at]), 0.0, np.cos(theta[at])])
        drawn = 2.0 * np.pi * np.mean(ndf * np.maximum(dot(wm, w[None]), 0.0))
        assert found.sigma[at] == pytest.approx(drawn, rel=0.03)


def test_nodes_hold_the_tables_values_and_nothing_below_the_horizon(tmp_path: Path) -> None:
    table = glossy()
    path = tmp_path / "a.bsdf"
    brdfit.write_table(table, path)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        samples = brdfit.read_samples(path)
    good = samples.usable.all(axis=1)
    assert good.mean() > 0.5
    expected = table.evaluate(samples.wi[good], samples.wo[good])
    np.testing.assert_allclose(samples.value[good], expected, rtol=2e-6)
    values = measurement_from_bytes(path.read_bytes(), "a").values
    assert (values >= 0.0).all()
    assert (values == 0.0).any()


class Ridge:
    """White, and brighter within a few degrees of one incidence, wherever it is looked at from."""

    def evaluate(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        return 0.1 + np.exp(-((np.degrees(np.arccos(wi[:, 2:])) - 71.3) ** 2 / 4.0))


def test_incidences_are_added_where_the_albedo_rises_and_falls_between_them() -> None:
    ridge, angles = Ridge(), np.deg2rad(np.arange(66.0, 77.0, 0.25))
    few = tabulated(ridge, Resolution(16, 24, 24))
    assert few.theta_i.size == 24
    assert (np.diff(few.theta_i) > 0.0).all()
    true = directional_albedo(ridge, angles)
    off = directional_albedo(Parameterisation.of(few), angles) / true - 1.0
    assert np.abs(off).max() < 0.12  # with the 16 alone it is 1.2
    # a matt surface needs none
    assert tabulated(lambert(), Resolution(16, 8, 8)).theta_i.size == 16


@pytest.mark.parametrize("table", [lambert(), glossy(), glossy(0.02)], ids=["matt", "satin", "gl"])
def test_the_file_is_as_close_as_it_says(table: Table, tmp_path: Path) -> None:
    path = tmp_path / "a.bsdf"
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        brdfit.write_table(table, path)
        back = brdfit.read_table(path)
    off, albedo_off = Probes.of(table).differences(back)
    assert off < 0.012
    assert albedo_off < 0.02


def test_a_table_too_rough_for_the_finest_resolution_is_said(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("brdfit.formats.rgl.write.LADDER", LADDER[:1])
    rng = np.random.default_rng(3)
    noisy = Table(np.exp(rng.normal(0.0, 1.0, (90, 90, 180, 3))))
    with pytest.warns(DataQualityWarning, match=r"differs from the table by \d+\.\d% in the mean"):
        brdfit.write_table(noisy, tmp_path / "a.bsdf")


def test_wavelengths_are_written_in_order_and_other_channels_refused(tmp_path: Path) -> None:
    table = tiny_table(channels=4)
    bands = Table(table.values, grid=table.grid, wavelengths=np.array([650.0, 450.0, 550.0, 500.0]))
    path = tmp_path / "a.bsdf"
    brdfit.write_table(bands, path)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        back = brdfit.read_samples(path)
    assert back.channels == ("450nm", "500nm", "550nm", "650nm")
    good = back.usable.all(axis=1)
    expected = bands.evaluate(back.wi[good], back.wo[good])[:, [1, 3, 2, 0]]
    np.testing.assert_allclose(back.value[good], expected, rtol=2e-6)
    with pytest.raises(UsageError, match="4 channels"):
        brdfit.write_table(table, tmp_path / "b.bsdf")
    with pytest.raises(UsageError, match="no valid cell"):
        brdfit.write_table(
            Table(table.values[..., :3], grid=table.grid, valid=np.zeros(table.grid.shape, bool)),
            tmp_path / "b.bsdf",
        )
    assert [p.name for p in tmp_path.iterdir()] == ["a.bsdf"]


def test_black_and_grey_can_be_written(tmp_path: Path) -> None:
    grid = Grid(6, 6, 6)
    brdfit.write_table(Table(np.zeros((*grid.shape, 3)), grid=grid), tmp_path / "black.bsdf")
    fields = read_fields((tmp_path / "black.bsdf").read_bytes(), "black")
    assert (fields["luminance"] == 1.0).all()
    assert (fields["rgb"] == 0.0).all()
    brdfit.write_table(lambert((0.5,)), tmp_path / "grey.bsdf")
    rgb = read_fields((tmp_path / "grey.bsdf").read_bytes(), "grey")["rgb"]
    np.testing.assert_array_equal(rgb[:, :, 0], rgb[:, :, 2])


def test_the_description_says_where_the_table_came_from(tmp_path: Path) -> None:
    plain = lambert()
    source = Source(name="paint.csv", sha256="ab12")
    table = Table(plain.values, grid=plain.grid, source=source)
    brdfit.write_table(table, tmp_path / "a.bsdf")
    found = brdfit.read_table(tmp_path / "a.bsdf").source.metadata["description"]
    for piece in ("paint.csv", "written by brdfit", "SHA-256 ab12"):
        assert piece in found


def mitsuba_rgb() -> Any:
    mi = pytest.importorskip("mitsuba", reason="the extra mitsuba is not installed")
    mi.set_variant("scalar_rgb")
    return mi


def evaluated(mi: Any, bsdf: Any, wi: FloatArray, wo: FloatArray) -> FloatArray:
    """Return f_r (n, 3) of a BSDF of Mitsuba; its value holds cos(theta_o)."""
    interaction, context = mi.SurfaceInteraction3f(), mi.BSDFContext()
    result = []
    for a, b in zip(wi, wo, strict=True):
        interaction.wi = mi.Vector3f(*map(float, a))
        result.append(np.array(bsdf.eval(context, interaction, mi.Vector3f(*map(float, b)), True)))
    return np.array(result) / wo[:, 2:]


def sampled_albedo(mi: Any, bsdf: Any, theta_i: float, n: int) -> FloatArray:
    """Return the mean weight of directions that Mitsuba draws: the directional albedo."""
    interaction, context = mi.SurfaceInteraction3f(), mi.BSDFContext()
    interaction.wi = mi.Vector3f(float(np.sin(theta_i)), 0.0, float(np.cos(theta_i)))
    side = np.arange(n) + 0.5
    total = np.zeros(3)
    for x in side / n:
        for y in side / n:
            _, weight = bsdf.sample(context, interaction, 0.5, mi.Point2f(float(x), float(y)), True)
            total += np.array(weight)
    return total / n**2


@pytest.mark.parametrize("table", [lambert(), glossy(), tiny_table()], ids=["matt", "gl", "skew"])
def test_mitsubas_measured_evaluates_and_samples_it(table: Table, tmp_path: Path) -> None:
    mi = mitsuba_rgb()
    brdfit.write_table(table, tmp_path / "a.bsdf")
    bsdf = mi.load_dict({"type": "measured", "filename": str(tmp_path / "a.bsdf")})
    probes = Probes.of(table)
    wi, wo, value = probes.wi[::5], probes.wo[::5], probes.value[::5]
    off = np.abs(np.log(evaluated(mi, bsdf, wi, wo) / value))
    assert off.mean() < 0.012
    for theta_i in (0.1, 0.8, 1.2):
        albedo = directional_albedo(table, [theta_i])[0]
        np.testing.assert_allclose(sampled_albedo(mi, bsdf, theta_i, 48), albedo, rtol=0.02)


@pytest.mark.parametrize("name", FILES)
def test_real_materials_arrive_in_mitsuba(shared_data: Path, tmp_path: Path, name: str) -> None:
    mi = mitsuba_rgb()
    table = brdfit.read_table(shared_data / "rgl" / f"{name}_rgb.bsdf")
    brdfit.write_table(table, tmp_path / "a.bsdf")
    bsdf = mi.load_dict({"type": "measured", "filename": str(tmp_path / "a.bsdf")})
    probes = Probes.of(table)
    value = evaluated(mi, bsdf, probes.wi[::5], probes.wo[::5])
    both = (value > 0.0) & (probes.value[::5] > 0.0)
    assert both.mean() > 0.9
    assert np.abs(np.log(value[both] / probes.value[::5][both])).mean() < 0.03


def test_mitsubas_spectral_variant_reads_bands(tmp_path: Path) -> None:
    mi = pytest.importorskip("mitsuba", reason="the extra mitsuba is not installed")
    mi.set_variant("scalar_spectral")
    table = glossy()
    bands = Table(table.values, grid=table.grid, wavelengths=np.array([450.0, 550.0, 650.0]))
    brdfit.write_table(bands, tmp_path / "a.bsdf")
    bsdf = mi.load_dict({"type": "measured", "filename": str(tmp_path / "a.bsdf")})
    interaction, context = mi.SurfaceInteraction3f(), mi.BSDFContext()
    interaction.wavelengths = [450.0, 500.0, 550.0, 650.0]
    wi, wo = brdfit.directions_from_spherical(np.array([0.4, 0.7]), np.array([0.0, 2.6]))
    interaction.wi = mi.Vector3f(*map(float, wi))
    value = np.array(bsdf.eval(context, interaction, mi.Vector3f(*map(float, wo)), True)) / wo[2]
    first, second, third = bands.evaluate(wi[None], wo[None])[0]
    expected = [first, (first + second) / 2.0, second, third]
    np.testing.assert_allclose(value, expected, rtol=0.03)


def test_interpolated_densities_are_what_the_surface_says() -> None:
    surface = Microsurface.of(glossy())
    made = tabulated(glossy(), Resolution(3, 4, 16))
    middle = bilinear(made.ndf, np.array([0.25]), np.array([0.5]))
    assert middle == pytest.approx(surface.ndf[45], rel=1e-6)
