"""RGL `.bsdf`: the container, the warp, and the directions and values that come out."""

from __future__ import annotations

import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from brdfit.arrays import FloatArray
from brdfit.errors import CorruptFile, FormatError, UsageError
from brdfit.formats.rgl import SHEET
from brdfit.formats.rgl.container import read_fields
from brdfit.formats.rgl.measurement import measurement_from_bytes
from brdfit.formats.rgl.parameterisation import Parameterisation
from brdfit.formats.rgl.warp import Warp
from brdfit.geometry import directions_from_spherical
from brdfit.grid import Grid
from brdfit.samples import Flag

CODES = {"uint8": 1, "uint16": 3, "float32": 10, "float64": 11}
FILES = (
    "aurora_white",
    "cc_ibiza_sunset",
    "chm_mint",
    "colodur_napoli_4f",
    "ilm_solo_m_68",
    "irid_flake_paint1",
    "paper_white",
    "satin_rosaline",
    "vch_golden_yellow",
)

Fields = dict[str, np.ndarray]


def tensor_file(fields: Fields) -> bytes:
    """Write the container from its description."""
    entry_bytes = [2 + len(name) + 2 + 1 + 8 + 8 * a.ndim for name, a in fields.items()]
    offset = 18 + sum(entry_bytes)
    header, data = b"tensor_file\0\x01\x00" + struct.pack("<I", len(fields)), b""
    for name, array in fields.items():
        header += struct.pack("<H", len(name)) + name.encode()
        header += struct.pack("<HBQ", array.ndim, CODES[array.dtype.name], offset + len(data))
        header += struct.pack(f"<{array.ndim}Q", *array.shape)
        data += array.tobytes()
    return header + data


def small_fields(
    nodes: int = 2, resolution: int = 2, angles: tuple[float, ...] = (0.0, 1.2)
) -> Fields:
    """Return a measurement with few nodes whose values differ from one another."""
    rng = np.random.default_rng(7)
    t = len(angles)
    count = t * nodes * nodes
    return {
        "phi_i": np.zeros(1, np.float32),
        "theta_i": np.asarray(angles, np.float32),
        "sigma": np.full((2, 2), 0.8, np.float32),
        "ndf": rng.uniform(0.5, 1.0, (2, resolution)).astype(np.float32),
        "vndf": rng.uniform(0.5, 1.0, (1, t, resolution, resolution)).astype(np.float32),
        "rgb": rng.uniform(0.1, 0.9, (1, t, 3, nodes, nodes)).astype(np.float32),
        "jacobian": np.ones(1, np.uint8),
        "valid": np.packbits(np.ones(count, bool)),
        "description": np.frombuffer(b"made up", np.uint8),
    }


def put(folder: Path, fields: Fields | bytes) -> Path:
    path = folder / "made.bsdf"
    path.write_bytes(fields if isinstance(fields, bytes) else tensor_file(fields))
    return path


def read(folder: Path, fields: Fields | bytes, **options: Any) -> Any:
    assert SHEET.read_samples is not None
    return SHEET.read_samples(put(folder, fields), **options)


def test_the_warp_inverts_itself() -> None:
    rng = np.random.default_rng(1)
    warp = Warp.of(rng.uniform(0.0, 1.0, (2, 7, 5)) ** 4)
    s_x, s_y = np.linspace(0.0, 1.0, 9), np.linspace(0.0, 1.0, 11)
    points = warp.forward(1, s_x, s_y)
    n = points[..., 0].size
    for index, fraction in ((1, 0.0), (0, 1.0)):
        padded = Warp(
            *(np.concatenate([a, a[-1:]]) for a in (warp.density, warp.along_x, warp.along_y))
        )
        back_x, back_y = padded.inverse(
            np.full(n, index), np.full(n, fraction), points[..., 0].ravel(), points[..., 1].ravel()
        )
        np.testing.assert_allclose(back_x.reshape(11, 9), np.tile(s_x, (11, 1)), atol=1e-12)
        np.testing.assert_allclose(back_y.reshape(11, 9), np.tile(s_y[:, None], 9), atol=1e-12)


