"""Write brdfit's `.npz`. The same content gives the same bytes."""

from __future__ import annotations

import dataclasses
import json
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from brdfit.files import atomic_path
from brdfit.formats.npz.layout import HEADER, VERSION
from brdfit.samples import Samples, Source
from brdfit.table import Table

__all__ = ["write_samples", "write_table"]

# The earliest date that zip knows: no clock in the file.
_NO_DATE = (1980, 1, 1, 0, 0, 0)
_READABLE = 0o644 << 16


def write_samples(samples: Samples, path: Path) -> None:
    """Write samples with their flags, rows and source."""
    arrays = {
        "wi": samples.wi,
        "wo": samples.wo,
        "value": samples.value,
        "sigma": samples.sigma,
        "flags": samples.bits,
        "rows": samples.rows,
        "wavelengths": samples.wavelengths,
    }
    _write(path, _header("samples", samples.channels, samples.source), arrays)


def write_table(table: Table, path: Path) -> None:
    """Write a table with its mask and source, values in the precision they have."""
    arrays = {"values": table.values, "valid": table.mask, "wavelengths": table.wavelengths}
    _write(path, _header("table", table.channels, table.source), arrays)


def _header(kind: str, channels: tuple[str, ...], source: Source) -> npt.NDArray[Any]:
    content = {
        "version": VERSION,
        "kind": kind,
        "channels": list(channels),
        "source": dataclasses.asdict(source),
    }
    text = json.dumps(content, ensure_ascii=False, sort_keys=True)
    # a lone surrogate of an undecodable header field survives as its escape
    return np.frombuffer(text.encode("utf-8", errors="backslashreplace"), dtype=np.uint8)


def _write(path: Path, header: npt.NDArray[Any], arrays: dict[str, Any]) -> None:
    with atomic_path(path) as aside, zipfile.ZipFile(aside, "w", zipfile.ZIP_STORED) as archive:
        for name, array in {HEADER: header, **arrays}.items():
            if array is None:
                continue
            info = zipfile.ZipInfo(f"{name}.npy", _NO_DATE)
            info.external_attr = _READABLE
            with archive.open(info, "w", force_zip64=True) as stream:
                np.lib.format.write_array(stream, np.asarray(array), allow_pickle=False)
