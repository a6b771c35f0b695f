"""The spheres of a report, and how the result differs from a reference on them."""

from __future__ import annotations

import base64
import io
import re
from collections.abc import Callable

import numpy as np
import pytest
from matplotlib.image import imread

import brdfit.report.page.pictures as pictures
from brdfit.arrays import FloatArray
from brdfit.grid import Grid
from brdfit.metrics import perceptual_error
from brdfit.reconstruct.result import Reconstruction
from brdfit.render import ILLUMINATIONS, Sphere
from brdfit.table import Table

SIZE = 40


@pytest.fixture
def table(fit_known: Callable[..., Reconstruction], monkeypatch: pytest.MonkeyPatch) -> Table:
    """Return a lobe in three channels, to be drawn small."""
    monkeypatch.setattr(pictures, "_SIZE", SIZE)
    return fit_known().table(Grid(20, 18, 24))


def image(uri: str) -> FloatArray:
    content = base64.b64decode(uri.removeprefix("data:image/png;base64,"))
    return np.asarray(imread(io.BytesIO(content)), dtype=np.float64)


def scaled(table: Table, factor: float) -> Table:
    return Table(values=table.values * factor, grid=table.grid, channels=table.channels)


def means(row: pictures.SphereRow) -> list[float]:
    texts = (re.search(r"CIEDE2000 ([0-9.]+) on average", caption) for caption, _ in row.pictures)
    return [float(found[1]) for found in texts if found]


def test_without_a_reference_the_material_stands_alone(table: Table) -> None:
    assert [row.title for row in pictures.sphere_rows(table)] == ["Reconstruction"]


def test_the_difference_to_a_reference_is_told_and_shown_in_ciede2000(table: Table) -> None:
    dimmer = scaled(table, 0.7)
    rows = pictures.sphere_rows(dimmer, table)
    assert [row.title for row in rows] == ["Reference", "Reconstruction", "Difference"]
    sphere = Sphere(SIZE)
    for light, told in zip(pictures.LIGHTS, means(rows[2]), strict=True):
        pair = [sphere.shade(one, ILLUMINATIONS[light]()) for one in (table, dimmer)]
        assert told == pytest.approx(perceptual_error(*pair, sphere.mask), rel=0.01)
        assert told > 3.0


def test_equals_are_dark_and_what_is_far_apart_is_yellow(table: Table) -> None:
    inside = Sphere(SIZE - 4).mask
    equal, apart = (
        image(pictures.sphere_rows(other, table)[2].pictures[0][1])[2:-2, 2:-2][inside]
        for other in (table, scaled(table, 0.05))
    )
    np.testing.assert_allclose(equal[:, :3], np.tile(pictures._RAMP[0], (len(equal), 1)), atol=0.01)
    np.testing.assert_allclose(np.median(apart[:, :3], axis=0), pictures._RAMP[-1], atol=0.01)