def test_the_warp_agrees_with_integrals_done_by_hand() -> None:
    # p = (1 + b x y) / (1 + b / 4): M = (y + b y^2 / 4) / (1 + b / 4),
    # C = (x + b x^2 y / 2) / (1 + b y / 2); x and y are not interchangeable
    b = 6.0
    node_x, node_y = np.meshgrid(np.linspace(0, 1, 6), np.linspace(0, 1, 4))
    warp = Warp.of(np.stack([1.0 + b * node_x * node_y, np.ones_like(node_x)]))
    rng = np.random.default_rng(2)
    x, y = rng.uniform(0.0, 1.0, (2, 50))
    index = np.zeros(50, dtype=np.int64)
    s_x, s_y = warp.inverse(index, np.zeros(50), x, y)
    np.testing.assert_allclose(s_y, (y + b * y**2 / 4) / (1 + b / 4), rtol=1e-12)
    np.testing.assert_allclose(s_x, (x + b * x**2 * y / 2) / (1 + b * y / 2), rtol=1e-12)
    # half way between two parameters the densities, not the warps, are averaged
    s_x, s_y = warp.inverse(index, np.full(50, 0.5), x, y)
    np.testing.assert_allclose(s_y, ((y + b * y**2 / 4) / (1 + b / 4) + y) / 2, rtol=1e-12)


def test_where_a_density_vanishes_the_warp_stays_at_the_edge_of_what_is_left() -> None:
    density = np.ones((1, 5, 5))
    density[:, :, 3:] = 0.0
    points = Warp.of(density).forward(0, np.array([0.0, 1.0]), np.array([0.0, 1.0]))
    np.testing.assert_allclose(points[..., 0], [[0.0, 0.75], [0.0, 0.75]])


def test_a_node_is_the_reflection_at_its_normal_and_its_value_is_divided_by_the_cosine_once(
    tmp_path: Path,
) -> None:
    # uniform densities: the lattice stays where it is, x = s_x and y = s_y
    fields = small_fields(nodes=3, angles=(0.3, 0.9))
    fields["vndf"][:] = 1.0
    fields["ndf"][:] = 2.0
    samples = read(tmp_path, fields)
    number = 9 + 3 * 1 + 1  # second incidence, middle row, middle column
    theta_m = 0.5**2 * np.pi / 2  # x = 1/2; y = 1/2 is phi_m = 0, the azimuth of wi
    theta_i = float(np.float32(0.9))
    np.testing.assert_allclose(samples.wi[number], [np.sin(theta_i), 0.0, np.cos(theta_i)])
    theta_o = 2 * theta_m - theta_i
    expected = directions_from_spherical(np.array(theta_o), np.array(0.0))
    np.testing.assert_allclose(samples.wo[number], expected, atol=1e-12)
    stored = fields["rgb"][0, 1, :, 1, 1].astype(float)
    value = stored * 2.0 / (4 * float(np.float32(0.8))) / np.cos(theta_o)
    np.testing.assert_allclose(samples.value[number], value, rtol=1e-12)
    assert samples.rows[number] == number + 1


def test_every_node_becomes_a_sample_and_none_below_the_horizon_has_a_value(
    tmp_path: Path,
) -> None:
    samples = read(tmp_path, small_fields(nodes=5, resolution=3, angles=(0.0, 0.7, 1.2)))
    assert len(samples) == 3 * 25
    below = samples.wo[:, 2] <= 0.0
    assert below.any()
    assert np.array_equal(below, (samples.bits & Flag.BELOW_HORIZON) != 0)
    assert np.isnan(samples.value[below]).all()
    assert np.isfinite(samples.value[~below]).all()


def test_reading_without_the_jacobian_gives_the_stored_value_over_the_cosine(
    tmp_path: Path,
) -> None:
    fields = small_fields(nodes=3)
    fields["jacobian"] = np.zeros(1, np.uint8)
    samples = read(tmp_path, fields)
    stored = fields["rgb"][0].transpose(0, 2, 3, 1).reshape(-1, 3)
    above = samples.usable.all(axis=1)
    weighted = samples.value[above] * samples.wo[above, 2:]
    np.testing.assert_allclose(weighted, stored[above], rtol=1e-6)


