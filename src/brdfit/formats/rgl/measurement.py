"""The fields of an isotropic RGL measurement, each checked, and what they mean.

| field         | shape                            | meaning                                    |
|---------------|----------------------------------|--------------------------------------------|
| `phi_i`       | (1,)                             | azimuths of wi, radians; more = anisotropic |
| `theta_i`     | (t,)                             | polar angles of wi, radians, ascending     |
| `ndf`         | (>= 2, >= 2), rows phi_m          | D(wm), 1/sr                                |
| `sigma`       | (>= 2, >= 2), rows phi_i          | projected area of the microsurface         |
| `vndf`        | (1, t, >= 2, >= 2), rows phi_m    | density of visible normals, any scale      |
| `rgb`         | (1, t, 3, r, k)                  | f_r cos(theta_o) 4 sigma / D, linear sRGB  |
| `spectra`     | (1, t, w, r, k)                  | the same, in place of `rgb`, per wavelength |
| `wavelengths` | (w,)                             | nm, with `spectra`                         |
| `jacobian`    | (1,)                             | 1: D / (4 sigma) was divided out           |
| `valid`       | (t r k / 8,)                     | a bit for each node, first node = high bit |
| `description` | (characters,)                    | text                                       |

In the nine files at hand the bits of `valid` mark exactly the nodes whose wo is above the
horizon, in five of them; in the other four they mark exactly those below it. Which of the
two a file does can only be told from the directions, so that is left to the reader.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from brdfit.arrays import BoolArray, FloatArray
from brdfit.errors import CorruptFile, FormatError
from brdfit.formats.rgl.container import read_fields, written_fields
from brdfit.tone import LUMINANCE

__all__ = ["Measurement", "measurement_from_bytes", "measurement_to_bytes"]

_HORIZON_TOLERANCE = 1e-3
# Along one axis; a damaged shape must not make an outer product of two long axes.
_MOST_NODES = 4096


@dataclass(frozen=True)
class Measurement:
    """An isotropic measurement with t incidence angles and r x k nodes at each, float64."""

    theta_i: FloatArray
    """(t,) radians, ascending."""
    ndf: FloatArray
    """(rows, columns) over the unit square of phi_m, theta_m."""
    sigma: FloatArray
    """(rows, columns) over the unit square of phi_i, theta_i."""
    vndf: FloatArray
    """(t, rows, columns) over the unit square of phi_m, theta_m."""
    values: FloatArray
    """(t, r, k, channels) as stored: the cosine included, D / (4 sigma) divided out."""
    wavelengths: FloatArray | None
    """(channels,) nm, or None for linear sRGB."""
    jacobian: bool
    """Whether D / (4 sigma) was divided out of `values`."""
    bits: BoolArray | None
    """(t, r, k) the bits of `valid`, whose sense differs between files; None without it."""
    description: str


def measurement_from_bytes(content: bytes, name: str) -> Measurement:
    """Return the measurement in a whole file; `name` is the file's name for messages.

    Raises `CorruptFile` for the first field that is missing or not as in the table above,
    `FormatError` for an anisotropic measurement.
    """
    fields = _Fields(read_fields(content, name), name)
    _refuse_anisotropic(fields)
    theta_i = fields.floats("theta_i", (None,))
    _check_angles(theta_i, name)
    t = theta_i.size
    values, wavelengths = _values(fields, t)
    return Measurement(
        theta_i=theta_i,
        ndf=fields.not_negative("ndf", (None, None)),
        sigma=fields.not_negative("sigma", (None, None)),
        vndf=_vndf(fields, t),
        values=values,
        wavelengths=wavelengths,
        jacobian=_jacobian(fields),
        bits=_bits(fields, values.shape[:3]),
        description=_text(fields.optional("description")),
    )


def measurement_to_bytes(measurement: Measurement) -> bytes:
    """Return the whole file; `measurement_from_bytes` reads it back, in float32.

    `luminance`, by which renderers draw directions, is the mean of what is above zero in the
    channels, weighted as linear sRGB is where there are no wavelengths.
    """
    m = measurement
    spectral = m.wavelengths is not None
    weight = np.full(m.values.shape[3], 1.0 / m.values.shape[3]) if spectral else LUMINANCE
    luminance = np.maximum(m.values, 0.0) @ np.asarray(weight)
    # by a density that is zero everywhere nothing can be drawn
    luminance[luminance.sum(axis=(1, 2)) <= 0.0] = 1.0
    planes = m.values.transpose(0, 3, 1, 2)
    fields: dict[str, npt.NDArray[Any]] = {
        "description": np.frombuffer((m.description or " ").encode("utf-8"), np.uint8),
        "phi_i": np.zeros(1),
        "theta_i": m.theta_i,
        "sigma": m.sigma,
        "ndf": m.ndf,
        "vndf": m.vndf[None],
        "luminance": luminance[None],
        "spectra" if spectral else "rgb": planes[None],
        "jacobian": np.array([m.jacobian], np.uint8),
    }
    if m.wavelengths is not None:
        fields["wavelengths"] = m.wavelengths
    if m.bits is not None:
        fields["valid"] = np.packbits(m.bits)
    single = {k: a.astype(np.float32) if a.dtype.kind == "f" else a for k, a in fields.items()}
    return written_fields(single)


@dataclass(frozen=True)
class _Fields:
    """Access by name with one condition checked at a time."""

    arrays: Mapping[str, npt.NDArray[Any]]
    file: str

    def optional(self, name: str) -> npt.NDArray[Any] | None:
        return self.arrays.get(name)

    def require(self, name: str, shape: tuple[int | None, ...]) -> npt.NDArray[Any]:
        """Return a field whose shape fits; None in `shape` stands for any size."""
        if name not in self.arrays:
            raise CorruptFile(
                f"{self.file}: the field {name!r} is missing. Found: {', '.join(self.arrays)}. "
                f"An RGL measurement has it; is this a tensor file of another kind?"
            )
        array = self.arrays[name]
        fits = len(array.shape) == len(shape) and all(
            want is None or want == have for want, have in zip(shape, array.shape, strict=True)
        )
        if not fits:
            expected = ", ".join("any" if size is None else str(size) for size in shape)
            raise CorruptFile(
                f"{self.file}: field {name!r} has the shape {array.shape} but ({expected}) was "
                f"expected. The file is damaged or of another version."
            )
        return array

    def floats(self, name: str, shape: tuple[int | None, ...]) -> FloatArray:
        array: npt.NDArray[Any] = self.require(name, shape)
        if array.dtype.kind != "f":
            raise CorruptFile(
                f"{self.file}: field {name!r} holds {array.dtype.name} but floats were expected."
            )
        return array.astype(np.float64)

    def lattice(self, name: str, shape: tuple[int | None, ...]) -> FloatArray:
        """Return floats that can be interpolated in their last two axes."""
        array = self.floats(name, shape)
        if min(array.shape[-2:]) < 2 or max(array.shape[-2:]) > _MOST_NODES:
            raise CorruptFile(
                f"{self.file}: field {name!r} has the shape {array.shape} but from 2 x 2 to "
                f"{_MOST_NODES} x {_MOST_NODES} nodes were expected in the last two dimensions."
            )
        return array

    def not_negative(self, name: str, shape: tuple[int | None, ...]) -> FloatArray:
        """Return a lattice of finite values >= 0."""
        array = self.lattice(name, shape)
        wrong = np.count_nonzero(~(np.isfinite(array) & (array >= 0.0)))
        if wrong:
            raise CorruptFile(
                f"{self.file}: field {name!r} has {wrong} values that are negative or not finite, "
                f"but it must be >= 0 everywhere."
            )
        return array


def _refuse_anisotropic(fields: _Fields) -> None:
    phi_i = fields.floats("phi_i", (None,))
    if phi_i.size != 1:
        raise FormatError(
            f"{fields.file}: is an anisotropic measurement ({phi_i.size} azimuths of incidence in "
            f"'phi_i'), but brdfit reads isotropic ones only (1 azimuth)."
        )


def _check_angles(theta_i: FloatArray, name: str) -> None:
    if theta_i.size < 2:
        raise CorruptFile(f"{name}: field 'theta_i' has 1 angle but at least 2 are needed.")
    rising = bool(np.all(np.diff(theta_i) > 0.0))
    highest = np.pi / 2 + _HORIZON_TOLERANCE
    if not rising or theta_i[0] < 0.0 or theta_i[-1] > highest:
        raise CorruptFile(
            f"{name}: field 'theta_i' is {theta_i.tolist()} but ascending angles from 0 to pi/2 "
            f"(radians) were expected."
        )


def _values(fields: _Fields, t: int) -> tuple[FloatArray, FloatArray | None]:
    spectral = "rgb" not in fields.arrays and "spectra" in fields.arrays
    wavelengths = fields.floats("wavelengths", (None,)) if spectral else None
    channels = 3 if wavelengths is None else wavelengths.size
    name = "spectra" if spectral else "rgb"
    values = fields.lattice(name, (1, t, channels, None, None))[0]
    return np.ascontiguousarray(values.transpose(0, 2, 3, 1)), wavelengths


def _vndf(fields: _Fields, t: int) -> FloatArray:
    vndf: FloatArray = fields.not_negative("vndf", (1, t, None, None))[0]
    empty = np.flatnonzero(vndf.sum(axis=(1, 2)) <= 0.0)
    if empty.size:
        raise CorruptFile(
            f"{fields.file}: field 'vndf' is zero everywhere at incidence {empty[0] + 1} of {t}, "
            f"but the nodes are placed by it."
        )
    return vndf


def _jacobian(fields: _Fields) -> bool:
    stored = int(fields.require("jacobian", (1,))[0])
    if stored not in (0, 1):
        raise CorruptFile(f"{fields.file}: field 'jacobian' is {stored} but 0 or 1 was expected.")
    return stored == 1


def _bits(fields: _Fields, nodes: tuple[int, ...]) -> BoolArray | None:
    if fields.optional("valid") is None:
        return None
    count = int(np.prod(nodes))
    packed = fields.require("valid", ((count + 7) // 8,))
    if packed.dtype != np.uint8:
        raise CorruptFile(
            f"{fields.file}: field 'valid' holds {packed.dtype.name} but bits packed in uint8 were "
            f"expected."
        )
    return np.asarray(np.unpackbits(packed, count=count).reshape(nodes), dtype=bool)


def _text(description: npt.NDArray[Any] | None) -> str:
    if description is None:
        return ""
    return description.tobytes().decode("utf-8", errors="replace").strip("\0 \n")
