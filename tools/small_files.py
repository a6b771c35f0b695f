"""A small valid file of every format that can be read: what the fuzzer and the tests damage.

A format that can be written makes its own, from the fixtures below; one that is only read
has its file made by hand here. A test checks that no format is forgotten.
"""

from __future__ import annotations

import io
import struct
import warnings
import zipfile
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from brdfit.arrays import FloatArray
from brdfit.errors import BrdfitWarning, UsageError
from brdfit.formats import list_formats, write_samples, write_table
from brdfit.geometry import directions_from_spherical
from brdfit.grid import MERL_GRID, Grid
from brdfit.models.network import NETWORK_SHAPES
from brdfit.samples import Samples
from brdfit.table import Table
from small_panoramas import small_panoramas

from small_workbook import workbook

__all__ = [
    "ENVIRONMENT",
    "SmallFile",
    "network_file",
    "small_files",
    "tiny_samples",
    "tiny_table",
    "utia_numbers",
    "written_table",
]

ENVIRONMENT = "environment"
"""Format and kind of panoramas, which are no format of BRDFs but are read from files too."""

SMALL_GRID = Grid(6, 5, 8)

_RGB = ("R", "G", "B")


@dataclass(frozen=True)
class SmallFile:
    """A valid file, with those that belong to it."""

    format: str
    """Name of the data sheet."""
    kind: str
    """Which reader: "samples", "table" or `ENVIRONMENT`."""
    name: str
    """File name; what stands beside it is in `files` too."""
    files: dict[str, bytes]
    """File name -> content."""
    options: dict[str, Any] = field(default_factory=dict)
    """Keyword options for the reader."""
    share: float = 1.0
    """How often it is damaged beside the others: seldom where reading is slow."""

    @property
    def content(self) -> bytes:
        """The bytes of the file itself."""
        return self.files[self.name]

    @property
    def size(self) -> int:
        """Number of bytes of the file itself."""
        return len(self.content)


def tiny_samples(n: int = 12, channels: int = 3) -> Samples:
    """Return samples in which nothing may be exchanged unnoticed.

    Light and detector, x and y, left and right of the plane of incidence, and the channels
    all have values of their own.
    """
    k = np.arange(n)
    wi = directions_from_spherical(0.1 + 0.09 * k, 0.3 + 0.7 * k)
    wo = directions_from_spherical(1.3 - 0.07 * k, 2.0 - 0.4 * k)
    value = 0.05 + 0.1 * wi[:, :1] + 0.2 * (1 + wo[:, 1:2]) + 0.31 * np.arange(channels)
    return Samples(wi=wi, wo=wo, value=value * (1.0 + 0.01 * k[:, None]))


def tiny_table(grid: Grid = SMALL_GRID, channels: int = 3) -> Table:
    """Return a smooth table without any symmetry: not bilateral, no channel like another."""
    h, d, phi = np.meshgrid(grid.theta_h, grid.theta_d, grid.phi_d, indexing="ij")
    # sin 2 phi_d tells phi_d from pi - phi_d, and vanishes with phi_d's meaning at the poles
    skew = 0.6 * np.sin(h) * np.sin(d) * np.sin(2.0 * phi)
    planes = [
        0.1 * (c + 1) + (0.5 + 0.3 * c) * np.exp(-(2.0 + c) * h**2) * (1.0 + 0.2 * d) * (1.0 + skew)
        for c in range(channels)
    ]
    return Table(np.stack(planes, axis=-1), grid=grid, channels=_RGB if channels == 3 else ())


def written_table(name: str, path: Path, channels: int = 3) -> Table:
    """Write `tiny_table` in the format `name` and return it, on the MERL grid if need be."""
    table = tiny_table(channels=channels)
    try:
        write_table(table, path, format=name)
    except UsageError:
        table = tiny_table(MERL_GRID, channels)
        write_table(table, path, format=name)
    return table


def small_files(folder: Path) -> Iterator[SmallFile]:
    """Yield the small files of all formats; `folder` is where those are written that must be."""
    for sheet in list_formats():
        made = list(_written(sheet.name, folder))
        made += [small() for small in _BY_HAND.get(sheet.name, ())]
        yield from made
    yield from (SmallFile(ENVIRONMENT, ENVIRONMENT, n, {n: c}) for n, c in small_panoramas())


