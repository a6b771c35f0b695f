"""The plugin is a BSDF that holds the table's values and samples what it says it samples."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import brdfit
from brdfit.albedo import directional_albedo
from brdfit.arrays import FloatArray
from brdfit.errors import UsageError
from brdfit.grid import MERL_GRID, Grid
from brdfit.table import Table

from small_files import tiny_table

Pairs = Callable[[int], tuple[FloatArray, FloatArray]]

# Polar angles of incidence, degrees: the normal, the usual, and close to the horizon.
INCIDENCES = (0.0, 30.0, 60.0, 85.0)


def white() -> Table:
    grid = Grid(12, 12, 12)
    return Table(np.full((*grid.shape, 3), 1.0 / np.pi), grid=grid)


def glossy() -> Table:
    grid = Grid(60, 30, 36)
    theta_h = np.broadcast_to(grid.theta_h[:, None, None], grid.shape)
    lobe = np.exp(-((np.tan(np.minimum(theta_h, 1.5)) / 0.15) ** 2)) / 0.15**2
    return Table(0.05 + 0.2 * lobe[..., None] * np.array([1.0, 0.8, 0.4]), grid=grid)


def skewed() -> Table:
    return tiny_table(Grid(20, 16, 18))


TABLES = pytest.mark.parametrize("make", [white, glossy, skewed], ids=["white", "glossy", "skewed"])


def direction(theta: float, phi: float = 0.4) -> list[float]:
    return [float(x) for x in brdfit.directions_from_spherical(np.radians(theta), phi)]


def many(mi: Any, wi: FloatArray, n: int) -> Any:
    """Return an interaction of `n` lanes with incidences `wi` (n, 3) or (3,)."""
    import drjit as dr

    si = dr.zeros(mi.SurfaceInteraction3f, n)
    si.wi = mi.Vector3f(np.broadcast_to(wi, (n, 3)).T.astype(np.float32))
    return si


def evaluated(mi: Any, bsdf: Any, wi: FloatArray, wo: FloatArray) -> FloatArray:
    """Return what Mitsuba's `eval` does (n, 3), in a variant with lanes."""
    there = mi.Vector3f(wo.T.astype(np.float32))
    return np.array(bsdf.eval(mi.BSDFContext(), many(mi, wi, len(wi)), there)).T


def drawn(mi: Any, bsdf: Any, wi: list[float], side: int) -> tuple[FloatArray, ...]:
    """Return (wo (n, 3), pdf (n,), weight (n, 3)) of points spread over the cube."""
    rng = np.random.default_rng(5)
    across, up = np.meshgrid((np.arange(side) + 0.5) / side, (np.arange(side) + 0.5) / side)
    points = np.stack([across.ravel(), up.ravel()]) + rng.uniform(-0.5, 0.5, (2, side**2)) / side
    choice = rng.permutation((np.arange(side**2) + 0.5) / side**2)
    bs, weight = bsdf.sample(
        mi.BSDFContext(),
        many(mi, np.array(wi), side**2),
        mi.Float(choice.astype(np.float32)),
        mi.Point2f(points.astype(np.float32)),
    )
    return np.array(bs.wo).T, np.array(bs.pdf), np.array(weight).T


@TABLES
def test_eval_is_the_tables_value_times_the_cosine(
    llvm: Any, make: Callable[[], Table], random_directions: Pairs
) -> None:
    import brdfit.mitsuba

    table = make()
    wi, wo = random_directions(3000)
    found = evaluated(llvm, brdfit.mitsuba.bsdf(table), wi, wo)
    expected = table.evaluate(wi, wo) * wo[:, 2:]
    np.testing.assert_allclose(found, expected, rtol=2e-3, atol=1e-6)
    assert np.median(np.abs(found / expected - 1.0)) < 1e-5


