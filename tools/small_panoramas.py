"""Small panoramas for the fuzzer: Radiance `.hdr` flat and packed, OpenEXR in its compressions."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np

__all__ = ["small_panoramas"]

_HEIGHT, _WIDTH = 8, 16
_COMPRESSIONS = ("NO", "ZIP", "PIZ", "B44A", "DWAA")


def small_panoramas() -> Iterator[tuple[str, bytes]]:
    """Yield (file name, content)."""
    rng = np.random.default_rng(9)
    head = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 8 +X 16\n"
    yield "flat.hdr", head + rng.bytes(_HEIGHT * _WIDTH * 4)
    row = b"\2\2\0\x10" + b"".join(bytes([136, k + 120, 8]) + bytes(range(8)) for k in range(4))
    yield "packed.hdr", head + row * _HEIGHT
    yield from _open_exr(rng)


def _open_exr(rng: np.random.Generator) -> Iterator[tuple[str, bytes]]:
    import OpenEXR

    with tempfile.TemporaryDirectory() as folder:
        for compression in _COMPRESSIONS:
            path = Path(folder) / f"{compression.lower()}.exr"
            pixels = rng.uniform(0.1, 2.0, (_HEIGHT, _WIDTH)).astype(np.float16)
            header = {
                "compression": getattr(OpenEXR, f"{compression}_COMPRESSION"),
                "type": OpenEXR.scanlineimage,
            }
            OpenEXR.File(header, dict.fromkeys("RGB", pixels)).write(str(path))
            yield path.name, path.read_bytes()
