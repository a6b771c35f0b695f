"""The MERL materials decoded into small neural networks (Sztrajman et al. 2021).

Each member of the published archive is a network 6-21-21-3: the half and difference vector
(hx, hy, hz, dx, dy, dz), with the half vector at azimuth 0, goes through two layers of
rectified units, and f_r = max(exp(y) - 1, 0) for R, G and B in 1/sr.

A network was taught phi_d in [0, pi) only and knows nothing of reciprocity, so it is asked
at phi_d wrapped into that half: exchanging wi and wo then gives the same value exactly. It
is not symmetric about pi/2, and need not agree with itself across the seam at phi_d = pi.

Reference: A. Sztrajman, G. Rainer, T. Ritschel, T. Weyrich, "Neural BRDF Representation and
Importance Sampling", Computer Graphics Forum 40(6), 2021. Archive: MIT licence.
"""

from __future__ import annotations

import io
import os
import zipfile
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from types import ModuleType

import numpy as np

from brdfit.arrays import FloatArray, IntArray, as_directions
from brdfit.errors import MissingExtra, PopulationError
from brdfit.files import sha256_of_bytes
from brdfit.geometry import half_diff_from_directions, wrap_phi_d
from brdfit.populations.contract import member_values

__all__ = ["NBRDF_SHA256", "DecodedNetworks", "read_nbrdf"]

NBRDF_SHA256 = "d1678c0cc5059f315d3d3284f36f3082787474106d72e3cae41fbad76d8f271a"
"""SHA-256 of the archive that its authors published."""

CHANNELS = ("R", "G", "B")
_LAYERS = ("dense_1", "dense_2", "dense_3")
_SHAPES = ((6, 21), (21, 21), (21, 3))

# Raise it when a change of the evaluation changes values.
_VERSION = 1
# Directions of a block: its activations (2100 x block, float32) stay near the processor.
_BLOCK = 1024


@dataclass(frozen=True, eq=False)
class DecodedNetworks:
    """A `MemberSource` over m networks, evaluated together."""

    name: str
    """What the user called it."""
    members: tuple[str, ...]
    """Material names, sorted."""
    fingerprint: str
    """SHA-256 of the archive and the version of its evaluation."""
    weights: tuple[FloatArray, FloatArray, FloatArray]
    """Transposed kernels (m, outputs, inputs) of the three layers, float32."""
    biases: tuple[FloatArray, FloatArray, FloatArray]
    """(m, outputs, 1), float32."""
    notes: tuple[str, ...] = ()
    """What is unusual about the archive."""

    @property
    def materials(self) -> tuple[str, ...]:
        """A network is a material."""
        return self.members

    @property
    def channels(self) -> tuple[str, ...]:
        """R, G, B."""
        return CHANNELS

    @property
    def bilateral(self) -> bool:
        """No: phi_d and pi - phi_d are different inputs of a network."""
        return False

    def evaluate(self, wi: FloatArray, wo: FloatArray, pick: IntArray) -> FloatArray:
        """Return f_r (n, len(pick), 3), float32, at direction pairs (n, 3); 0 below the horizon."""
        wi, wo = as_directions("wi", wi), as_directions("wo", wo)
        pick = np.asarray(pick)
        weights = [weight[pick] for weight in self.weights]
        biases = [bias[pick] for bias in self.biases]
        below = (wi[:, 2] <= 0.0) | (wo[:, 2] <= 0.0)
        inputs = _inputs(wi, wo)
        by_channel = np.empty((len(CHANNELS), len(wi), len(pick)), dtype=np.float32)
        for start in range(0, len(wi), _BLOCK):
            rows = slice(start, start + _BLOCK)
            signal = inputs[:, rows]
            for weight, bias in zip(weights[:2], biases[:2], strict=True):
                signal = np.matmul(weight, signal)
                signal += bias
                np.maximum(signal, 0.0, out=signal)
            signal = np.matmul(weights[2], signal)
            signal += biases[2]
            np.expm1(signal, out=signal)
            # (members, channels, n) -> (channels, n, members)
            np.maximum(signal.transpose(1, 2, 0), 0.0, out=by_channel[:, rows])
        by_channel[:, below] = 0.0
        return member_values(by_channel)


