"""Asks a running viewer, as a browser would or as a browser never would: for the tests."""

from __future__ import annotations

import http.client
import json
from dataclasses import dataclass, field
from typing import Any

from brdfit.viewer.serve import Server

__all__ = ["Answer", "Client"]


@dataclass
class Answer:
    """What the server said."""

    code: int
    body: bytes
    headers: dict[str, str] = field(default_factory=dict)

    @property
    def json(self) -> Any:
        """The body as JSON."""
        return json.loads(self.body)


class Client:
    """Asks the server as a browser would, or as a browser never would."""

    def __init__(self, server: Server) -> None:
        self.server = server

    def __call__(
        self,
        path: str,
        method: str = "GET",
        body: Any = None,
        *,
        raw: bool = False,
        host: str | None = None,
        **headers: str,
    ) -> Answer:
        """Send one request; `raw` paths come as they are, without the token."""
        target = path if raw else f"/{self.server.token}/{path}"
        connection = http.client.HTTPConnection("127.0.0.1", self.server.port, timeout=20)
        try:
            connection.putrequest(method, target, skip_host=True, skip_accept_encoding=True)
            connection.putheader("Host", host or f"127.0.0.1:{self.server.port}")
            content = body if isinstance(body, bytes | None) else json.dumps(body).encode()
            for name, value in headers.items():
                connection.putheader(name.replace("_", "-"), value)
            if content is not None and "Transfer_Encoding" not in headers:
                connection.putheader("Content-Length", str(len(content)))
            connection.endheaders(content)
            answer = connection.getresponse()
            return Answer(answer.status, answer.read(), dict(answer.headers))
        finally:
            connection.close()

    def wait(self, job: str) -> dict[str, Any]:
        """Watch a job until it ends; return its last state."""
        text = self(f"api/jobs/{job}/events").body.decode()
        last = [line for line in text.splitlines() if line.startswith("data: ")][-1]
        ended: dict[str, Any] = json.loads(last.removeprefix("data: "))
        return ended