def _written(name: str, folder: Path) -> Iterator[SmallFile]:
    """Yield what a format writes itself, once for each kind that it reads and writes."""
    (sheet,) = (sheet for sheet in list_formats() if sheet.name == name)
    path = folder / f"written{sheet.extensions[0]}"
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", BrdfitWarning)
        if sheet.write_samples is not None and sheet.read_samples is not None:
            write_samples(tiny_samples(), path, format=name)
            yield SmallFile(name, "samples", path.name, {path.name: path.read_bytes()})
        if sheet.write_table is not None:
            written_table(name, path)
            for kind in ("samples", "table"):
                if getattr(sheet, f"read_{kind}") is not None and (
                    kind == "table" or sheet.write_samples is None
                ):
                    yield SmallFile(name, kind, path.name, {path.name: path.read_bytes()})


def _text(format: str, name: str, text: str, **options: Any) -> SmallFile:
    return SmallFile(format, "samples", name, {name: text.encode()}, options)


def _astm() -> SmallFile:
    rows = "".join(f"0.{k},0.0,0.{k},3.14,0.5,{k}.25\n" for k in range(10, 22))
    header = "LAB_NAME A\nSAMPLE_NAME B\nNUM_POINTS 12\n"
    return _text(
        "astm", "a.astm", f"{header}VARS theta_i,phi_i,theta_s,phi_s,400nm,500nm\n\n{rows}"
    )


def _nist() -> SmallFile:
    rows = "".join(
        f"0.{w},-{t},0,{t},20.5,3.1E-01,0.02\n" for w in (351, 532) for t in range(5, 17)
    )
    return _text("nist", "a.csv", f"lambda,thetai,phi,thetar,phir,f_r11,f_r12/f_r11\n{rows}")


def _curet() -> SmallFile:
    angles = np.random.default_rng(0).uniform(0.0, 1.4, (205, 4))
    directions = "\n".join(
        f"{k + 1} " + " ".join(f"{angle:.3f}" for angle in row) for k, row in enumerate(angles)
    )
    values = "1  " + " ".join(f"0.{k:03}" for k in range(205)) + "\n"
    files = {"a.dat": values.encode(), "table.txt": directions.encode()}
    return SmallFile("curet", "samples", "a.dat", files)


def _alta() -> SmallFile:
    rows = "".join(f"0.{k} 0.2 0.3 1\n" for k in range(9, 21))
    return _text("alta", "a.alta", f"#DIM 3 1\n#PARAM_IN RUSIN_TH_TD_PD\n{rows}")


def _delimited() -> SmallFile:
    rows = "".join(f"{k};0,5;{k + 3};-170;0,1;0,2;0,3;x\n" for k in range(20, 34))
    return _text("delimited", "a.csv", f"theta_i_deg;phi_i;theta_o;phi_o;r;g;b;sigma\n{rows}")


def _merl() -> SmallFile:
    planes = struct.pack("<30d", *(0.5 * k for k in range(30)))
    return SmallFile(
        "merl", "table", "cut.binary", {"cut.binary": struct.pack("<3i", 90, 90, 180) + planes}
    )


def _rgl() -> SmallFile:
    rng = np.random.default_rng(7)

    def floats(*shape: int) -> FloatArray:
        return rng.uniform(0.3, 0.9, shape).astype("<f4")

    fields = {
        "phi_i": np.zeros(1, "<f4"),
        "theta_i": np.array([0.0, 1.2], "<f4"),
        "sigma": floats(2, 2),
        "ndf": floats(2, 2),
        "vndf": floats(1, 2, 2, 2),
        "rgb": floats(1, 2, 3, 2, 2),
        "jacobian": np.ones(1, np.uint8),
        "description": np.frombuffer(b"made up", np.uint8),
    }
    return SmallFile("rgl", "samples", "a.bsdf", {"a.bsdf": _tensor_file(fields)})


def _rt300s() -> SmallFile:
    angles = [
        (a, i, r) for a in (-90.0, 0.0, 90.0) for i in (10.0, 50.0) for r in (-40.0, 0.0, 50.0)
    ]

    def content(stray: float) -> bytes:
        columns = [(*of, stray + 0.001 * k) for k, of in enumerate(angles)]
        labels = (" Azimuth", " Incidence", " Receive", " RT")
        rows: list[list[str | float | None]] = [[" Method", *["BRDF_LD"] * len(columns)]]
        rows += [[label, *(c[k] for c in columns)] for k, label in enumerate(labels)]
        return workbook([[row[:10] for row in rows], [[row[0], *row[10:]] for row in rows], []])

    files = {"a.xls": content(0.25), "blank.xls": content(0.01)}
    return SmallFile("rt300s", "samples", "a.xls", files)