def read_nbrdf(path: str | os.PathLike[str], name: str | None = None) -> DecodedNetworks:
    """Return the networks of the archive at `path`.

    Raises `PopulationError` where the file is no such archive, naming the entry at fault,
    and `MissingExtra` without h5py. An archive with another hash than the published one is
    used, and says so in `notes`.
    """
    path = Path(path)
    h5py = _h5py()
    try:
        content = path.read_bytes()
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            entries = {
                PurePosixPath(entry).stem: archive.read(entry)
                for entry in archive.namelist()
                if entry.endswith(".h5")
            }
    except (OSError, zipfile.BadZipFile) as error:
        raise PopulationError(
            f"{path.name}: not a readable zip archive of networks ({error}). Fetch it with: "
            f"brdfit basis fetch nbrdf"
        ) from error
    if not entries:
        raise PopulationError(
            f"{path.name}: found no .h5 file in the archive but expected one network per "
            f"material. Is it the archive of the decoded MERL networks?"
        )
    members = tuple(sorted(entries))
    layers = [_read_layers(h5py, member, entries[member]) for member in members]
    sha256 = sha256_of_bytes(content)
    kernels = [np.stack([layer[index][0].T for layer in layers]) for index in range(3)]
    biases = [np.stack([layer[index][1][:, None] for layer in layers]) for index in range(3)]
    return DecodedNetworks(
        name=name or path.name,
        members=members,
        fingerprint=sha256_of_bytes(f"nbrdf {_VERSION} {sha256}".encode()),
        weights=(kernels[0], kernels[1], kernels[2]),
        biases=(biases[0], biases[1], biases[2]),
        notes=_notes(path.name, sha256),
    )


def _notes(name: str, sha256: str) -> tuple[str, ...]:
    if sha256 == NBRDF_SHA256:
        return ()
    return (
        f"{name}: SHA-256 is {sha256[:16]}... but the published archive has "
        f"{NBRDF_SHA256[:16]}...; it was altered, or is another edition",
    )


def _h5py() -> ModuleType:
    try:
        import h5py
    except ImportError as error:
        raise MissingExtra("h5py", "networks", "Reading the decoded networks") from error
    module: ModuleType = h5py
    return module


def _read_layers(
    h5py: ModuleType, member: str, content: bytes
) -> list[tuple[FloatArray, FloatArray]]:
    layers = []
    try:
        with h5py.File(io.BytesIO(content), "r") as file:
            for layer, shape in zip(_LAYERS, _SHAPES, strict=True):
                kernel = np.array(file[f"{layer}/{layer}/kernel:0"], dtype=np.float32)
                bias = np.array(file[f"{layer}/{layer}/bias:0"], dtype=np.float32)
                if kernel.shape != shape or bias.shape != shape[1:]:
                    raise PopulationError(
                        f"network {member!r}: layer {layer} has shape {kernel.shape} but the "
                        f"networks of the archive are 6-21-21-3 and this layer {shape}."
                    )
                layers.append((kernel, bias))
    except (OSError, KeyError) as error:
        raise PopulationError(
            f"network {member!r}: not a Keras file with layers {', '.join(_LAYERS)} ({error}). "
            f"The archive is damaged; fetch it again with: brdfit basis fetch nbrdf"
        ) from error
    return layers


def _inputs(wi: FloatArray, wo: FloatArray) -> FloatArray:
    """Return (hx, hy, hz, dx, dy, dz) as (6, n), float32, half vector at azimuth 0."""
    theta_h, theta_d, phi_d = half_diff_from_directions(wi, wo)
    phi_d = wrap_phi_d(phi_d)
    sin_d = np.sin(theta_d)
    rows = (
        np.sin(theta_h),
        np.zeros_like(theta_h),
        np.cos(theta_h),
        sin_d * np.cos(phi_d),
        sin_d * np.sin(phi_d),
        np.cos(theta_d),
    )
    return np.stack(rows).astype(np.float32)