@pytest.mark.parametrize("set_means_valid", [True, False])
def test_nodes_that_the_file_marks_invalid_are_rejected_whichever_way_the_bits_are_meant(
    tmp_path: Path, set_means_valid: bool
) -> None:
    fields = small_fields(nodes=5, resolution=3)
    above = ~((read(tmp_path, fields).bits & Flag.BELOW_HORIZON) != 0)
    marked = np.flatnonzero(above)[[2, 5]]
    accepted = above.copy()
    accepted[marked] = False
    fields["valid"] = np.packbits(accepted if set_means_valid else ~accepted)
    samples = read(tmp_path, fields)
    assert np.array_equal(np.flatnonzero(samples.bits & Flag.REJECTED), marked)
    assert not samples.usable[marked].any()


def test_an_incidence_at_the_horizon_is_rejected_and_said(tmp_path: Path) -> None:
    samples = read(tmp_path, small_fields(angles=(0.0, 1.2, 1.5707962)))
    last = samples.wi[:, 2] < 1e-3
    unusable = Flag.REJECTED | Flag.BELOW_HORIZON
    assert last.sum() == 4
    assert ((samples.bits[last] & unusable) != 0).all()
    assert "last measured is 68.8 degrees" in samples.source.notes[0]


def test_half_reads_one_side_of_the_plane_of_incidence(tmp_path: Path) -> None:
    whole = read(tmp_path, small_fields(nodes=4))
    half = read(tmp_path, small_fields(nodes=4), half=True)
    assert len(half) * 2 == len(whole)
    assert (half.wo[:, 1] >= -1e-12).all()
    assert set(half.rows) < set(whole.rows)


def test_spectral_files_keep_their_wavelengths(tmp_path: Path) -> None:
    fields = small_fields()
    fields.pop("rgb")
    fields["wavelengths"] = np.array([450.0, 550.0], np.float32)
    fields["spectra"] = np.full((1, 2, 2, 2, 2), 0.5, np.float32)
    samples = read(tmp_path, fields)
    assert samples.channels == ("450nm", "550nm")
    fields["wavelengths"] = np.linspace(400.0, 700.0, 150).astype(np.float32)
    fields["spectra"] = np.full((1, 2, 150, 2, 2), 0.5, np.float32)
    assert SHEET.read_table is not None
    with pytest.raises(UsageError, match=r"150 channels would take 1\.6 GiB"):
        SHEET.read_table(put(tmp_path, fields))


def test_anisotropic_files_are_refused_by_name(tmp_path: Path) -> None:
    fields = small_fields()
    fields["phi_i"] = np.linspace(0.0, 3.0, 4).astype(np.float32)
    with pytest.raises(FormatError, match=r"anisotropic measurement .4 azimuths"):
        read(tmp_path, fields)


def changed(**arrays: np.ndarray) -> Callable[[], bytes]:
    return lambda: tensor_file({**small_fields(), **arrays})


def without(name: str) -> bytes:
    fields = small_fields()
    fields.pop(name)
    return tensor_file(fields)


