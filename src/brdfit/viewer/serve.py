"""The server: a socket on 127.0.0.1, and what runs behind it until it is asked to end."""

from __future__ import annotations

import contextlib
import signal
import socket
import threading
from collections.abc import Iterator
from types import FrameType

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
        """Serve until Ctrl-C, a termination signal, `stop`, or the terminal is closed."""
        try:
            with self._hanging_up():
                self._server.run(sockets=[self._socket])
        finally:
            self.close()

    @contextlib.contextmanager
    def _hanging_up(self) -> Iterator[None]:
        """End on SIGHUP too, then let it do what it would have done, as uvicorn does for others.

        An exception out of a handler of signals may be lost in the loop of events.
        """
        hang_up = getattr(signal, "SIGHUP", None)  # Windows has none
        if (
            hang_up is None
            or threading.current_thread() is not threading.main_thread()
            or signal.getsignal(hang_up) is signal.SIG_IGN
        ):
            yield
            return
        heard: list[int] = []

        def stop(number: int, frame: FrameType | None) -> None:
            heard.append(number)
            self.stop()

        before = signal.signal(hang_up, stop)
        try:
            yield
        finally:
            signal.signal(hang_up, before)
        if heard:
            signal.raise_signal(hang_up)

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
