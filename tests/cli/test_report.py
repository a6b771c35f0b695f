from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

import brdfit.report.page.pictures as pictures

Run = Callable[..., tuple[int, str, str]]


@pytest.fixture(autouse=True)
def _small(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pictures, "_SIZE", 12)


@pytest.fixture
def fitted(run: Run, constant: type, paint_csv: Path) -> Path:
    """Fit the paint; return the table beside which the other files lie."""
    table = paint_csv.with_name("out.binary")
    assert run("fit", paint_csv, "-o", table)[0] == 0
    return table


def test_the_files_of_a_fit_become_a_report(run: Run, fitted: Path, tmp_path: Path) -> None:
    page = tmp_path / "report.html"
    code, out, _ = run("report", fitted, "-o", page, "--reference", fitted)
    assert code == 0
    assert f"wrote {page}" in out
    text = page.read_text(encoding="utf-8")
    for name in ("paint.csv", "out.binary", "out.json", "out.csv"):
        assert name in text
    assert "Against the reference out.binary" in text
    again = tmp_path / "again.html"
    assert run("report", fitted.with_suffix(".json"), "-o", again, "--reference", fitted)[0] == 0
    assert again.read_bytes() == page.read_bytes()


def test_measurements_are_fitted_first(
    run: Run, constant: type, paint_csv: Path, tmp_path: Path
) -> None:
    page = tmp_path / "report.html"
    code, out, _ = run("report", paint_csv, "-o", page, "--passes", "2")
    assert code == 0
    assert "fit by constant" in out
    text = page.read_text(encoding="utf-8")
    assert "<dt>passes</dt><dd>2</dd>" in text
    assert ">measurements</th>" in text
    assert sorted(path.name for path in tmp_path.iterdir()) == ["paint.csv", "report.html"]


def test_what_is_missing_is_said_on_the_terminal_too(
    run: Run, fitted: Path, tmp_path: Path
) -> None:
    fitted.with_suffix(".csv").unlink()
    code, out, _ = run("report", fitted, "-o", tmp_path / "report.html")
    assert code == 0
    assert "note: no samples of a fit (out.csv) lie beside out.binary" in out


def test_settings_of_a_method_are_not_for_a_finished_fit(
    run: Run, fitted: Path, tmp_path: Path
) -> None:
    for given in (fitted, fitted.with_suffix(".json")):
        code, _, err = run("report", given, "-o", tmp_path / "r.html", "--passes", "2")
        assert code == 2
        assert "is fitted already" in err
    assert not (tmp_path / "r.html").exists()


@pytest.mark.parametrize(
    ("words", "code", "says"),
    [
        (["out.binary"], 2, "-o"),
        (["out.binary", "-o", "r.pdf"], 2, "written as .html"),
        (["out.binary", "-o", "no/r.html"], 2, "does not exist"),
        (["out.binary", "-o", "r.html", "--refrence", "x"], 2, "Did you mean --reference?"),
        (["nothing.binary", "-o", "r.html"], 1, "there is no such file"),
        (["out.binary", "-o", "r.html", "--reference", "nothing.npz"], 1, "there is no such file"),
        (["other.json", "-o", "r.html"], 2, "is JSON but not the record of a fit"),
        (["broken.json", "-o", "r.html"], 1, "broken.json: is not JSON"),
    ],
)
def test_wrong_words_are_answered(
    run: Run,
    fitted: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    words: list[str],
    code: int,
    says: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("other.json").write_text("{}")
    Path("broken.json").write_text("{")
    ended = run("report", *words)
    assert ended[0] == code
    assert says in ended[2]
    assert "Traceback" not in ended[2]
    assert not Path("r.html").exists()


def test_the_report_never_replaces_its_input(run: Run, fitted: Path, tmp_path: Path) -> None:
    table = fitted.rename(tmp_path / "table.html")
    code, _, err = run("report", table, "-o", table)
    assert code == 2
    assert "is an input" in err
