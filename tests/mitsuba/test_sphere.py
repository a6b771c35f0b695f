"""Mitsuba's sphere is ours: the same view, the same light, the same values."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from brdfit.errors import BrdfitError, UsageError
from brdfit.grid import Grid
from brdfit.metrics.ciede2000 import perceptual_error
from brdfit.render import Environment, Illumination, Sphere, point, shade_under
from brdfit.table import Table

from small_files import tiny_table

SIZE, FINE = 24, 4


def coarse(image: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
    """Return the means of FINE x FINE pixels."""
    side = len(image) // FINE
    return image.reshape(side, FINE, side, FINE, -1).mean(axis=(1, 3))


def whole_pixels() -> np.ndarray[Any, Any]:
    return coarse(Sphere(SIZE * FINE).mask[..., None].astype(float))[..., 0] == 1.0


def test_a_white_surface_vanishes_in_a_white_furnace(llvm: Any) -> None:
    import brdfit.mitsuba
    from brdfit.mitsuba.sphere import render_sphere

    grid = Grid(12, 12, 12)
    white = Table(np.full((*grid.shape, 3), 1.0 / np.pi), grid=grid)
    furnace = Illumination("furnace", np.zeros((0, 3)), np.zeros((0, 3)), (1.0, 1.0, 1.0))
    image = render_sphere(lambda: brdfit.mitsuba.bsdf(white), furnace, SIZE, 256)
    inside = image[whole_pixels()]
    assert np.abs(inside - 1.0).max() < 0.05
    assert inside.mean() == pytest.approx(1.0, abs=0.002)
    assert image[0, 0].tolist() == [0.0, 0.0, 0.0]


def test_a_sphere_under_a_light_is_the_one_that_we_shade(llvm: Any) -> None:
    import brdfit.mitsuba
    from brdfit.mitsuba.sphere import render_sphere

    table = tiny_table(Grid(20, 16, 18))
    ours = coarse(Sphere(SIZE * FINE).shade(table, point()))
    theirs = render_sphere(lambda: brdfit.mitsuba.bsdf(table), point(), SIZE, 64)
    assert perceptual_error(ours, theirs, whole_pixels()) < 0.15
    assert perceptual_error(ours, theirs[:, ::-1], whole_pixels()) > 1.0


@pytest.mark.parametrize("turned", [0.0, 0.7])
def test_a_sphere_under_a_panorama_is_the_one_that_we_shade(llvm: Any, turned: float) -> None:
    import brdfit.mitsuba
    from brdfit.mitsuba.sphere import render_sphere

    # smooth, and unlike in all directions
    y, x = np.meshgrid(np.linspace(0.0, 1.0, 32), np.linspace(0.0, 1.0, 64), indexing="ij")
    waves = [1.0 + 0.9 * np.sin(2.0 * np.pi * (x + 0.3 * c)) * np.cos(y + c) for c in range(3)]
    environment = Environment("waves", np.stack(waves, axis=-1), turned)
    table = tiny_table(Grid(20, 16, 18))
    ours = coarse(shade_under(Sphere(SIZE * FINE), table, environment, 64))
    theirs = render_sphere(lambda: brdfit.mitsuba.bsdf(table), environment, SIZE, 256)
    assert perceptual_error(ours, theirs, whole_pixels()) < 0.5
    assert perceptual_error(ours, theirs[:, ::-1], whole_pixels()) > 1.0


def test_passes_add_up_and_the_variant_is_left_as_it_was(
    llvm: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    import brdfit.mitsuba
    from brdfit.mitsuba import sphere

    llvm.set_variant("scalar_rgb")
    table = tiny_table(Grid(20, 16, 18))
    told: list[tuple[str, int, int]] = []
    monkeypatch.setattr(sphere, "_MOST_RAYS", SIZE**2 * 16)
    image = sphere.render_sphere(
        lambda: brdfit.mitsuba.bsdf(table),
        point(),
        SIZE,
        40,
        progress=lambda *step: told.append(step),
    )
    assert [step[1:] for step in told] == [(0, 40), (16, 40), (32, 40), (40, 40)]
    assert llvm.variant() == "scalar_rgb"
    again = sphere.render_sphere(lambda: brdfit.mitsuba.bsdf(table), point(), SIZE, 40)
    np.testing.assert_array_equal(image, again)
    other = sphere.render_sphere(lambda: brdfit.mitsuba.bsdf(table), point(), SIZE, 40, seed=1)
    assert not np.array_equal(image, other)


def test_what_cannot_be_rendered_is_said(llvm: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    import drjit

    from brdfit.mitsuba.sphere import render_sphere

    with pytest.raises(UsageError, match="size 1 and samples 4"):
        render_sphere(lambda: None, point(), 1, 4)
    monkeypatch.setattr(drjit, "has_backend", lambda backend: False)
    with pytest.raises(BrdfitError, match="DRJIT_LIBLLVM_PATH"):
        render_sphere(lambda: None, point(), 8, 4)


def test_an_llvm_that_ends_the_process_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("mitsuba", reason="the extra mitsuba is not installed")
    import drjit

    from brdfit.mitsuba import library

    monkeypatch.setattr(drjit, "has_backend", lambda backend: True)
    monkeypatch.setattr(
        library,
        "_SMALLEST",
        "import os, sys; sys.stderr.write('LLVM ERROR: Cannot select'); sys.stderr.flush(); "
        "os.abort()",
    )
    library._trouble.cache_clear()
    with pytest.raises(BrdfitError, match=r"LLVM ERROR: Cannot select.*DRJIT_LIBLLVM_PATH"):
        library.require_llvm()
    library._trouble.cache_clear()