def test_eval_is_the_same_in_the_scalar_variant(scalar: Any, random_directions: Pairs) -> None:
    import brdfit.mitsuba

    table, bsdf = skewed(), brdfit.mitsuba.bsdf(skewed())
    si = scalar.SurfaceInteraction3f()
    for wi, wo in zip(*random_directions(60), strict=True):
        si.wi = scalar.Vector3f(*map(float, wi))
        found = bsdf.eval(scalar.BSDFContext(), si, scalar.Vector3f(*map(float, wo)), True)
        expected = table.evaluate(wi[None], wo[None])[0] * wo[2]
        np.testing.assert_allclose(np.array(found), expected, rtol=1e-3)


def test_around_a_hole_the_valid_cells_answer(llvm: Any, random_directions: Pairs) -> None:
    import brdfit.mitsuba

    whole = skewed()
    valid = np.random.default_rng(2).uniform(size=whole.grid.shape) < 0.7
    table = Table(np.where(valid[..., None], whole.values, 1e6), grid=whole.grid, valid=valid)
    wi, wo = random_directions(3000)
    corners, share = whole.grid.corners(*brdfit.geometry.half_diff_from_directions(wi, wo))
    answers = (share * table.mask.ravel()[corners]).sum(axis=1) > 0.05
    assert answers.sum() > 1000
    found = evaluated(llvm, brdfit.mitsuba.bsdf(table), wi[answers], wo[answers])
    expected = table.evaluate(wi[answers], wo[answers]) * wo[answers][:, 2:]
    np.testing.assert_allclose(found, expected, rtol=5e-3)


def test_light_and_viewer_may_be_exchanged(llvm: Any, random_directions: Pairs) -> None:
    import brdfit.mitsuba

    bsdf = brdfit.mitsuba.bsdf(skewed())
    wi, wo = random_directions(2000)
    there = evaluated(llvm, bsdf, wi, wo) / wo[:, 2:]
    back = evaluated(llvm, bsdf, wo, wi) / wi[:, 2:]
    np.testing.assert_allclose(there, back, rtol=1e-3)
    mirrored = evaluated(llvm, bsdf, wi * [1, -1, 1], wo * [1, -1, 1]) / wo[:, 2:]
    assert np.abs(there / mirrored - 1.0).max() > 0.1, "a table without symmetry was mirrored"


@TABLES
@pytest.mark.parametrize("theta_i", INCIDENCES)
def test_pdf_integrates_to_one(llvm: Any, make: Callable[[], Table], theta_i: float) -> None:
    import brdfit.mitsuba

    # midpoints that crowd around the mirror direction and near the horizon
    side = 700
    s = (np.arange(side) + 0.5) / side
    theta = s * np.pi / 2
    phi = 2.0 * np.pi * s
    theta, phi = (axis.ravel() for axis in np.meshgrid(theta, phi))
    wo = brdfit.directions_from_spherical(theta, phi)
    there = llvm.Vector3f(wo.T.astype(np.float32))
    si = many(llvm, np.array(direction(theta_i)), len(wo))
    pdf = np.array(brdfit.mitsuba.bsdf(make()).pdf(llvm.BSDFContext(), si, there))
    assert (pdf >= 0.0).all()
    assert np.sum(pdf * np.sin(theta)) * np.pi**2 / side**2 == pytest.approx(1.0, abs=4e-3)


@TABLES
@pytest.mark.parametrize("theta_i", INCIDENCES)
def test_directions_are_drawn_as_pdf_says(
    llvm: Any, make: Callable[[], Table], theta_i: float
) -> None:
    """Mitsuba's own chi-square test."""
    from mitsuba.python.chi2 import ChiSquareTest, SphericalDomain

    import brdfit.mitsuba

    bsdf, wi = brdfit.mitsuba.bsdf(make()), np.array(direction(theta_i))
    context = llvm.BSDFContext()

    def sample(u: Any) -> Any:
        bs, _ = bsdf.sample(context, many(llvm, wi, u.shape[1]), u[0], llvm.Point2f(u[1], u[2]))
        return bs.wo, llvm.Float(bs.pdf > 0.0)

    def pdf(wo: Any) -> Any:
        return bsdf.pdf(context, many(llvm, wi, wo.shape[1]), wo)

    test = ChiSquareTest(SphericalDomain(), sample, pdf, 3, 500_000, res=61, ires=16)
    assert test.run(0.01, test_count=3 * len(INCIDENCES)), test.messages


