"""The report: what it says, that it needs nothing from outside, and that nothing slips through."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest

import brdfit
import brdfit.report.page.pictures as pictures
import brdfit.report.page.write as write_module
from brdfit.arrays import FloatArray
from brdfit.errors import UsageError
from brdfit.grid import Grid
from brdfit.progress import Progress
from brdfit.reconstruct.outcome import Outcome
from brdfit.reconstruct.result import Reconstruction
from brdfit.report.fitted import Fitted, fit_record
from brdfit.report.page.write import write_report
from brdfit.report.samples_csv import Judged
from brdfit.report.uncertainty import Uncertainty
from brdfit.samples import Samples, Source
from brdfit.table import Table

Fit = Callable[..., Reconstruction]
LoadedBy = {"src", "href", "srcset", "poster", "data", "action", "formaction", "background"}
HOSTILE = "<script>alert(1)</script>\"'--><img src=x onerror=alert(1)>&amp;\u2028{{ 7*7 }}"


@dataclass
class Page(HTMLParser):
    """What a browser would make of the page."""

    text: str
    tags: list[tuple[str, dict[str, str]]] = field(default_factory=list)
    words: dict[str, list[str]] = field(default_factory=dict)
    """Text by the id of the section it stands in."""
    scripts: list[str] = field(default_factory=list)
    _open: list[str] = field(default_factory=list)
    _section: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        super().__init__(convert_charrefs=True)
        self.feed(self.text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        named = {name: value or "" for name, value in attrs}
        self.tags.append((tag, named))
        if tag == "section":
            self._section.append(named.get("id", ""))
        if tag == "script":
            self.scripts.append("")
        self._open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        if tag in self._open:
            while self._open.pop() != tag:
                pass
        if tag == "section":
            self._section.pop()

    def handle_data(self, data: str) -> None:
        if self._open and self._open[-1] == "script":
            self.scripts[-1] += data
        elif self._open and self._open[-1] != "style":
            for name in self._section or [""]:
                self.words.setdefault(name, []).append(data)

    def said(self, section: str) -> str:
        """Return the words of a section."""
        return " ".join(" ".join(self.words.get(section, [])).split())

    def data(self) -> dict[str, object]:
        """Return what the script draws from."""
        found: dict[str, object] = json.loads(self.scripts[0])
        return found


@pytest.fixture(autouse=True)
def _small(monkeypatch: pytest.MonkeyPatch) -> None:
    """Draw small spheres: the time of a report goes there."""
    monkeypatch.setattr(pictures, "_SIZE", 12)
    monkeypatch.setattr(write_module, "MERL_GRID", Grid(20, 18, 24), raising=False)
    monkeypatch.setattr("brdfit.report.fitted.MERL_GRID", Grid(20, 18, 24))


def _page(what: object, tmp_path: Path, **options: object) -> Page:
    path = tmp_path / "report.html"
    write_report(what, path, **options)  # type: ignore[arg-type]
    return Page(path.read_text(encoding="utf-8"))


def test_the_sections_say_what_became_of_the_fit(fit_known: Fit, tmp_path: Path) -> None:
    result = fit_known()
    page = _page(result, tmp_path)
    count = int(result.outliers.sum())
    top = page.said("")
    assert "reconstructed by the method known; the fit ended: converged" in top
    assert Outcome.CONVERGED.advice in top
    assert f"Outliers {count} " in top
    assert "by usable measurement" not in top
    assert "measured: a believed sample within 5 degrees" in page.said("trust")
    assert "weight below 0.5" in page.said("outliers")
    row = int(result.samples.rows[4])  # type: ignore[index]
    assert f"{row} 8.0 times too high" in page.said("outliers")
    assert "not finite" in page.said("outliers")
    for finding in ("cells", "reciprocity", "energy", "grazing", "symmetry", "peak"):
        assert page.said("health").count(f"{finding} ") >= 2  # of the table, of the samples
    made = page.said("made")
    assert "name known" in made
    assert f"numpy {np.__version__}" in made


def test_outliers_are_listed_with_their_rows_the_farthest_first(
    fit_known: Fit, tmp_path: Path
) -> None:
    page = _page(fit_known(), tmp_path)
    table = page.text.split("Measurements taken for outliers")[1].split("</table>")[0]
    off = [float(one) for one in re.findall(r'class="text">([\d.]+) times', table)]
    assert off == sorted(off, reverse=True)
    rows = [int(one) for one in re.findall(r'<th scope="row">(\d+)</th>', table)]
    result = fit_known()
    assert sorted(rows) == sorted(result.samples.rows[result.outliers].tolist())  # type: ignore[index]


def test_the_page_loads_nothing(fit_known: Fit, tmp_path: Path) -> None:
    page = _page(fit_known(), tmp_path)
    loaded = [
        (tag, name, value)
        for tag, named in page.tags
        for name, value in named.items()
        if name in LoadedBy
    ]
    assert len(loaded) > 4
    assert [one for one in loaded if not one[2].startswith(("#", "data:"))] == []
    style = page.text.split("<style>")[1].split("</style>")[0]
    assert "url(" not in style
    assert "@import" not in style
    assert not re.search(r"\bimport\s*\(|fetch\(|XMLHttpRequest|WebSocket", page.scripts[1])
    policy = _policy(page)
    assert policy.startswith("default-src 'none'; img-src data:;")
    assert "unsafe" not in policy


def _policy(page: Page) -> str:
    return next(
        named["content"]
        for tag, named in page.tags
        if tag == "meta" and named.get("http-equiv") == "Content-Security-Policy"
    )


def test_the_policy_names_the_very_script_and_style_of_the_page(
    fit_known: Fit, tmp_path: Path
) -> None:
    import base64
    import hashlib

    page = _page(fit_known(), tmp_path)
    style = page.text.split("<style>")[1].split("</style>")[0]
    for text in (style, page.scripts[1]):
        digest = base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()
        assert f"'sha256-{digest}'" in _policy(page)
    assert not [named for _, named in page.tags if "style" in named]
    assert not [name for _, named in page.tags for name in named if name.startswith("on")]


def test_a_hostile_name_is_shown_and_does_nothing(fit_known: Fit, tmp_path: Path) -> None:
    known = fit_known()
    source = Source(name=HOSTILE, convention=HOSTILE, notes=(HOSTILE,), metadata={HOSTILE: HOSTILE})
    samples = replace(known.samples, channels=(HOSTILE, "b", "c"), wavelengths=None, source=source)
    page = _page(replace(known, samples=samples, outlier_rule=HOSTILE), tmp_path)
    kinds = {tag for tag, _ in page.tags}
    assert len(page.scripts) == 2
    assert not [1 for tag, named in page.tags if tag == "img" and named.get("src") == "x"]
    assert "onerror" not in {name for _, named in page.tags for name in named}
    assert {"html", "svg", "table"} <= kinds
    shown = " ".join(HOSTILE.split())
    assert shown in page.said("")
    assert shown in page.said("outliers")
    assert shown in page.said("made")
    assert page.data()["channels"][0]["channel"] == HOSTILE  # type: ignore[index]


@pytest.mark.parametrize("value", [HOSTILE, ["x", {"y": HOSTILE}], {"name": {}}, 7, None])
def test_a_record_of_another_shape_breaks_nothing(
    fit_known: Fit, tmp_path: Path, value: object
) -> None:
    fitted = Fitted.of(fit_known())
    assert len(fitted.record) > 8
    page = _page(replace(fitted, record=dict.fromkeys(fitted.record, value)), tmp_path)
    assert len(page.scripts) == 2


def _with_an_outlier_in_the_plane(result: Reconstruction) -> Reconstruction:
    return replace(result, outliers=np.arange(len(result.samples)) == 5)


def test_the_slices_hold_curves_measurements_and_the_band(fit_known: Fit, tmp_path: Path) -> None:
    result = _with_an_outlier_in_the_plane(fit_known())
    page = _page(replace(result, model=_Unsure(result.model)), tmp_path)
    data = page.data()
    panels = {panel["theta_i"]: panel for panel in data["panels"]}  # type: ignore[attr-defined]
    assert data["measured"] == [10.0, 30.0, 50.0]
    assert len(panels) == 36
    curve = panels[30.0]["curves"][1]
    value, low, high = (np.array(curve[name]) for name in ("value", "low", "high"))
    assert high / value == pytest.approx(np.exp(1.96 * 0.2), rel=0.01)
    assert value / low == pytest.approx(np.exp(1.96 * 0.2), rel=0.01)
    on_it = panels[10.0]["points"]
    assert {point[1] for point in on_it if point[5]} == {int(result.samples.rows[5])}  # type: ignore[index]
    assert "95 %" in page.said("slices")


def test_without_a_stated_uncertainty_there_is_no_band(fit_known: Fit, tmp_path: Path) -> None:
    page = _page(fit_known(), tmp_path)
    assert page.data()["panels"][3]["curves"][0]["low"] is None  # type: ignore[index]
    assert "the method states no uncertainty" in page.said("slices")


def test_slices_stand_there_without_a_script(fit_known: Fit, tmp_path: Path) -> None:
    page = _page(_with_an_outlier_in_the_plane(fit_known()), tmp_path)
    slices = page.text.split('id="slices"')[1].split("</section>")[0]
    assert slices.count("<svg") == 3
    assert re.search(r'class="mark outlier"', slices)
    assert re.findall(r"theta_i = (\d+)°", slices) == ["10", "30", "50"]


def test_a_reference_is_rendered_measured_and_named(fit_known: Fit, tmp_path: Path) -> None:
    result = fit_known()
    grid = Grid(20, 18, 24)
    table = result.table(grid)
    twice = Table(
        values=table.values * 2.0, grid=grid, channels=table.channels, source=Source("gold.npz")
    )
    page = _page(result, tmp_path, reference=twice)
    assert "Against the reference gold.npz" in page.said("metrics")
    assert "mean |delta ln f| 0.693" in page.said("metrics")
    assert "mean CIEDE2000 of displayed images" in page.said("metrics")
    assert sum(tag == "img" for tag, _ in page.tags) == 6
    assert "Perceptual error" in page.said("")
    same = _page(result, tmp_path, reference=table)
    assert "mean |delta ln f| 0 " in same.said("metrics")


def test_an_albedo_far_above_one_leaves_the_plot_readable(fit_known: Fit, tmp_path: Path) -> None:
    grid = Grid(20, 18, 24)
    bright = Table(values=np.full((*grid.shape, 1), 150.0), grid=grid)
    page = _page(bright, tmp_path)
    plot = page.text.split("Directional albedo")[0].rsplit("<svg", 1)[1]
    assert re.search(r">rises to \d+<", plot)
    assert plot.count('class="tick"') < 20


def test_a_table_alone_says_what_is_missing(fit_known: Fit, tmp_path: Path) -> None:
    page = _page(fit_known().table(Grid(20, 18, 24)), tmp_path)
    assert "only the table is known" in page.said("")
    for absent in ("trust", "outliers", "metrics"):
        assert page.said(absent) == ""
    assert "cells" in page.said("health")


def test_one_channel_and_many_bands_are_reported(fit_known: Fit, tmp_path: Path) -> None:
    grey = _page(fit_known(1), tmp_path)
    assert [one["style"] for one in grey.data()["channels"]] == ["ink"]  # type: ignore[attr-defined]
    bands = np.arange(400.0, 701.0, 50.0)
    many = _page(fit_known(len(bands), bands), tmp_path)
    assert [one["channel"] for one in many.data()["channels"]] == [  # type: ignore[attr-defined]
        "600nm",
        "550nm",
        "450nm",
    ]
    assert "7 bands became linear sRGB" in many.said("spheres")


def test_bands_of_samples_are_drawn_in_the_colours_of_their_table(
    fit_known: Fit, tmp_path: Path
) -> None:
    bands = np.arange(400.0, 701.0, 50.0)
    result = fit_known(len(bands), bands)
    table = fit_known(3).table(Grid(20, 18, 24))
    fitted = Fitted("x", table, Judged.of(result), fit_record(result, None))
    page = _page(fitted, tmp_path)
    assert any(panel["points"] for panel in page.data()["panels"])  # type: ignore[attr-defined]
    channels = page.text.split("Measurements taken for outliers")[1].split("</thead>")[0]
    assert "550nm" in channels


def test_equal_input_gives_equal_bytes(fit_known: Fit, tmp_path: Path) -> None:
    for name in ("a.html", "b.html"):
        write_report(fit_known(), tmp_path / name)
    assert (tmp_path / "a.html").read_bytes() == (tmp_path / "b.html").read_bytes()


def test_it_appears_whole_or_not_at_all(
    fit_known: Fit, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "report.html"
    path.write_text("the old one")

    def broken(*_: object) -> str:
        raise KeyboardInterrupt

    monkeypatch.setattr(write_module, "page_of", broken)
    with pytest.raises(KeyboardInterrupt):
        write_report(fit_known(), path)
    assert path.read_text() == "the old one"
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize(
    ("name", "says"),
    [
        ("report.pdf", "written as .html"),
        ("no/where/report.html", "does not exist"),
        ("folder.html", "found a folder"),
    ],
)
def test_a_path_that_cannot_be_is_refused_before_any_work(
    tmp_path: Path, name: str, says: str
) -> None:
    (tmp_path / "folder.html").mkdir()
    with pytest.raises(UsageError, match=says):
        write_report(tmp_path / "not even there.binary", tmp_path / name)


def test_measurements_are_not_a_fit(tmp_path: Path) -> None:
    path = tmp_path / "paint.csv"
    path.write_text("theta_i_deg,phi_i_deg,theta_o_deg,phi_o_deg,value\n10,0,20,0,1\n")
    with pytest.raises(UsageError, match="neither a table nor a file that a fit left"):
        brdfit.write_report(path, tmp_path / "report.html")


def test_every_table_picture_and_plot_has_a_name(fit_known: Fit, tmp_path: Path) -> None:
    page = _page(fit_known(), tmp_path)
    text = page.text
    assert text.count("<table") == text.count("<caption")
    assert text.count("<svg") == text.count("<title>") - 1  # the page has one itself
    assert all(named.get("alt") for tag, named in page.tags if tag == "img")
    assert all(named.get("scope") for tag, named in page.tags if tag == "th")
    levels = [int(tag[1]) for tag, _ in page.tags if re.fullmatch(r"h[1-6]", tag)]
    assert levels[0] == 1
    assert levels.count(1) == 1
    assert max(np.diff(levels)) <= 1
    known = {named["id"] for _, named in page.tags if "id" in named}
    inner = [named["href"][1:] for tag, named in page.tags if tag == "a"]
    assert len(inner) >= 6
    assert set(inner) <= known
    pointed = [named[name] for _, named in page.tags for name in named if name == "aria-labelledby"]
    assert set(pointed) <= known


def test_a_large_file_of_measurements_stays_small(tmp_path: Path, fit_known: Fit) -> None:
    known = fit_known()
    repeat = np.repeat(np.arange(len(known.samples)), 60)
    jitter = np.random.default_rng(1).normal(0.0, 0.002, (len(repeat), 3))
    wi = known.samples.wi[repeat] + jitter
    samples = Samples(
        wi=wi / np.linalg.norm(wi, axis=1, keepdims=True),
        wo=known.samples.wo[repeat],
        value=known.samples.value[repeat],
    )
    judged = Judged(
        samples, known.weights[repeat], known.residuals[repeat], np.arange(len(repeat)) % 20 == 0
    )
    table = known.table(Grid(20, 18, 24))
    stated = Uncertainty.of(replace(known, model=_Unsure(known.model)))
    page = _page(Fitted("x", table, judged, {}, stated), tmp_path)
    assert len(samples) > 8_000
    assert len(page.text.encode()) < 6_000_000
    assert "are listed; the samples file has all" in page.said("outliers")


@dataclass(frozen=True)
class _Unsure:
    """A model that is as it is, give or take."""

    model: object

    def evaluate(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        return self.model.evaluate(wi, wo)  # type: ignore[attr-defined,no-any-return]

    def dense(self, grid: Grid, progress: Progress) -> FloatArray:
        return self.model.dense(grid, progress)  # type: ignore[attr-defined,no-any-return]

    def stddev(self, wi: FloatArray, wo: FloatArray) -> FloatArray | None:
        return np.full((len(wi), 3), 0.2)
