"""Downloads, against a server on this machine that each test starts and ends."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from dataclasses import replace
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import pytest

from brdfit.errors import PopulationError, UsageError
from brdfit.files import sha256_of_bytes
from brdfit.populations import fetch
from brdfit.populations.fetch import download, fetched_path
from brdfit.populations.known import KNOWN

CONTENT = bytes(range(256)) * 500
KNOWN_HERE = replace(KNOWN["nbrdf"], sha256=sha256_of_bytes(CONTENT))


class _Handler(BaseHTTPRequestHandler):
    asked: list[str]

    def do_GET(self) -> None:
        type(self).asked.append(self.path)
        if self.path == "/missing.zip":
            self.send_error(404)
            return
        body = CONTENT[::-1] if self.path == "/altered.zip" else CONTENT
        self.send_response(200)
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        # a connection that breaks: fewer bytes than were promised
        self.wfile.write(body[:1000] if self.path == "/interrupted.zip" else body)

    def log_message(self, format: str, *args: object) -> None:
        """Say nothing."""


@pytest.fixture
def server() -> Iterator[str]:
    """Return the address of a server that lives as long as the test."""
    _Handler.asked = []
    with ThreadingHTTPServer(("127.0.0.1", 0), _Handler) as http:
        thread = threading.Thread(target=http.serve_forever, args=(0.01,))
        thread.start()
        yield f"http://127.0.0.1:{http.server_address[1]}"
        http.shutdown()
        thread.join()


def left_in(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir() if path.suffix != ".lock")


def test_a_good_file_arrives_whole_with_progress(server: str, tmp_path: Path) -> None:
    heard: list[tuple[str, int, int]] = []
    target = tmp_path / "good.zip"
    found = download(KNOWN_HERE, f"{server}/good.zip", target, lambda *e: heard.append(e))
    assert found == target
    assert target.read_bytes() == CONTENT
    assert heard[0][1] == 0
    assert heard[-1][1:] == (len(CONTENT), len(CONTENT))
    assert all(0 <= done <= total for _, done, total in heard)


def test_a_file_that_is_there_is_not_fetched_again(server: str, tmp_path: Path) -> None:
    target = tmp_path / "good.zip"
    for _ in range(2):
        download(KNOWN_HERE, f"{server}/good.zip", target)
    assert len(_Handler.asked) == 1


def test_a_damaged_file_that_is_there_is_fetched_again(server: str, tmp_path: Path) -> None:
    target = tmp_path / "good.zip"
    target.write_bytes(CONTENT[:100])
    download(KNOWN_HERE, f"{server}/good.zip", target)
    assert target.read_bytes() == CONTENT


def test_a_wrong_hash_is_refused_and_nothing_stays(server: str, tmp_path: Path) -> None:
    with pytest.raises(PopulationError, match="does not have the SHA-256"):
        download(KNOWN_HERE, f"{server}/altered.zip", tmp_path / "altered.zip")
    assert left_in(tmp_path) == []


def test_a_missing_file_names_the_answer_of_the_server(server: str, tmp_path: Path) -> None:
    with pytest.raises(PopulationError, match="the server answered 404"):
        download(KNOWN_HERE, f"{server}/missing.zip", tmp_path / "missing.zip")
    assert left_in(tmp_path) == []


def test_a_broken_connection_leaves_nothing(server: str, tmp_path: Path) -> None:
    with pytest.raises(PopulationError, match="did not complete"):
        download(KNOWN_HERE, f"{server}/interrupted.zip", tmp_path / "interrupted.zip")
    assert left_in(tmp_path) == []


def test_an_interrupt_by_the_user_leaves_nothing(server: str, tmp_path: Path) -> None:
    def interrupt(label: str, done: int, total: int) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        download(KNOWN_HERE, f"{server}/good.zip", tmp_path / "good.zip", interrupt)
    assert left_in(tmp_path) == []


def test_no_server_at_all_says_what_to_do(tmp_path: Path) -> None:
    with pytest.raises(PopulationError, match="download it by hand from"):
        # port 9 is nobody's here
        download(KNOWN_HERE, "http://127.0.0.1:9/good.zip", tmp_path / "good.zip")


def test_nothing_is_printed(server: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    download(KNOWN_HERE, f"{server}/good.zip", tmp_path / "good.zip")
    assert capfd.readouterr() == ("", "")


def test_fetch_puts_the_file_where_the_population_is_looked_for(
    server: str, cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(KNOWN, "nbrdf", KNOWN_HERE)
    path = fetch("nbrdf", url=f"{server}/mirror/merl_nbrdf.zip")
    assert path == fetched_path("nbrdf")
    assert path.is_relative_to(cache)
    assert path.read_bytes() == CONTENT


def test_the_published_networks_have_an_address_and_a_hash() -> None:
    assert KNOWN["nbrdf"].url.endswith("/data/merl_nbrdf.zip")
    assert KNOWN["nbrdf"].sha256.startswith("d1678c0c")


def test_merl_is_not_fetched_but_its_terms_are_shown(cache: Path) -> None:
    with pytest.raises(PopulationError, match=r"Terms: .*CC-BY-SA.* give the path of their folder"):
        fetch("merl")


@pytest.mark.parametrize("name", ["published", "synthetic", "embedded"])
def test_what_comes_along_needs_no_fetching(cache: Path, name: str) -> None:
    with pytest.raises(PopulationError, match="nothing to fetch"):
        fetch(name)


def test_an_unknown_name_lists_the_known() -> None:
    with pytest.raises(UsageError, match="published, synthetic, embedded, nbrdf, merl"):
        fetch("cornell")