@TABLES
@pytest.mark.parametrize("theta_i", INCIDENCES)
def test_weights_are_eval_over_pdf_and_add_up_to_the_albedo(
    llvm: Any, make: Callable[[], Table], theta_i: float
) -> None:
    import brdfit.mitsuba

    table, wi = make(), direction(theta_i)
    bsdf = brdfit.mitsuba.bsdf(table)
    wo, pdf, weight = drawn(llvm, bsdf, wi, 300)
    assert (pdf > 0.0).mean() > 0.999, "directions are drawn in vain"
    up = pdf > 0.0
    value = evaluated(llvm, bsdf, np.broadcast_to(wi, wo[up].shape), wo[up])
    np.testing.assert_allclose(weight[up], value / pdf[up][:, None], rtol=1e-4, atol=1e-6)
    albedo = directional_albedo(table, [np.radians(theta_i)], rings=240, spokes=48)[0]
    np.testing.assert_allclose(weight.mean(axis=0), albedo, rtol=6e-3)
    # drawn by what is reflected: no direction carries much more than another
    assert weight[:, 1].std() < 0.4 * weight[:, 1].mean()


def test_scalar_weights_add_up_to_the_albedo(scalar: Any) -> None:
    import brdfit.mitsuba

    bsdf, si = brdfit.mitsuba.bsdf(white()), scalar.SurfaceInteraction3f()
    si.wi = scalar.Vector3f(*direction(50.0))
    s = (np.arange(20) + 0.5) / 20
    weights = [
        np.array(bsdf.sample(scalar.BSDFContext(), si, z, scalar.Point2f(x, y), True)[1])
        for x, y, z in zip(np.tile(s, 20), np.repeat(s, 20), np.tile(s[::-1], 20), strict=True)
    ]
    np.testing.assert_allclose(np.mean(weights, axis=0), 1.0, atol=0.01)


def test_nothing_is_seen_below_the_surface(llvm: Any) -> None:
    import brdfit.mitsuba

    bsdf, context = brdfit.mitsuba.bsdf(white()), llvm.BSDFContext()
    up, down = np.array([[0.6, 0.0, 0.8]]), np.array([[0.6, 0.0, -0.8]])
    for wi, wo in ((up, down), (down, up), (down, down)):
        assert not evaluated(llvm, bsdf, wi, wo).any()
        there = llvm.Vector3f(wo.T.astype(np.float32))
        assert not np.array(bsdf.pdf(context, many(llvm, wi, 1), there)).any()
    assert not drawn(llvm, bsdf, [0.6, 0.0, -0.8], 10)[2].any()


def test_a_file_is_loaded_by_name_in_dictionaries_and_scene_files(
    scalar: Any, tmp_path: Path
) -> None:
    import brdfit.mitsuba

    path = tmp_path / "a.npz"
    brdfit.write_table(skewed(), path)
    text = f'<bsdf version="3.0.0" type="brdfit"><string name="filename" value="{path}"/></bsdf>'
    for bsdf in (
        scalar.load_dict({"type": "brdfit", "filename": str(path)}),
        scalar.load_string(text),
    ):
        assert "a.npz, 20 x 16 x 18" in str(bsdf)
    scene = tmp_path / "scene.xml"
    inner = text.replace(' version="3.0.0"', "").replace(str(path), path.name)
    scene.write_text(f'<scene version="3.0.0"><shape type="sphere">{inner}</shape></scene>')
    assert "a.npz" in str(scalar.load_file(str(scene)).shapes()[0].bsdf())