def _lighttools() -> SmallFile:
    lines = ["# made up", "Symmetry PlaneSymmetrical", "SpectralContent Monochrome"]
    lines += ["ScatterAzimuth 3", "0 90 270", "ScatterRadial 3", "0 30 60", "DataBegin"]
    for aoi in (0, 30):
        for wave in (450, 550):
            lines += [f"AOI {aoi}", "POI 0", "Side Front", f"Wavelength {wave}", "ScatterType BRDF"]
            lines += ["TIS 0.5", *(f"0.{k}1 0.{k}2 0.{wave}" for k in range(1, 4))]
    return _text("lighttools", "a.bsdf", "\n".join([*lines, "DataEnd", ""]))


def _zemax() -> SmallFile:
    lines = ["# made up", "Source Measured", "Symmetry Asymmetrical", "SpectralContent XYZ"]
    lines += ["ScatterType BRDF", "SampleRotation 1", "0", "AngleOfIncidence 2", "10 50"]
    lines += ["ScatterAzimuth 3", "0 120 240", "ScatterRadial 3", "0 20 60"]
    for axis in "XYZ":
        lines += ["", f"Tristimulus{axis}", "DataBegin"]
        lines += ["TIS 0.5", "1e-1 2e-1 0", "1e-1 3E-1 .5", "1e-1 .4 .6"] * 2
        lines += ["DataEnd"]
    return _text("zemax", "a.bsdf", "\n".join(lines))


def network_file(seed: int = 5, shapes: Sequence[tuple[int, int]] = NETWORK_SHAPES) -> bytes:
    """Return the content of Keras' `.h5` with made-up weights."""
    import h5py

    rng, made = np.random.default_rng(seed), io.BytesIO()
    # the latest layout is half the size of Keras' own
    with h5py.File(made, "w", libver="latest") as file:
        for layer, shape in enumerate(shapes, start=1):
            group = file.create_group(f"dense_{layer}/dense_{layer}")
            group["kernel:0"] = rng.normal(0.0, 0.4, shape).astype("f4")
            group["bias:0"] = rng.normal(0.0, 0.2, shape[1]).astype("f4")
    return made.getvalue()


def _nbrdf() -> SmallFile:
    return SmallFile("nbrdf", "table", "a.h5", {"a.h5": network_file()}, share=0.2)


def _nbrdf_archive() -> SmallFile:
    made = io.BytesIO()
    with zipfile.ZipFile(made, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("any/walnut.h5", network_file(6))
    return SmallFile("nbrdf", "table", "a.zip", {"a.zip": made.getvalue()}, share=0.2)


def utia_numbers() -> FloatArray:
    """Return made-up numbers (plane, theta_i, phi_i, theta_v, phi_v) without any symmetry."""
    index = np.indices((3, 6, 48, 6, 48)).astype(float)
    plane, theta_i, phi_i, theta_v, phi_v = index
    return np.asarray(
        0.1 + 0.2 * plane + 0.03 * theta_i + 0.001 * phi_i + 0.05 * theta_v + 0.002 * phi_v
    )


def _utia() -> SmallFile:
    content = utia_numbers().astype("<f4").tobytes()
    return SmallFile("utia", "samples", "a.bin", {"a.bin": content}, {"count": 100})


def _astm_degrees() -> SmallFile:
    rows = "".join(f"{k},0.0,{k},180,.5,.01,{k}.25,.02,.3,.1\n" for k in range(10, 22))
    names = "R,sigma_R,G,sigma_G,B,sigma_B"
    header = f"SAMPLE_NAME B\nNUM_POINTS 12\nVARS theta_i,phi_i,theta_s,phi_s,{names}"
    return _text("astm", "d.astm", f"{header}\n\n{rows}", angles="degrees")


def _tensor_file(fields: dict[str, np.ndarray[Any, Any]]) -> bytes:
    """Return RGL's container, written from its description."""
    offset = 18 + sum(2 + len(name) + 11 + 8 * array.ndim for name, array in fields.items())
    header, data = b"tensor_file\0\x01\x00" + struct.pack("<I", len(fields)), b""
    for name, array in fields.items():
        header += struct.pack("<H", len(name)) + name.encode()
        kind = 1 if array.dtype == np.uint8 else 10
        header += struct.pack("<HBQ", array.ndim, kind, offset + len(data))
        header += struct.pack(f"<{array.ndim}Q", *array.shape)
        data += array.tobytes()
    return header + data


_BY_HAND: dict[str, tuple[Callable[[], SmallFile], ...]] = {
    "alta": (_alta,),
    "astm": (_astm, _astm_degrees),
    "curet": (_curet,),
    "delimited": (_delimited,),
    "merl": (_merl,),
    "nbrdf": (_nbrdf, _nbrdf_archive),
    "nist": (_nist,),
    "lighttools": (_lighttools,),
    "rgl": (_rgl,),
    "rt300s": (_rt300s,),
    "utia": (_utia,),
    "zemax": (_zemax,),
}
