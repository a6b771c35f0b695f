"""Weights of a decoded material from Keras' `.h5`: a file of its own, or one of an archive.

The layers dense_1, dense_2 and dense_3 hold what `brdfit.models.network` wants.
"""

from __future__ import annotations

import io
import zipfile
from pathlib import PurePosixPath
from types import ModuleType

import numpy as np

from brdfit.errors import CorruptFile, MissingExtra
from brdfit.models.network import NETWORK_SHAPES, Layer

__all__ = ["archived_networks", "read_layers", "require_h5py"]

_LAYERS = ("dense_1", "dense_2", "dense_3")
# A network of the published archive has 19 kB; what claims to be far more is none.
_MOST_BYTES = 1 << 22
_MOST_NETWORKS = 10_000


def require_h5py() -> ModuleType:
    """Return the library, or raise `MissingExtra`."""
    try:
        import h5py
    except ImportError as error:
        raise MissingExtra("h5py", "networks", "Reading the decoded networks") from error
    module: ModuleType = h5py
    return module


def archived_networks(content: bytes, name: str) -> dict[str, bytes]:
    """Return {material: content of its `.h5`} of an archive, by name.

    Raises `CorruptFile` where it is no archive, or holds no network.
    """
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            infos = [info for info in archive.infolist() if info.filename.endswith(".h5")]
            if len(infos) > _MOST_NETWORKS or any(i.file_size > _MOST_BYTES for i in infos):
                raise CorruptFile(
                    f"{name}: an entry claims more than {_MOST_BYTES >> 20} MiB, or there are more "
                    f"than {_MOST_NETWORKS:,}, which no archive of small networks has."
                )
            entries = {PurePosixPath(i.filename).stem: archive.read(i) for i in infos}
    except CorruptFile:
        raise
    except Exception as error:  # besides BadZipFile: of zlib, of odd methods, of passwords
        raise CorruptFile(f"{name}: not a readable zip archive of networks ({error}).") from error
    if not entries:
        raise CorruptFile(
            f"{name}: found no .h5 file in the archive but expected one network per material. Is "
            f"it the archive of the decoded MERL networks?"
        )
    return {material: entries[material] for material in sorted(entries)}


def read_layers(content: bytes, member: str) -> list[Layer]:
    """Return the three layers of a network from the content of its `.h5`.

    Raises `CorruptFile` naming the network and the layer, and `MissingExtra` without h5py.
    """
    h5py = require_h5py()
    layers: list[Layer] = []
    try:
        with h5py.File(io.BytesIO(content), "r") as file:
            for layer, shape in zip(_LAYERS, NETWORK_SHAPES, strict=True):
                kernel = _dataset(file[f"{layer}/{layer}/kernel:0"], shape, member, layer)
                bias = _dataset(file[f"{layer}/{layer}/bias:0"], shape[1:], member, layer)
                layers.append((kernel, bias))
    except CorruptFile:
        raise
    except Exception as error:  # the library raises whatever its C code finds
        raise CorruptFile(
            f"network {member!r}: not a Keras file with layers {', '.join(_LAYERS)} ({error}). "
            f"The file is damaged; fetch or export it again."
        ) from error
    return layers


def _dataset(
    dataset: object, shape: tuple[int, ...], member: str, layer: str
) -> np.ndarray[tuple[int, ...], np.dtype[np.float32]]:
    found = getattr(dataset, "shape", None)
    # before anything of it is read: a header may claim any size
    if found != shape:
        raise CorruptFile(
            f"network {member!r}: layer {layer} has shape {found} but the networks of the archive "
            f"are 6-21-21-3 and this layer {shape}."
        )
    numbers = np.array(dataset, dtype=np.float32)
    if not np.isfinite(numbers).all():
        raise CorruptFile(f"network {member!r}: layer {layer} holds a number that is not finite.")
    return numbers