NEGATIVE = np.full((1, 2, 2, 2), -1.0, np.float32)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (lambda: b"Source  Measured\n" * 9, "Zemax and LightTools"),
        (lambda: b"tensor_file\0\x02\x00" + bytes(40), r"version 2\.0"),
        (lambda: b"tensor_file\0\x01\x00" + b"\xff" * 40, "has room for 2 at most"),
        (lambda: without("vndf"), "field 'vndf' is missing. Found: phi_i"),
        (lambda: without("rgb"), "field 'rgb' is missing"),
        (lambda: without("jacobian"), "field 'jacobian' is missing"),
        (
            changed(rgb=np.ones((1, 2, 4, 2, 2), np.float32)),
            r"'rgb' has the shape \(1, 2, 4, 2, 2\)",
        ),
        (
            changed(rgb=np.ones((1, 2, 3, 1, 9), np.float32)),
            r"'rgb' has .*from 2 x 2 to 4096 x 4096",
        ),
        (changed(vndf=np.ones((1, 3, 2, 2), np.float32)), r"but \(1, 2, any, any\) was expected"),
        (changed(vndf=np.ones((1, 2, 1, 8), np.float32)), "'vndf' has .*from 2 x 2"),
        (changed(vndf=np.zeros((1, 2, 2, 2), np.float32)), "zero everywhere at incidence 1 of 2"),
        (changed(vndf=NEGATIVE), "'vndf' has 8 values that are negative or not finite"),
        (changed(ndf=np.full((2, 2), np.nan, np.float32)), "'ndf' has 4 values"),
        (changed(sigma=np.ones((2, 2), np.uint8)), "'sigma' holds uint8 but floats"),
        (changed(theta_i=np.array([1.0, 0.0], np.float32)), "ascending angles from 0 to pi/2"),
        (changed(theta_i=np.array([0.0, 45.0], np.float32)), r"ascending .*\(radians\)"),
        (changed(theta_i=np.array([0.0], np.float32)), "at least 2 are needed"),
        (changed(rgb=np.ones((1, 2, 3, 5000, 2), np.float32)), "5000, 2. but from 2 x 2 to 4096"),
        (changed(jacobian=np.full(1, 7, np.uint8)), "'jacobian' is 7 but 0 or 1"),
        (changed(valid=np.ones(5, np.uint8)), r"'valid' has the shape \(5,\) but \(1\)"),
        (changed(valid=np.ones(1, np.uint16)), "'valid' holds uint16"),
        (changed(phi_i=np.zeros((0,), np.float32)), "which holds nothing"),
    ],
)
def test_damage_is_named(tmp_path: Path, content: Callable[[], bytes], message: str) -> None:
    with pytest.raises(CorruptFile, match=message):
        read(tmp_path, content())


def test_a_file_cut_anywhere_is_reported_as_damaged(tmp_path: Path) -> None:
    content = tensor_file(small_fields())
    assert len(read(tmp_path, content)) == 8
    for end in range(len(content)):
        with pytest.raises(CorruptFile):
            measurement_from_bytes(content[:end], "made.bsdf")


def test_no_altered_byte_of_the_header_does_more_than_raise_an_error_of_ours() -> None:
    content = tensor_file(small_fields())
    header = content.index(
        np.zeros(1, np.float32).tobytes() + np.array([0, 1.2], np.float32).tobytes()
    )
    outcomes = {"read": 0, "refused": 0}
    for position in range(header):
        for value in (0, 1, 11, 255):
            altered = bytearray(content)
            altered[position] = value
            try:
                Parameterisation.of(measurement_from_bytes(bytes(altered), "made.bsdf")).nodes()
                outcomes["read"] += 1
            except FormatError:
                outcomes["refused"] += 1
    assert outcomes["refused"] > 5 * outcomes["read"] / 2
    assert outcomes["read"] > 0


@pytest.mark.parametrize(
    ("shape", "offset", "message"),
    [
        ((2**62, 2**62), 64, "It looks truncated"),
        ((1,), 2**63, "It looks truncated"),
        ((1,), 3, "inside the header"),
    ],
)
def test_absurd_sizes_are_refused_before_memory_is_taken(
    shape: tuple[int, ...], offset: int, message: str
) -> None:
    content = b"tensor_file\0\x01\x00" + struct.pack("<IH", 1, 1) + b"a"
    content += struct.pack("<HBQ", len(shape), 11, offset) + struct.pack(f"<{len(shape)}Q", *shape)
    with pytest.raises(CorruptFile, match=message):
        read_fields(content + bytes(64), "made.bsdf")


def test_only_tensor_files_are_recognised() -> None:
    path = Path("a.bsdf")
    assert SHEET.sniff(path, tensor_file(small_fields()))
    assert not SHEET.sniff(path, b"Source  Measured")
    assert not SHEET.sniff(path, b"")


