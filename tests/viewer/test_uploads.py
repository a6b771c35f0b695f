"""What is handed over: taken in whole, or refused without a trace."""

from __future__ import annotations

import io
import zipfile
from pathlib import Path

import numpy as np
import pytest

import brdfit
from brdfit.reconstruct import Reconstruction
from brdfit.viewer import app
from brdfit.viewer.serve import Server
from brdfit.viewer.workbench import Workbench

from viewer_client import Client


def left(bench: Workbench) -> list[str]:
    """Return what lies in the private folder."""
    return sorted(path.name for path in bench.store.folder.rglob("*") if path.is_file())


def test_measurements_are_taken_in_and_fitted(
    ask: Client, bench: Workbench, lobe_csv: Path
) -> None:
    upload = ask("api/uploads?name=lobe.csv", "POST", lobe_csv.read_bytes())
    assert upload.json["kind"] == "samples"
    assert upload.json["count"] == 90
    job = ask("api/fits", "POST", {"source": upload.json["id"], "method": "quick"}).json
    ended = ask.wait(job["id"])
    assert ended["state"] == "done"
    entry = ask(f"api/entries/{ended['entry']}").json
    assert entry["samples"]["outliers"] == 1
    assert entry["fit"]["method"] == "quick"
    assert left(bench) == ["lobe.csv"]


def test_a_table_can_be_looked_at_at_once(
    ask: Client, lobe: Reconstruction, tmp_path: Path
) -> None:
    path = tmp_path / "lobe.npz"
    brdfit.write_table(lobe.table(), path)
    upload = ask("api/uploads?name=lobe.npz", "POST", path.read_bytes()).json
    assert upload["kind"] == "table"
    assert ask(f"api/entries/{upload['entry']}").json["kind"] == "table"


def test_the_reader_is_told_what_the_page_says_of_the_columns(ask: Client, lobe_csv: Path) -> None:
    text = lobe_csv.read_bytes()
    as_is = ask("api/uploads?name=lobe.csv&angles=degrees", "POST", text)
    assert as_is.json["warnings"] == []
    wrong = ask("api/uploads?name=lobe.csv&angles=radians", "POST", text)
    assert any("cannot be used" in warning for warning in wrong.json["warnings"])
    unknown = ask("api/uploads?name=lobe.csv&angels=degrees", "POST", text)
    assert unknown.code == 400
    assert "Did you mean 'angles'?" in unknown.json["message"]


@pytest.mark.parametrize("name", ["", "..", "///"])
def test_a_name_that_is_none_is_refused(ask: Client, name: str) -> None:
    assert ask(f"api/uploads?name={name}", "POST", b"1,2,3").code == 400


@pytest.mark.parametrize("announced", [True, False])
def test_an_oversized_upload_is_refused_and_leaves_nothing(
    ask: Client, bench: Workbench, monkeypatch: pytest.MonkeyPatch, announced: bool
) -> None:
    monkeypatch.setattr(app, "UPLOAD_LIMIT", 1000)
    if announced:
        answer = ask("api/uploads?name=a.csv", "POST", b"x" * 2000)
    else:
        chunks = b"".join(b"200\r\n" + b"x" * 512 + b"\r\n" for _ in range(4)) + b"0\r\n\r\n"
        answer = ask("api/uploads?name=a.csv", "POST", chunks, Transfer_Encoding="chunked")
    assert answer.code == 413
    assert "brdfit view FILE" in answer.json["message"]
    assert left(bench) == []


def bomb() -> bytes:
    """Return an .npz of 600 kB that unpacks to 600 MB."""
    content = io.BytesIO()
    header = io.BytesIO()
    shape = (600 << 17,)
    np.lib.format.write_array_header_1_0(
        header, {"descr": "<f8", "fortran_order": False, "shape": shape}
    )
    zeros = bytes(1 << 20)
    with (
        zipfile.ZipFile(content, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive,
        archive.open("values.npy", "w", force_zip64=True) as member,
    ):
        member.write(header.getvalue())
        for _ in range(600):
            member.write(zeros)
    return content.getvalue()


def test_a_zip_bomb_is_refused_before_it_is_unpacked(ask: Client, bench: Workbench) -> None:
    content = bomb()
    assert len(content) < 1 << 20
    answer = ask("api/uploads?name=bomb.npz", "POST", content)
    assert answer.code == 422
    assert "would unpack to" in answer.json["message"]
    assert left(bench) == []


def test_a_pickle_is_never_loaded(ask: Client, bench: Workbench, tmp_path: Path) -> None:
    witness = tmp_path / "witness"

    class Evil:
        def __reduce__(self) -> tuple[object, ...]:
            return Path.touch, (witness,)

    content = io.BytesIO()
    np.savez(content, values=np.array([Evil()], dtype=object), format=np.array("brdfit.table/1"))
    answer = ask("api/uploads?name=evil.npz", "POST", content.getvalue())
    assert answer.code == 422
    assert not witness.exists()
    assert left(bench) == []


def test_a_parquet_file_of_absurd_length_is_refused(
    ask: Client, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    import pyarrow as pa
    from pyarrow import parquet

    path = tmp_path / "long.parquet"
    parquet.write_table(pa.table({"R": np.zeros(100_000)}), path)
    monkeypatch.setattr("brdfit.viewer.uploads._MOST_NUMBERS", 10_000)
    answer = ask("api/uploads?name=long.parquet", "POST", path.read_bytes())
    assert answer.code == 422
    assert "100,000 numbers" in answer.json["message"]


def test_a_file_of_no_format_is_refused_in_words_and_leaves_nothing(
    ask: Client, bench: Workbench
) -> None:
    answer = ask("api/uploads?name=notes.txt", "POST", b"hello, this is no measurement\n" * 5)
    assert answer.code == 422
    assert "notes.txt" in answer.json["message"]
    assert str(bench.store.folder) not in answer.json["message"]
    assert left(bench) == []


def test_the_private_folder_is_for_its_owner_and_goes_at_the_end(lobe_csv: Path) -> None:
    with Workbench() as bench:
        folder = bench.store.folder
        assert folder.stat().st_mode & 0o077 == 0
        with Server(bench).running() as server:
            Client(server)("api/uploads?name=a.csv", "POST", lobe_csv.read_bytes())
        assert left(bench) == ["a.csv"]
    assert not folder.exists()


def test_the_oldest_upload_goes_when_there_are_too_many_but_never_a_file_of_the_user(
    lobe_csv: Path,
) -> None:
    from brdfit.viewer.opening import open_path
    from brdfit.viewer.store import Held, NotThere, Store

    with Store(keep=2) as store:
        own = open_path(lobe_csv, "u1")
        assert isinstance(own, Held)
        store.add(own)
        for n in range(2):
            folder = store.folder / str(n)
            folder.mkdir()
            path = folder / "a.csv"
            path.write_bytes(lobe_csv.read_bytes())
            held = open_path(path, f"v{n}")
            assert isinstance(held, Held)
            store.add(held)
        with pytest.raises(NotThere, match="u1"):
            store.get("u1")
        assert lobe_csv.exists()
        store.add(own)
        assert not (store.folder / "0" / "a.csv").exists()
        assert (store.folder / "1" / "a.csv").exists()
