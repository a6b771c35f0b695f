"""The server: a socket on 127.0.0.1, and what runs behind it until it is asked to end."""

from __future__ import annotations

import contextlib
import socket
import threading
from collections.abc import Iterator

import uvicorn

from brdfit.errors import UsageError
from brdfit.viewer.app import make_app
from brdfit.viewer.guard import new_token
from brdfit.viewer.workbench import Workbench

__all__ = ["Server"]

_ADDRESS = "127.0.0.1"


class Server:
    """A workbench under an address with a token; bound at once, serving from `run` on."""

    def __init__(self, bench: Workbench, port: int = 0) -> None:
        self._socket = _bound(port)
        self.port: int = self._socket.getsockname()[1]
        self.token = new_token()
        hosts = frozenset(f"{name}:{self.port}" for name in (_ADDRESS, "localhost"))
        config = uvicorn.Config(
            make_app(bench, self.token, hosts),
            lifespan="off",
            log_level="error",
            access_log=False,
            server_header=False,
            date_header=False,
            timeout_keep_alive=30,
            timeout_graceful_shutdown=2,
            ws="none",
        )
        self._server = uvicorn.Server(config)

    @property
    def url(self) -> str:
        """The address of the page, token included."""
        return f"http://{_ADDRESS}:{self.port}/{self.token}/"

    def run(self) -> None:
        """Serve until Ctrl-C, a termination signal, or `stop`."""
        try:
            self._server.run(sockets=[self._socket])
        finally:
            self.close()

    def close(self) -> None:
        """Let go of the port."""
        self._socket.close()

    def stop(self) -> None:
        """End serving, from any thread."""
        self._server.should_exit = True

    @contextlib.contextmanager
    def running(self) -> Iterator[Server]:
        """Serve on a thread while the block runs: for notebooks and tests."""
        thread = threading.Thread(target=self.run, name="brdfit-view", daemon=True)
        thread.start()
        try:
            yield self
        finally:
            self.stop()
            thread.join()


def _bound(port: int) -> socket.socket:
    listener = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    try:
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listener.bind((_ADDRESS, port))
        listener.listen(128)
    except OSError as error:
        listener.close()
        raise UsageError(
            f"--port: {port} cannot be used ({error.strerror}). Leave it out: a free one is found."
        ) from error
    return listener