def test_options_that_do_not_apply_are_refused(tmp_path: Path) -> None:
    assert SHEET.read_table is not None
    with pytest.raises(UsageError, match="always read from all"):
        SHEET.read_table(put(tmp_path, small_fields()), half=True)
    with pytest.raises(UsageError, match="samples have none to fill"):
        read(tmp_path, small_fields(), extrapolate=True)


@pytest.mark.parametrize("name", FILES)
def test_the_real_files_agree_with_their_own_record_of_the_horizon(
    shared_data: Path, name: str
) -> None:
    # `valid` marks the nodes below the horizon: 7 x 1024 bits that only the right warp,
    # in the right order of axes, reproduces; five files set the bits above, four below.
    assert SHEET.read_samples is not None
    path = shared_data / "rgl" / f"{name}_rgb.bsdf"
    samples = SHEET.read_samples(path)
    assert len(samples) == 8 * 32 * 32
    bits = measurement_from_bytes(path.read_bytes(), name).bits
    assert bits is not None
    below = samples.wo[:, 2].reshape(8, -1)[:7] <= 0.0
    marked = bits.reshape(8, -1)[:7]
    assert np.array_equal(marked, below) or np.array_equal(marked, ~below)
    assert not (samples.bits[: 7 * 1024] & Flag.REJECTED).any()
    assert any("mirrored" in note for note in samples.source.notes)


def test_white_paper_is_reciprocal_only_with_the_cosine_divided_out_and_reflects_less_than_it_gets(
    shared_data: Path, random_directions: Callable[[int], tuple[FloatArray, FloatArray]]
) -> None:
    content = (shared_data / "rgl" / "paper_white_rgb.bsdf").read_bytes()
    paper = Parameterisation.of(measurement_from_bytes(content, "paper"))
    wi, wo = random_directions(5000)
    away_from_grazing = np.minimum(wi[:, 2], wo[:, 2]) > 0.25
    wi, wo = wi[away_from_grazing], wo[away_from_grazing]
    there, back = paper.evaluate(wi, wo), paper.evaluate(wo, wi)
    apart = np.median(np.abs(np.log(there / back)))
    undivided = np.median(np.abs(np.log(there * wo[:, 2:] / (back * wi[:, 2:]))))
    assert apart < 0.03
    assert undivided > 0.2
    # albedo: mean of pi f_r over cosine-distributed wo
    rng = np.random.default_rng(3)
    theta = np.arcsin(np.sqrt(rng.uniform(0.0, 0.999, 20000)))
    wo = directions_from_spherical(theta, rng.uniform(-np.pi, np.pi, 20000))
    for theta_i in (0.1, 0.7, 1.1):
        wi = np.broadcast_to([np.sin(theta_i), 0.0, np.cos(theta_i)], wo.shape)
        albedo = np.pi * paper.evaluate(wi, wo).mean(axis=0)
        assert (albedo > 0.75).all()
        assert (albedo < 1.0).all()


def test_the_table_of_a_real_file_agrees_with_its_samples(
    shared_data: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # a coarser grid than MERL's, for the time it takes
    monkeypatch.setattr("brdfit.formats.rgl.read.MERL_GRID", Grid(60, 60, 60))
    assert SHEET.read_table is not None
    assert SHEET.read_samples is not None
    path = shared_data / "rgl" / "paper_white_rgb.bsdf"
    table, samples = SHEET.read_table(path), SHEET.read_samples(path)
    good = samples.positive.all(axis=1)
    ratio = np.log(table.evaluate(samples.wi[good], samples.wo[good]) / samples.value[good])
    assert np.median(np.abs(ratio)) < 0.02
    wi, wo = table.grid.directions(table.grid.cells)
    both_grazing = np.maximum(wi[:, 2], wo[:, 2]) < np.cos(np.radians(78.4))
    assert 0.02 < table.missing / table.grid.cells.size < 0.10
    invalid = ~table.mask.reshape(-1)[table.grid.cells]
    assert not (invalid & ~both_grazing).any()
    whole = SHEET.read_table(path, extrapolate=True)
    assert whole.missing == 0
    assert np.array_equal(whole.values[table.mask], table.values[table.mask])
