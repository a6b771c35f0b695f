"""Maps of a batch whose items have pixel positions: for renderers, and for exact evaluation.

    DIR/
        base_color.exr  specular.exr  roughness.exr      the material of every pixel
        material.mtlx                                    that uses them
        uncertainty.exr  outlier_share.exr  misfit.exr   how far to trust each pixel
        coefficients/00.exr ...  basis.npz               the atlas: ln f_r = mean + phi z
        preview.png                                      the patch under three lights
        record.json                                      what made them

Every pixel is what its own item says; nothing is taken from its neighbours, and where there is
no item, or one that failed, the maps are NaN.
"""

from __future__ import annotations

import json
import os
import shutil
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from brdfit.arrays import FloatArray, IntArray, normalize
from brdfit.batch import Batch
from brdfit.errors import UsageError
from brdfit.export.texture_fit import TextureFit
from brdfit.export.texture_material import write_texture_material
from brdfit.formats.exr_file import require_openexr, write_exr
from brdfit.progress import Progress, silent
from brdfit.reconstruct.compact import LeadingBasis
from brdfit.report.picture import write_picture
from brdfit.tone import display_image, exposure_scale

__all__ = ["write_textures"]

_LABEL = "textures"
_KEY = "brdfit_textures"
_CHUNK = 2048
_MOST_PIXELS = 1 << 26
_LIGHTS = ((-0.6, 0.5, 0.7), (0.1, 0.2, 1.2), (0.7, -0.6, 0.5))
_CAMERA = (0.0, 0.0, 2.5)


def write_textures(batch: Batch, folder: Path, progress: Progress = silent) -> None:
    """Write the maps of `batch` into `folder`, which appears when they are complete.

    Raises `UsageError` where items have no positions or are not R, G, B, or where `folder`
    holds something else; `MissingExtra` without OpenEXR or MaterialX.
    """
    require_openexr("Writing textures")
    place = Place.of(batch)
    if folder.exists() and not (folder / "record.json").is_file() and any(folder.iterdir()):
        raise UsageError(f"{folder}: holds other files; name a folder that is new or empty.")
    if not folder.resolve().parent.is_dir():
        raise UsageError(f"{folder}: the folder above it does not exist; create it first.")
    aside = Path(tempfile.mkdtemp(prefix=f".{folder.name}.", dir=folder.resolve().parent))
    try:
        _write(batch, place, aside, progress)
        aside.chmod(0o755)
        shutil.rmtree(folder, ignore_errors=True)
        os.replace(aside, folder)
    finally:
        shutil.rmtree(aside, ignore_errors=True)


