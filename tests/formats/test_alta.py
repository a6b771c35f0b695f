"""ALTA text: parametrisations that determine an isotropic measurement."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import brdfit
from brdfit.arrays import FloatArray
from brdfit.errors import CorruptFile, DataQualityWarning, FormatError, UsageError
from brdfit.geometry import half_diff_from_directions, spherical_from_directions

N = 15


def write(folder: Path, dim: str, param: str, cells: FloatArray, out: str = "") -> Path:
    path = folder / "x.alta"
    rows = "\n".join("\t".join(repr(float(cell)) for cell in row) + "\t" for row in cells)
    path.write_text(f"# a comment\n#\n#DIM {dim}\n#PARAM_IN  {param}\n{out}{rows}\n")
    return path


def coordinates(param: str, wi: FloatArray, wo: FloatArray) -> FloatArray:
    theta_h, theta_d, phi_d = half_diff_from_directions(wi, wo)
    theta_l, phi_l = spherical_from_directions(wi)
    theta_v, phi_v = spherical_from_directions(wo)
    phi = phi_v - phi_l
    by_name = {
        "RUSIN_TH_TD_PD": (theta_h, theta_d, phi_d),
        "RUSIN_TH_PH_TD_PD": (theta_h, phi_l, theta_d, phi_d),
        "SPHERICAL_TL_PL_TV_PV": (theta_l, phi_l, theta_v, phi_v),
        "ISOTROPIC_TV_TL_DPHI": (theta_v, theta_l, phi),
        "ISOTROPIC_TL_TV_PROJ_DPHI": (theta_l, theta_v * np.cos(phi), theta_v * np.sin(phi)),
        "CARTESIAN": (*wo.T, *wi.T),
    }
    return np.stack(by_name[param], axis=1)


@pytest.mark.parametrize(
    "param",
    [
        "RUSIN_TH_TD_PD",
        "RUSIN_TH_PH_TD_PD",
        "SPHERICAL_TL_PL_TV_PV",
        "ISOTROPIC_TV_TL_DPHI",
        "ISOTROPIC_TL_TV_PROJ_DPHI",
        "CARTESIAN",
    ],
)
def test_coordinates_bring_the_isotropic_directions_back(
    tmp_path: Path,
    random_directions: Callable[[int], tuple[FloatArray, FloatArray]],
    param: str,
) -> None:
    wi, wo = random_directions(N)
    x = coordinates(param, wi, wo)
    path = write(tmp_path, f"{x.shape[1]} 1", param, np.column_stack([x, np.ones(N)]))
    samples = brdfit.read_samples(path)
    np.testing.assert_allclose(samples.wi[:, 2], wi[:, 2], atol=1e-9)
    np.testing.assert_allclose(samples.wo[:, 2], wo[:, 2], atol=1e-9)
    between = np.einsum("ni,ni->n", samples.wi, samples.wo)
    np.testing.assert_allclose(between, np.einsum("ni,ni->n", wi, wo), atol=1e-9)


def test_a_slice_over_cos_th_has_theta_d_of_zero_and_says_so(tmp_path: Path) -> None:
    cosine = np.linspace(0.2, 1.0, N)
    cells = np.column_stack([cosine, np.ones((N, 3))])
    samples = brdfit.read_samples(
        write(tmp_path, "1 3", "COS_TH", cells, "#PARAM_OUT\tRGB_COLOR\n")
    )
    theta_h, theta_d, _ = samples.half_diff
    np.testing.assert_allclose(np.cos(theta_h), cosine)
    np.testing.assert_allclose(theta_d, 0.0, atol=1e-7)
    assert samples.channels == ("R", "G", "B")
    assert "COS_TH leaves theta_d open: taken as 0" in samples.source.notes


def test_a_cosine_factor_is_divided_out(tmp_path: Path) -> None:
    theta = np.linspace(0.1, 1.2, N)
    cells = np.column_stack([theta, 0 * theta, 0.5 * theta, 0 * theta, np.cos(0.5 * theta)])
    out = "#PARAM_OUT INV_STERADIAN_COSINE_FACTOR\n"
    samples = brdfit.read_samples(write(tmp_path, "4 1", "SPHERICAL_TL_PL_TV_PV", cells, out))
    np.testing.assert_allclose(samples.value, 1.0)


def test_vertical_segments_are_left_out_and_it_is_said(tmp_path: Path) -> None:
    cells = np.column_stack([np.linspace(0.2, 1.0, N), np.ones(N), np.zeros(N), np.full(N, 2.0)])
    samples = brdfit.read_samples(write(tmp_path, "1 1", "COS_TH", cells, "#VS 2\n"))
    assert samples.value.tolist() == [[1.0]] * N
    assert any("#VS" in note for note in samples.source.notes)


@pytest.mark.parametrize(
    ("dim", "param", "out", "error", "said"),
    [
        ("1 3", "COS_TK", "", FormatError, "PARAM_IN is COS_TK"),
        ("2 2", "COS_TH", "", CorruptFile, "COS_TH has 1 coordinates but #DIM says 2"),
        ("3", "COS_TH", "", CorruptFile, "found #DIM 3"),
        ("1 3", "COS_TH", "#PARAM_OUT ENERGY\n", FormatError, "PARAM_OUT is ENERGY"),
        ("1 3", "COS_TH", "#VS 7\n", CorruptFile, "#VS 7"),
        ("1 3", "COS_TH", "#FORMAT binary\n", FormatError, "binary variant"),
        ("1 5", "COS_TH", "", CorruptFile, "none of 15 rows holds 6 numbers"),
    ],
)
def test_a_header_that_cannot_be_used_is_named(
    tmp_path: Path, dim: str, param: str, out: str, error: type[Exception], said: str
) -> None:
    path = write(tmp_path, dim, param, np.ones((N, 4)), out)
    with pytest.raises(error) as caught:
        brdfit.read_samples(path)
    assert said in str(caught.value)


def test_a_broken_row_is_flagged(tmp_path: Path) -> None:
    path = write(tmp_path, "1 1", "COS_TH", np.column_stack([np.linspace(0.2, 1, N), np.ones(N)]))
    path.write_text(path.read_text() + "0.5\n")
    with pytest.warns(DataQualityWarning, match="1 unreadable, rows 20"):
        samples = brdfit.read_samples(path)
    assert len(samples) == N + 1


def test_the_slice_of_pink_felt_is_read(shared_data: Path) -> None:
    samples = brdfit.read_samples(shared_data / "merl_slice" / "pink-felt-1d.alta")
    assert samples.value.shape == (90, 3)
    assert samples.flag_counts() == {}
    assert samples.value[0, 0] == 0.109704419970512


def test_every_bit_comes_back(tmp_path: Path) -> None:
    samples = brdfit.Samples(
        wi=np.array([[0.6, 0.0, 0.8]] * 12),
        wo=np.stack([np.sin(np.arange(12) / 9), 0 * np.arange(12), np.cos(np.arange(12) / 9)], 1),
        value=np.arange(36.0).reshape(12, 3) / 7.0,
    )
    brdfit.write_samples(samples, tmp_path / "a.alta")
    back = brdfit.read_samples(tmp_path / "a.alta")
    for name in ("wi", "wo", "value"):
        np.testing.assert_array_equal(getattr(back, name), getattr(samples, name))
    assert back.channels == ("R", "G", "B")


def test_channels_without_a_name_in_alta_are_refused(tmp_path: Path) -> None:
    w = np.array([[0.0, 0.0, 1.0]])
    for value, more in (
        (np.ones((1, 2)), {}),
        (np.ones((1, 3)), {"channels": ("X", "Y", "Z")}),
        (np.ones((1, 3)), {"wavelengths": np.array([400.0, 500.0, 600.0])}),
    ):
        samples = brdfit.Samples(wi=w, wo=w, value=value, **more)
        with pytest.raises(UsageError, match="ALTA text holds one, or R, G and B"):
            brdfit.write_samples(samples, tmp_path / "a.alta")
