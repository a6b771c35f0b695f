"""Who may ask: the server's own host name, its own origin, and who knows the token.

Another page in the same browser can send requests to 127.0.0.1, under that name or under one
of its own that it lets point there (DNS rebinding). It does not know the token, its `Host`
or `Origin` is not ours, and our pages are read by nobody else's scripts.
"""

from __future__ import annotations

import secrets
from collections.abc import Awaitable, Callable, MutableMapping
from typing import Any

from starlette.responses import PlainTextResponse, Response

__all__ = ["HEADERS", "Guard", "new_token"]

Scope = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[MutableMapping[str, Any]]]
Send = Callable[[MutableMapping[str, Any]], Awaitable[None]]
App = Callable[[Scope, Receive, Send], Awaitable[None]]

HEADERS = {
    "Content-Security-Policy": (
        "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; "
        "img-src 'self' data: blob:; connect-src 'self'; base-uri 'none'; form-action 'none'; "
        "frame-ancestors 'none'"
    ),
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
    "Cache-Control": "no-store",
}
"""Sent with every answer: nothing from elsewhere, nothing to elsewhere, nothing kept."""


def new_token() -> str:
    """Return a random token of 256 bits, fit for an address."""
    return secrets.token_urlsafe(32)


class Guard:
    """Lets a request through to `app` with the token taken off its path, or refuses it."""

    def __init__(self, app: App, token: str, hosts: frozenset[str]) -> None:
        self._app = app
        self._token = token.encode("ascii")
        self._hosts = hosts

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer one request."""
        if scope["type"] == "lifespan":
            await self._app(scope, receive, send)
            return
        refusal = self._refusal(scope)
        if refusal is not None:
            await refusal(scope, receive, send)
            return
        _, _, rest = scope["path"][1:].partition("/")
        path = f"/{rest}"
        await self._app({**scope, "path": path, "raw_path": path.encode()}, receive, send)

    def _refusal(self, scope: Scope) -> Response | None:
        if scope["type"] != "http":
            return _refuse(400, "only HTTP is spoken here")
        headers: dict[bytes, list[bytes]] = {}
        for name, value in scope["headers"]:
            headers.setdefault(name.lower(), []).append(value)
        hosts = [value.decode("latin-1") for value in headers.get(b"host", [])]
        if len(hosts) != 1 or hosts[0] not in self._hosts:
            return _refuse(421, "this server answers under its own address only")
        origins = [value.decode("latin-1") for value in headers.get(b"origin", [])]
        if any(origin != f"http://{hosts[0]}" for origin in origins):
            return _refuse(403, "another page may not ask here")
        site = headers.get(b"sec-fetch-site", [b"same-origin"])[0]
        first = scope["path"].count("/") == 2 and scope["path"].endswith("/")
        if site not in (b"same-origin", b"none") and not (first and scope["method"] == "GET"):
            return _refuse(403, "another page may not ask here")
        raw: bytes = scope.get("raw_path") or scope["path"].encode()
        if b".." in raw or b"%" in raw or b"\\" in raw or b"//" in raw:
            return _refuse(400, "the path is not one of this server's")
        given = scope["path"][1:].partition("/")[0].encode("utf-8", "replace")
        if not secrets.compare_digest(given, self._token):
            return _refuse(403, "the token is missing or wrong: open the address as it was printed")
        return None


def _refuse(code: int, why: str) -> Response:
    return PlainTextResponse(f"{code}: {why}\n", status_code=code, headers=HEADERS)
