"""Fits that are watched, cancelled, and outlived by the server."""

from __future__ import annotations

import http.client
import json
import socket
import threading
import time
from pathlib import Path
from typing import Any

import pytest

from brdfit.errors import UsageError
from brdfit.progress import Progress
from brdfit.reconstruct import Reconstruction
from brdfit.viewer.item import Item
from brdfit.viewer.jobs import Jobs
from brdfit.viewer.serve import Server
from brdfit.viewer.workbench import Workbench

from viewer_client import Client


def until(condition: Any, seconds: float = 20.0) -> None:
    """Wait until `condition()`; fail if it never comes."""
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.01)


def for_ever(progress: Progress) -> Item:
    while True:
        progress("turning", 1, 2)
        time.sleep(0.005)


@pytest.fixture
def jobs() -> Any:
    one = Jobs(patience=0.2)
    yield one
    one.close()


def test_a_fit_reports_its_progress_and_ends_with_an_entry(
    ask: Client, bench: Workbench, lobe: Reconstruction
) -> None:
    bench.open(lobe)
    job = ask("api/fits", "POST", {"source": "e1"}).json
    text = ask(f"api/jobs/{job['id']}/events").body.decode()
    states = [json.loads(line[6:]) for line in text.splitlines() if line.startswith("data: ")]
    assert states[-1]["state"] == "done"
    assert states[-1]["replaces"] == "e1"
    assert bench.store.item(states[-1]["entry"]).parent == "e1"


def test_a_fit_can_be_cancelled(ask: Client, bench: Workbench, lobe: Reconstruction) -> None:
    bench.open(lobe)
    job = ask("api/fits", "POST", {"source": "e1", "method": "slow"}).json
    until(lambda: bench.jobs.get(job["id"]).state == "running")
    assert ask(f"api/jobs/{job['id']}", "DELETE").code == 200
    assert ask.wait(job["id"])["state"] == "cancelled"
    # and the next one runs
    after = ask("api/fits", "POST", {"source": "e1"}).json
    assert ask.wait(after["id"])["state"] == "done"


def test_one_that_waits_is_cancelled_at_once(jobs: Jobs) -> None:
    jobs.start("a", "first", for_ever, keep=True)
    jobs.start("b", "second", for_ever, keep=True)
    until(lambda: jobs.get("a").state == "running")
    assert jobs.cancel("b").state == "cancelled"
    jobs.cancel("a")
    until(lambda: jobs.get("a").state == "cancelled")


def test_a_fit_whose_watcher_goes_away_is_cancelled(jobs: Jobs) -> None:
    jobs.start("a", "first", for_ever)
    jobs.watch("a")
    time.sleep(0.4)
    assert jobs.get("a").state == "running"
    jobs.unwatch("a")
    until(lambda: jobs.get("a").state == "cancelled")


def test_a_fit_that_was_to_be_kept_needs_no_watcher(jobs: Jobs) -> None:
    jobs.start("a", "first", for_ever, keep=True)
    time.sleep(0.4)
    assert jobs.get("a").state == "running"


def test_an_error_of_the_fit_reaches_whoever_watches(jobs: Jobs) -> None:
    def refuse(progress: Progress) -> Item:
        raise UsageError("three samples are too few")

    def break_down(progress: Progress) -> Item:
        raise RuntimeError("out of order")

    jobs.start("a", "first", refuse)
    jobs.start("b", "second", break_down)
    until(lambda: jobs.get("b").state == "failed")
    assert jobs.get("a").message == "three samples are too few"
    assert "defect of brdfit" in jobs.get("b").message


def test_too_many_that_wait_are_refused(jobs: Jobs) -> None:
    jobs.start("first", "the one that runs", for_ever, keep=True)
    until(lambda: jobs.get("first").state == "running")
    for n in range(20):
        jobs.start(str(n), "one of many", for_ever, keep=True)
    with pytest.raises(UsageError, match="20 fits are waiting already"):
        jobs.start("last", "one too many", for_ever, keep=True)


def test_a_client_that_vanishes_mid_fit_does_no_harm(
    ask: Client, bench: Workbench, server: Server, lobe: Reconstruction
) -> None:
    bench.jobs._patience = 0.2
    bench.open(lobe)
    job = ask("api/fits", "POST", {"source": "e1", "method": "slow"}).json
    with socket.create_connection(("127.0.0.1", server.port), timeout=5) as watcher:
        path = f"/{server.token}/api/jobs/{job['id']}/events"
        head = f"GET {path} HTTP/1.1\r\nHost: 127.0.0.1:{server.port}\r\n\r\n"
        watcher.sendall(head.encode())
        until(lambda: b"running" in watcher.recv(4096))
    until(lambda: bench.jobs.get(job["id"]).state == "cancelled")
    assert ask("api/home").code == 200


def test_a_client_that_vanishes_within_an_upload_leaves_nothing(
    ask: Client, bench: Workbench, server: Server, lobe_csv: Path
) -> None:
    with socket.create_connection(("127.0.0.1", server.port), timeout=5) as sender:
        head = (
            f"POST /{server.token}/api/uploads?name=a.csv HTTP/1.1\r\n"
            f"Host: 127.0.0.1:{server.port}\r\nContent-Length: 100000\r\n\r\n"
        )
        sender.sendall(head.encode() + lobe_csv.read_bytes())
        until(lambda: any(bench.store.folder.iterdir()))
    until(lambda: not any(bench.store.folder.iterdir()))
    assert ask("api/home").code == 200


def test_fifty_clients_at_once_are_all_served(
    ask: Client, bench: Workbench, lobe: Reconstruction
) -> None:
    bench.open(lobe)
    answers: list[int] = []

    def visit() -> None:
        try:
            pages = ("", "static/viewer.js", "api/home", "api/entries/e1/samples")
            answers.extend(ask(path).code for path in pages)
            table = ask("api/entries/e1/table")
            answers.append(table.code if len(table.body) > 1000 else -1)
            answers.append(ask("api/entries/e1/slice?theta_i=30").code)
        except (OSError, http.client.HTTPException):
            answers.append(-1)

    threads = [threading.Thread(target=visit) for _ in range(50)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert answers == [200] * 300
