"""What the page can do, done from Python."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np
import pytest

import brdfit
from brdfit.errors import UsageError
from brdfit.geometry import directions_from_half_diff
from brdfit.grid import Grid
from brdfit.reconstruct import Reconstruction
from brdfit.report.fit_outputs import FitPaths, write_fit
from brdfit.samples import Flag
from brdfit.viewer.describe import columns_message, entry_message, writable
from brdfit.viewer.messages import FitRequest
from brdfit.viewer.refit import method_infos
from brdfit.viewer.sample_detail import sample_message, text_row
from brdfit.viewer.store import NotThere
from brdfit.viewer.trust import trust_message
from brdfit.viewer.workbench import Workbench

from viewer_client import Client

OUTLIER_ROW = 87  # line of the file, from 1


def finished(bench: Workbench, request: FitRequest) -> str:
    """Fit and wait; return the id of the result."""
    job = bench.fit(request)
    bench.jobs.watch(job.id)
    while job.state in ("waiting", "running"):
        time.sleep(0.005)  # a loop without rest would keep the fit's thread from its work
        job = bench.jobs.get(job.id)
    assert job.state == "done", job.message
    assert job.entry is not None
    return job.entry


def test_the_outlier_shows_the_row_of_its_file(bench: Workbench, lobe_csv: Path) -> None:
    bench.open(lobe_csv)
    job = bench.home().jobs[0]
    while bench.jobs.get(job).state in ("waiting", "running"):
        time.sleep(0.005)
    ended = bench.jobs.get(job)
    assert ended.state == "done", ended.message
    item = bench.store.item(str(ended.entry))
    assert item.fitted.judged is not None
    columns = columns_message(item.fitted.judged)
    wrong = [n for n, outlier in enumerate(columns.outlier) if outlier]
    assert [columns.row[n] for n in wrong] == [OUTLIER_ROW]
    detail = sample_message(item, columns.sample[wrong[0]])
    lines = lobe_csv.read_text().splitlines()
    assert detail.line == lines[detail.row - 1]
    assert detail.header == lines[1]
    assert detail.outlier
    assert detail.channels[0].value == pytest.approx(float(detail.line.split(",")[4]))
    # the method states 5 %: a value that is eight times too large is outside
    for channel in detail.channels:
        assert channel.prediction is not None
        assert channel.low == pytest.approx(channel.prediction * np.exp(-1.96 * 0.05), rel=1e-5)
        assert channel.high == pytest.approx(channel.prediction * np.exp(1.96 * 0.05), rel=1e-5)
        assert channel.value is not None
        assert channel.high is not None
        assert channel.value > 3 * channel.high


def test_switching_an_outlier_off_and_refitting_changes_the_table_and_nothing_else(
    bench: Workbench, lobe: Reconstruction
) -> None:
    bench.open(lobe)
    before = bench.store.item("e1")
    outlier = int(np.flatnonzero(lobe.outliers)[0])
    made = bench.store.item(finished(bench, FitRequest("e1", rejected=[outlier])))
    assert not np.allclose(made.table.values, before.table.values)
    assert bench.store.item("e1") is before
    assert made.fitted.judged is not None
    assert made.fitted.judged.samples.bits[outlier] & Flag.REJECTED
    assert entry_message(made).samples.rejected == 1  # type: ignore[union-attr]
    again = bench.store.item(finished(bench, FitRequest(made.id, accepted=[outlier])))
    np.testing.assert_array_equal(again.table.values, before.table.values)


def test_a_request_takes_over_the_settings_of_the_fit_and_changes_those_it_names(
    bench: Workbench, lobe: Reconstruction
) -> None:
    bench.open(lobe)
    doubled = bench.store.item(finished(bench, FitRequest("e1", settings={"factor": 2.0})))
    assert doubled.record["method"] == {"name": "quick", "factor": 2.0, "careful": True}
    kept = bench.store.item(finished(bench, FitRequest(doubled.id)))
    assert kept.record["method"]["factor"] == 2.0


@pytest.mark.parametrize(
    ("request_", "found"),
    [
        (FitRequest("e1", method="qick"), "found 'qick'"),
        (FitRequest("e1", settings={"facter": 1.0}), "found 'facter'"),
        (FitRequest("e1", rejected=[5000]), "found 5000"),
        (FitRequest("e9"), "e9"),
    ],
)
def test_a_request_that_means_nothing_is_refused(
    bench: Workbench, lobe: Reconstruction, request_: FitRequest, found: str
) -> None:
    bench.open(lobe)
    with pytest.raises(UsageError, match=found):
        bench.fit(request_)


def test_nonsense_from_the_network_is_refused_in_words(
    ask: Client, bench: Workbench, lobe: Reconstruction
) -> None:
    bench.open(lobe)
    for body in (b"{", b"[]", b'{"source": 3}', b'{"source": "e1", "rejected": ["x"]}'):
        answer = ask("api/fits", "POST", body)
        assert answer.code == 400
        assert "cannot be understood" in answer.json["message"]
    assert ask("api/entries/e1/slice?theta_i=steep").code == 400
    assert ask("api/entries/e1/slice?theta_i=nan").code == 400
    assert ask("api/entries/e1/samples/100000").code == 400
    assert ask("api/entries/e77").code == 404
    assert ask("api/entries/e1", "POST", {}).code in (404, 405)


@pytest.mark.usefixtures("full_tables")
def test_every_format_that_is_offered_can_be_downloaded_and_read_back(
    ask: Client, bench: Workbench, lobe: Reconstruction, tmp_path: Path
) -> None:
    bench.open(lobe)
    offered = writable(bench.store.item("e1"))
    assert {one.kind for one in offered} == {"table", "samples", "record"}
    assert len(offered) > 5
    for one in offered:
        answer = ask(f"api/entries/e1/download?kind={one.kind}&format={one.format}")
        assert answer.code == 200, (one, answer.body)
        assert "attachment" in answer.headers["content-disposition"]
        path = tmp_path / f"{one.format}{one.suffix}"
        path.write_bytes(answer.body)
        if one.kind == "samples":
            assert len(brdfit.read_samples(path)) == len(lobe.samples)
        elif one.format == "merl":
            read = brdfit.read_table(path)
            expected = lobe.table()
            assert read.missing == 0
            np.testing.assert_allclose(
                read.values[expected.mask], expected.values[expected.mask], rtol=1e-6
            )
    # what was sent is not kept: the last file goes once its answer has left
    until = time.monotonic() + 10.0
    while any(path.is_file() for path in bench.store.folder.rglob("*")):
        assert time.monotonic() < until
        time.sleep(0.01)
    assert ask("api/entries/e1/download?kind=table&format=gif").code == 400


def test_the_files_of_a_fit_are_found_again_and_can_be_fitted_again(
    bench: Workbench, lobe: Reconstruction, lobe_csv: Path
) -> None:
    paths = FitPaths.beside(lobe_csv.with_name("out.binary"))
    write_fit(lobe, paths)
    for path in (paths.table, paths.record, paths.samples):
        bench.open(path)
    for item in bench.store.opened:
        assert item.fitted.judged is not None
        assert item.source == lobe_csv
        outlier = int(np.flatnonzero(item.fitted.judged.outliers)[0])
        assert (
            sample_message(item, outlier).line == lobe_csv.read_text().splitlines()[OUTLIER_ROW - 1]
        )
        assert item.stddev is not None
    made = bench.store.item(finished(bench, FitRequest("e1")))
    assert made.record["method"]["name"] == "quick"
    expected = lobe.table(made.table.grid)
    np.testing.assert_allclose(made.table.values, expected.values, rtol=1e-5)


def test_a_table_alone_says_what_is_not_known(bench: Workbench, lobe: Reconstruction) -> None:
    bench.open(lobe.table(Grid(20, 20, 24)))
    item = bench.store.item("e1")
    entry = entry_message(item)
    assert entry.kind == "table"
    assert entry.samples is None
    with pytest.raises(UsageError, match="table alone"):
        bench.fit(FitRequest("e1"))
    with pytest.raises(UsageError, match="no samples"):
        trust_message(item, 90.0)
    assert item.slice(30.0, 180.0).curves[0].low is None


def test_the_trust_map_of_a_fit_at_hand_is_its_own(bench: Workbench, lobe: Reconstruction) -> None:
    bench.open(lobe)
    plane = trust_message(bench.store.item("e1"), 90.0)
    theta_d, theta_h = np.meshgrid(
        np.radians(plane.theta_d), np.radians(plane.theta_h), indexing="ij"
    )
    wi, wo = directions_from_half_diff(theta_h, theta_d, np.full(theta_h.shape, np.pi / 2))
    own = lobe.trust(wi.reshape(-1, 3), wo.reshape(-1, 3)).reshape(theta_h.shape)
    assert np.mean(own == np.array(plane.code)) > 0.99  # cells on a border may round either way
    assert plane.definition == lobe.trust_map.definition


def test_the_trust_map_of_a_fit_from_disk_is_what_the_fit_told(
    bench: Workbench, sure: Reconstruction, tmp_path: Path
) -> None:
    paths = FitPaths.beside(tmp_path / "out.npz")
    write_fit(sure, paths, grid=Grid(30, 30, 36))
    bench.open(sure)
    bench.open(paths.table)
    own, kept = (trust_message(bench.store.item(name), 90.0) for name in ("e1", "e2"))
    assert sure.trust_map.judges
    assert kept.definition == own.definition
    # the doubt is interpolated between coarse nodes: classes may differ at their borders
    assert np.mean(np.array(own.code) == np.array(kept.code)) > 0.95
    assert kept.shares == pytest.approx(own.shares, abs=0.02)


def test_the_trust_map_has_every_share_and_marks_where_samples_are(
    bench: Workbench, lobe: Reconstruction
) -> None:
    bench.open(lobe)
    plane = trust_message(bench.store.item("e1"), 90.0)
    assert sum(plane.shares) == pytest.approx(1.0)
    code = np.array(plane.code)
    assert code.shape == (len(plane.theta_d), len(plane.theta_h))
    assert set(np.unique(code)) == {1, 2, 3}  # at phi_d = 90 degrees everything exists
    assert 0 in np.array(trust_message(bench.store.item("e1"), 0.0).code)
    # the samples lie at theta_d of 2.5 to 57.5 degrees: none near grazing
    assert set(code[-1]) <= {2, 3}


def test_equal_entries_compare_as_equal(bench: Workbench, lobe: Reconstruction) -> None:
    bench.open(lobe.table(Grid(30, 30, 36)))
    bench.open(lobe)
    found = bench.compare("e1", "e2")
    figures = {(row.name, row.where): row for row in found.rows}
    assert figures["perceptual_error", "studio"].value == 0.0
    assert figures["log_rms", "values"].value == pytest.approx(0.0, abs=1e-6)
    assert figures["psnr", "studio"].value is None
    assert figures["psnr", "studio"].text == "inf"


def test_every_method_tells_of_its_settings() -> None:
    infos = {info.name: info for info in method_infos()}
    quick = {one.name: one for one in infos["quick"].settings}
    assert quick["factor"].kind == "number"
    assert quick["factor"].help == "Multiplies the level."
    assert quick["careful"].kind == "flag"
    assert infos["correction"].leans_on_population
    assert "population" not in {one.name for one in infos["correction"].settings}


def test_a_row_of_a_file_that_is_not_text_is_not_shown(tmp_path: Path) -> None:
    path = tmp_path / "x.bin"
    path.write_bytes(b"\xff\xfe\x00\x01" * 100)
    assert text_row(path, 1) == (None, None)
    assert text_row(tmp_path / "gone.csv", 1) == (None, None)
    assert text_row(None, 1) == (None, None)
    path.write_text("a,b\n1,2\n")
    assert text_row(path, 2) == ("a,b", "1,2")
    assert text_row(path, 3) == (None, None)


def test_what_was_let_go_is_said_to_be_gone(bench: Workbench) -> None:
    with pytest.raises(NotThere, match="Fit or upload it again"):
        bench.store.get("e5")
