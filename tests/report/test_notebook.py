from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from xml.etree import ElementTree as ET

import numpy as np
import pytest

import brdfit
import brdfit.display
from brdfit.errors import UsageError
from brdfit.grid import Grid
from brdfit.reconstruct.outcome import Outcome
from brdfit.reconstruct.result import Reconstruction
from brdfit.report.notebook import html_of
from brdfit.samples import Samples, Source

Fit = Callable[..., Reconstruction]
HOSTILE = "<script>alert(1)</script>\"'&"


def _shown(what: object) -> tuple[ET.Element, str]:
    """Return what a notebook shows, as elements and as words; not well-formed is an error."""
    html = what._repr_html_()  # type: ignore[attr-defined]
    box = ET.fromstring(html.replace('one point light">', 'one point light"/>'))
    return box, " ".join(" ".join(box.itertext()).split())


def test_samples_show_where_they_lie_and_what_is_wrong(
    lobe_samples: Callable[..., Samples],
) -> None:
    samples = lobe_samples()
    box, words = _shown(samples)
    used = int(samples.usable.any(axis=1).sum())
    assert f"{len(samples)}, {used} usable" in words
    assert "1 not finite" in words
    assert len(box.findall(".//{*}circle")) == used
    assert box.find("img") is None


def test_a_table_shows_a_sphere_and_its_cells(fit_known: Fit) -> None:
    table = fit_known().table(Grid(20, 18, 24))
    box, words = _shown(table)
    assert box.find("img") is not None
    assert "20 × 18 × 24 nodes" in words
    assert f"{int(table.mask.sum()):,} valid, 0 missing" in words


def test_a_result_shows_a_sphere_its_outliers_and_how_it_ended(fit_known: Fit) -> None:
    result = fit_known()
    box, words = _shown(result)
    count = int(result.outliers.sum())
    assert box.find("img") is not None
    assert len(box.findall(".//{*}path[@class='outlier']")) == count >= 1
    assert f"{count} of " in words
    assert "known, converged" in words
    bad = replace(result, outcome=Outcome.TOO_FEW_SAMPLES)
    assert Outcome.TOO_FEW_SAMPLES.advice in _shown(bad)[1]


def test_bands_are_shown_by_their_ends(fit_known: Fit) -> None:
    bands = np.arange(400.0, 701.0, 50.0)
    assert "7, 400nm to 700nm" in _shown(fit_known(len(bands), bands).samples)[1]


def test_a_hostile_name_does_nothing(fit_known: Fit) -> None:
    samples = replace(
        fit_known().samples, channels=(HOSTILE, "b", "c"), source=Source(name=HOSTILE)
    )
    box, words = _shown(samples)
    assert words.count(HOSTILE) == 2
    assert box.find(".//script") is None


def test_nothing_usable_is_shown_without_a_picture() -> None:
    down = np.array([[0.0, 0.0, -1.0]])
    box, words = _shown(Samples(wi=down, wo=down, value=np.ones((1, 1))))
    assert "1, 0 usable" in words
    assert box.find(".//{*}svg") is None


def test_what_is_none_of_these_is_refused() -> None:
    with pytest.raises(UsageError, match="samples, tables and results"):
        html_of(3)


def test_without_somebody_who_draws_the_usual_text_is_shown(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(brdfit.display, "_drawn_by", [])
    one = np.array([[0.0, 0.0, 1.0]])
    assert Samples(wi=one, wo=one, value=np.ones((1, 1)))._repr_html_() is None