@dataclass(frozen=True, eq=False)
class Place:
    """Where the items lie: pixel (column, row) of each, and the size of the maps."""

    pixel: IntArray
    """(items,) flat pixel; -1 for an item without a result or position."""
    height: int
    width: int

    @classmethod
    def of(cls, batch: Batch) -> Place:
        """Return the places of a batch; `UsageError` where they make no picture."""
        position = batch.column("position").astype(np.float64)
        there = np.isfinite(position).all(axis=1)
        if not there.any():
            raise UsageError(
                f"{batch.path.name}: its items have no pixel positions, so there is no texture. "
                f"Give a long table with columns x and y, or name them: --position X,Y."
            )
        if batch.channels != ("R", "G", "B"):
            raise UsageError(
                f"{batch.path.name}: textures are R, G, B but the items have "
                f"{', '.join(batch.channels)}."
            )
        whole = np.rint(position[there]).astype(np.int64)
        low, high = whole.min(axis=0), whole.max(axis=0)
        width, height = (int(n) for n in high - low + 1)
        if width * height > _MOST_PIXELS:
            raise UsageError(
                f"{batch.path.name}: positions span {width} x {height} pixels, more than "
                f"{_MOST_PIXELS:,}. Are they pixels?"
            )
        pixel = np.full(len(position), -1)
        pixel[there] = (whole[:, 1] - low[1]) * width + (whole[:, 0] - low[0])
        if len(np.unique(pixel[there])) < there.sum():
            raise UsageError(f"{batch.path.name}: several items have the same pixel position.")
        return cls(pixel, height, width)

    def blank(self, channels: int) -> FloatArray:
        """Return an empty map (pixels, channels)."""
        return np.full((self.height * self.width, channels), np.nan, dtype=np.float32)

    def shaped(self, flat: FloatArray) -> FloatArray:
        """Return a map (pixels, channels) as (height, width, channels)."""
        return flat.reshape(self.height, self.width, -1)

    def points(self, pixel: IntArray) -> FloatArray:
        """Return (n, 3): where pixels lie on a patch from -1 to 1, y up, z = 0."""
        size = max(self.height, self.width)
        x = (2.0 * (pixel % self.width) + 1.0 - self.width) / size
        y = -(2.0 * (pixel // self.width) + 1.0 - self.height) / size
        return np.stack([x, y, np.zeros(len(pixel))], axis=1)


def _write(batch: Batch, place: Place, folder: Path, progress: Progress) -> None:
    maps = {"base_color": 3, "specular": 3, "roughness": 1, "uncertainty": 1}
    maps |= {"outlier_share": 1, "misfit": 1}
    flat = {name: place.blank(channels) for name, channels in maps.items()}
    lit = [np.zeros((place.height * place.width, 3)) for _ in _LIGHTS]
    with tempfile.TemporaryFile(dir=folder) as scratch:
        atlas = np.memmap(
            scratch,
            dtype=np.float32,
            mode="w+",
            shape=(batch.basis.size, place.height * place.width, 3),
        )
        atlas[:] = np.nan
        for pixel, items, z in _blocks(batch, place, progress):
            _enter(batch, flat, pixel, items, z)
            atlas[:, pixel] = np.moveaxis(z, 2, 0)
            for light, picture in zip(_LIGHTS, lit, strict=True):
                picture[pixel] = _relit(batch.basis, place.points(pixel), np.array(light), z)
        _write_atlas(place, atlas, batch.basis, folder)
        del atlas
    for name, values in flat.items():
        _write_map(place.shaped(values), folder / f"{name}.exr")
    write_texture_material(folder / "material.mtlx", _said(batch))
    joined = np.concatenate([place.shaped(picture) for picture in lit], axis=1)
    write_picture(display_image(joined, exposure_scale(joined)), folder / "preview.png")
    (folder / "record.json").write_text(
        json.dumps({_KEY: 1, "maps": list(maps), **_record(batch, place)}, indent=1) + "\n"
    )


def _blocks(
    batch: Batch, place: Place, progress: Progress
) -> Iterator[tuple[IntArray, IntArray, FloatArray]]:
    """Yield (pixels, items, coefficients (n, c, 1 + k)) of the items that have a result."""
    for start in range(0, len(batch), _CHUNK):
        progress(_LABEL, start, len(batch))
        z = batch.rows("coefficients", start, start + _CHUNK).astype(np.float64)
        items = start + np.flatnonzero(np.isfinite(z).all(axis=(1, 2)))
        items = items[place.pixel[items] >= 0]
        yield place.pixel[items], items, z[items - start]
    progress(_LABEL, len(batch), len(batch))


def _enter(
    batch: Batch, flat: dict[str, FloatArray], pixel: IntArray, items: IntArray, z: FloatArray
) -> None:
    if not len(items):
        return
    fit = TextureFit()
    points = fit.fit(_values(batch.basis, *fit.directions, z))
    flat["base_color"][pixel], flat["specular"][pixel] = points.diffuse, points.specular
    flat["roughness"][pixel, 0], flat["misfit"][pixel, 0] = points.roughness, points.misfit
    first, last = int(items[0]), int(items[-1]) + 1
    for name, column in (("uncertainty", "deviation"), ("outlier_share", "outlier_share")):
        flat[name][pixel, 0] = batch.rows(column, first, last)[items - first]


def _values(basis: LeadingBasis, wi: FloatArray, wo: FloatArray, z: FloatArray) -> FloatArray:
    """Return f_r (n, m, c) of n points at the same m directions."""
    mean, phi = basis.at(wi, wo)
    log = mean[None, :, None] + np.einsum("mk,nck->nmc", phi, z, optimize=True)
    return np.asarray(np.exp(np.clip(log, -30.0, 30.0)))


def _relit(basis: LeadingBasis, at: FloatArray, light: FloatArray, z: FloatArray) -> FloatArray:
    """Return radiance (n, 3) toward a camera above the patch, under a small near light."""
    toward = light - at
    distance2 = (toward**2).sum(axis=1)
    wi, wo = normalize(toward), normalize(np.array(_CAMERA) - at)
    mean, phi = basis.at(wi, wo)
    log = mean[:, None] + np.einsum("nk,nck->nc", phi, z)
    return np.asarray(np.exp(np.clip(log, -30.0, 30.0)) * (wi[:, 2] / distance2)[:, None])


def _write_map(values: FloatArray, path: Path) -> None:
    names = "RGB" if values.shape[2] == 3 else "Y"
    planes = {name: values[..., c] for c, name in enumerate(names)}
    write_exr(planes, {}, path)


def _write_atlas(place: Place, atlas: Any, basis: LeadingBasis, folder: Path) -> None:
    """Write a picture for every coefficient, and what they multiply."""
    (folder / "coefficients").mkdir()
    for k in range(basis.size):
        values = place.shaped(np.asarray(atlas[k]))
        _write_map(values, folder / "coefficients" / f"{k:02d}.exr")
    np.savez(folder / "basis.npz", rows=basis.rows, grid=basis.grid.shape)


def _said(batch: Batch) -> str:
    source = batch.attributes["input"]
    return f"brdfit batch: fitted point by point to {source['name']} (SHA-256 {source['sha256']})"


def _record(batch: Batch, place: Place) -> dict[str, Any]:
    names = ("input", "method", "population", "versions")
    return {
        "height": place.height,
        "width": place.width,
        **{name: batch.attributes[name] for name in names},
    }
