"""The server answers under its own name, to whoever knows the token, and to nobody else."""

from __future__ import annotations

import socket

import pytest

from brdfit.viewer.serve import Server

from viewer_client import Client


def test_the_page_and_its_parts_are_served_to_who_knows_the_token(ask: Client) -> None:
    page = ask("")
    assert page.code == 200
    assert b'src="static/viewer.js"' in page.body
    for name in ("viewer.js", "viewer.css"):
        assert ask(f"static/{name}").code == 200
    assert ask("api/home").json["entries"] == []


def test_every_answer_forbids_other_origins_and_keeping(ask: Client) -> None:
    for answer in (ask(""), ask("api/home"), ask("api/nothing"), ask("/", raw=True)):
        policy = answer.headers["content-security-policy"]
        assert "default-src 'none'" in policy
        assert "connect-src 'self'" in policy
        assert answer.headers["referrer-policy"] == "no-referrer"
        assert answer.headers["cache-control"] == "no-store"
        assert "access-control-allow-origin" not in answer.headers


@pytest.mark.parametrize(
    "path",
    ["/", "/api/home", "/wrong/api/home", "/static/viewer.js", "/{short}/api/home"],
)
def test_a_missing_or_wrong_token_is_refused(ask: Client, server: Server, path: str) -> None:
    answer = ask(path.format(short=server.token[:-1]), raw=True)
    assert answer.code == 403
    assert b"token" in answer.body


@pytest.mark.parametrize("host", ["example.org", "127.0.0.1", "127.0.0.1:1", "evil.test:{port}"])
def test_another_host_is_refused(ask: Client, server: Server, host: str) -> None:
    assert ask("api/home", host=host.format(port=server.port)).code == 421


def test_its_own_names_are_accepted(ask: Client, server: Server) -> None:
    for host in ("127.0.0.1", "localhost"):
        name = f"{host}:{server.port}"
        assert ask("api/home", host=name, Origin=f"http://{name}").code == 200


@pytest.mark.parametrize(
    "origin", ["http://example.org", "null", "https://127.0.0.1:{port}", "http://127.0.0.1:1"]
)
def test_another_origin_is_refused_whatever_it_knows(
    ask: Client, server: Server, origin: str
) -> None:
    origin = origin.format(port=server.port)
    assert ask("api/home", Origin=origin).code == 403
    assert ask("api/fits", "POST", {"source": "e1"}, Origin=origin).code == 403


def test_a_request_that_another_site_sends_is_refused_but_a_link_to_the_page_works(
    ask: Client,
) -> None:
    assert ask("api/home", Sec_Fetch_Site="cross-site").code == 403
    assert ask("api/home", Sec_Fetch_Site="same-origin").code == 200
    assert ask("", Sec_Fetch_Site="cross-site").code == 200


@pytest.mark.parametrize(
    "path",
    [
        "static/../static/viewer.js",
        "static/..%2f..%2fguard.py",
        "static/%2e%2e/guard.py",
        "../{token}/static/viewer.js",
        "static//etc/passwd",
        "static\\..\\guard.py",
        "api/entries/../home",
    ],
)
def test_a_path_that_climbs_is_refused(ask: Client, server: Server, path: str) -> None:
    assert ask(path.format(token=server.token)).code in (400, 403)


@pytest.mark.parametrize("path", ["static/guard.py", "static/index.html.sources.json", "api", "x"])
def test_what_is_not_offered_is_not_there(ask: Client, path: str) -> None:
    answer = ask(path)
    assert answer.code == 404
    assert answer.json["kind"] == "NotThere"


def test_it_listens_on_this_machine_alone(server: Server) -> None:
    assert server.url.startswith("http://127.0.0.1:")
    # 127.0.0.2 is this machine under another address, to which nothing is bound
    with pytest.raises(OSError, match="refused"):
        socket.create_connection(("127.0.0.2", server.port), timeout=5)


def test_two_servers_have_different_tokens(server: Server) -> None:
    from brdfit.viewer.guard import new_token

    assert len({new_token(), new_token(), server.token}) == 3
    assert len(server.token) >= 40