def test_a_reconstruction_is_a_material(llvm: Any, random_directions: Pairs) -> None:
    import brdfit.mitsuba

    wi, wo = random_directions(60)
    samples = brdfit.Samples(wi=wi, wo=wo, value=skewed().evaluate(wi, wo))
    result = brdfit.fit(samples, method=brdfit.Tabulated())
    found = evaluated(llvm, brdfit.mitsuba.bsdf(result), wi, wo)
    expected = result.table(MERL_GRID).evaluate(wi, wo) * wo[:, 2:]
    assert np.median(np.abs(found / expected - 1.0)) < 1e-4


def test_bands_are_shown_by_spectral_and_by_colour_variants(scalar: Any) -> None:
    import brdfit.mitsuba

    grid = Grid(6, 6, 6)
    planes = np.broadcast_to([0.4, 0.1, 0.3, 0.2], (*grid.shape, 4))
    bands = Table(planes, grid=grid, wavelengths=np.array([650.0, 450.0, 550.0, 500.0]))
    assert "4 bands became linear sRGB" in str(brdfit.mitsuba.bsdf(bands))
    scalar.set_variant("scalar_spectral")
    si = scalar.SurfaceInteraction3f()
    si.wi, si.wavelengths = scalar.Vector3f(0.6, 0.0, 0.8), [400.0, 475.0, 600.0, 700.0]
    wo = scalar.Vector3f(-0.6, 0.0, 0.8)
    found = brdfit.mitsuba.bsdf(bands).eval(scalar.BSDFContext(), si, wo, True)
    np.testing.assert_allclose(np.array(found) / 0.8, [0.1, 0.15, 0.35, 0.4], rtol=1e-5)


def test_one_channel_is_grey(scalar: Any) -> None:
    import brdfit.mitsuba

    grid = Grid(6, 6, 6)
    bsdf = brdfit.mitsuba.bsdf(Table(np.full((*grid.shape, 1), 0.25), grid=grid))
    si = scalar.SurfaceInteraction3f()
    si.wi = scalar.Vector3f(0.0, 0.0, 1.0)
    wo = scalar.Vector3f(0.0, 0.0, 1.0)
    found = np.array(bsdf.eval(scalar.BSDFContext(), si, wo, True))
    np.testing.assert_allclose(found, 0.25, rtol=1e-5)


def test_what_cannot_be_shown_is_said(scalar: Any, tmp_path: Path) -> None:
    import brdfit.mitsuba

    grid = Grid(6, 6, 6)
    empty = Table(np.ones((*grid.shape, 3)), grid=grid, valid=np.zeros(grid.shape, bool))
    with pytest.raises(UsageError, match="no valid cell"):
        brdfit.mitsuba.bsdf(empty)
    with pytest.raises(RuntimeError, match="needs 'filename'"):
        scalar.load_dict({"type": "brdfit"})
    with pytest.raises(RuntimeError, match=r"gone\.binary: there is no such file"):
        scalar.load_dict({"type": "brdfit", "filename": str(tmp_path / "gone.binary")})
    scalar.set_variant("scalar_spectral")
    with pytest.raises(UsageError, match="no spectrum follows from them"):
        brdfit.mitsuba.bsdf(white())
    scalar.set_variant("scalar_spectral_polarized")
    with pytest.raises(UsageError, match="polarisation"):
        brdfit.mitsuba.bsdf(white())


def test_without_mitsuba_the_import_says_what_to_install() -> None:
    program = (
        "import sys; sys.modules['mitsuba'] = None\n"
        "from brdfit.errors import MissingExtra\n"
        "try: import brdfit.mitsuba\n"
        "except MissingExtra as error: print(error)\n"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert 'pip install "brdfit[mitsuba]"' in done.stdout, done.stderr


def test_without_a_variant_it_says_to_set_one(scalar: Any) -> None:
    program = (
        "import brdfit.mitsuba, numpy as np\n"
        "from brdfit.grid import Grid\n"
        "from brdfit.table import Table\n"
        "try: brdfit.mitsuba.bsdf(Table(np.ones((6, 6, 6, 3)), grid=Grid(6, 6, 6)))\n"
        "except Exception as error: print(error)\n"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert "set a variant first" in done.stdout, done.stderr
