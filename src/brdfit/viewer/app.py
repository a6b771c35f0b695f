"""Addresses and what answers under each: a thin layer over `Workbench`.

| address                            | answer                                              |
|------------------------------------|-----------------------------------------------------|
| GET  /                             | the page                                            |
| GET  /static/NAME                  | its script and style                                |
| GET  /api/home                     | `Home`                                              |
| GET  /api/entries/ID               | `Entry`                                             |
| GET  /api/entries/ID/table         | the packed table (`brdfit.report.packed_table`)     |
| GET  /api/entries/ID/albedo        | `Albedo`                                            |
| GET  /api/entries/ID/samples       | `SampleColumns`                                     |
| GET  /api/entries/ID/samples/N     | `SampleDetail`                                      |
| GET  /api/entries/ID/slice         | `SlicePanel`; ?theta_i=&phi=                        |
| GET  /api/entries/ID/trust         | `TrustPlane`; ?phi_d=                               |
| GET  /api/entries/ID/download      | a file; ?kind=&format=                              |
| GET  /api/comparison               | `ComparisonTable`; ?reference=&test=                |
| POST /api/uploads                  | `Upload`; the file is the body, ?name=              |
| POST /api/environments             | `LightSet`; the picture is the body, ?name=         |
| POST /api/fits                     | `Job` for a `FitRequest`                            |
| GET  /api/jobs/ID/events           | a stream of `Job`                                   |
| DELETE /api/jobs/ID                | `Job`, asked to stop                                |

Every refusal is a `Problem`.
"""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable
from importlib.resources import files
from typing import Any

import msgspec
from starlette.applications import Starlette
from starlette.background import BackgroundTask
from starlette.concurrency import run_in_threadpool
from starlette.requests import Request
from starlette.responses import FileResponse, Response, StreamingResponse
from starlette.routing import Route

from brdfit.errors import BrdfitError, FitError, FormatError, MissingExtra, SampleError, UsageError
from brdfit.viewer.describe import albedo_message, columns_message, entry_message
from brdfit.viewer.guard import HEADERS, Guard
from brdfit.viewer.messages import FitRequest, Problem
from brdfit.viewer.sample_detail import sample_message
from brdfit.viewer.store import NotThere
from brdfit.viewer.trust import trust_message
from brdfit.viewer.uploads import TooLarge, body_within, receive_file
from brdfit.viewer.workbench import UPLOAD_LIMIT, Workbench

__all__ = ["make_app"]

_ASSETS = {
    "index.html": "text/html; charset=utf-8",
    "viewer.js": "text/javascript; charset=utf-8",
    "viewer.css": "text/css; charset=utf-8",
}
_LONGEST_REQUEST = 1 << 20
_TICK = 0.1
_HEARTBEAT = 3.0
# What went wrong -> status code; the first that fits.
_CODES: tuple[tuple[type[BrdfitError], int], ...] = (
    (NotThere, 404),
    (TooLarge, 413),
    (UsageError, 400),
    (FormatError, 422),
    (SampleError, 422),
    (FitError, 422),
    (MissingExtra, 501),
    (BrdfitError, 500),
)


def make_app(bench: Workbench, token: str, hosts: frozenset[str]) -> Guard:
    """Return the ASGI application of a workbench, for those who know the token."""
    routes = [*_page_routes(), *_entry_routes(bench), *_work_routes(bench)]
    handlers: dict[Any, Any] = {
        BrdfitError: _refused,
        ValueError: _nonsense,
        404: _no_such_address,
        405: _no_such_address,
    }
    return Guard(Starlette(routes=routes, exception_handlers=handlers), token, hosts)


def _page_routes() -> list[Route]:
    static = files("brdfit.viewer") / "static"
    contents = {name: (static / name).read_bytes() for name in _ASSETS}

    def page(request: Request) -> Response:
        return asset("index.html")

    def script(request: Request) -> Response:
        return asset(request.path_params["name"])

    def asset(name: str) -> Response:
        if name not in contents:
            raise NotThere(f"{name}: there is no such file.")
        return Response(contents[name], media_type=_ASSETS[name], headers=HEADERS)

    return [Route("/", page), Route("/static/{name}", script)]


def _entry_routes(bench: Workbench) -> list[Route]:
    item = bench.store.item

    def entry(request: Request) -> Response:
        return _json(entry_message(item(request.path_params["id"])))

    def table(request: Request) -> Response:
        found = item(request.path_params["id"])
        return Response(
            found.packed.content,
            media_type="application/octet-stream",
            headers={**HEADERS, "Content-Encoding": "deflate"},
            background=BackgroundTask(found.ahead),
        )

    def albedo(request: Request) -> Response:
        return _json(albedo_message(item(request.path_params["id"])))

    def samples(request: Request) -> Response:
        found = item(request.path_params["id"])
        if found.fitted.judged is None:
            raise NotThere(f"{found.name}: no samples are known.")
        return _json(columns_message(found.fitted.judged))

    def sample(request: Request) -> Response:
        parameters = request.path_params
        return _json(sample_message(item(parameters["id"]), int(parameters["n"])))

    def slice_(request: Request) -> Response:
        theta_i, phi = _number(request, "theta_i", 45.0), _number(request, "phi", 180.0)
        return _json(item(request.path_params["id"]).slice(theta_i, phi))

    def trust(request: Request) -> Response:
        return _json(
            trust_message(item(request.path_params["id"]), _number(request, "phi_d", 90.0))
        )

    def download(request: Request) -> Response:
        query = request.query_params
        path, name = bench.download(
            request.path_params["id"], query.get("kind", "table"), query.get("format", "merl")
        )
        done = BackgroundTask(path.unlink, missing_ok=True)
        return FileResponse(path, filename=name, headers=HEADERS, background=done)

    answers: dict[str, Callable[[Request], Response]] = {
        "": entry,
        "/table": table,
        "/albedo": albedo,
        "/samples": samples,
        "/samples/{n:int}": sample,
        "/slice": slice_,
        "/trust": trust,
        "/download": download,
    }
    return [Route(f"/api/entries/{{id}}{rest}", answer) for rest, answer in answers.items()]


def _work_routes(bench: Workbench) -> list[Route]:
    def home(request: Request) -> Response:
        return _json(bench.home())

    def comparison(request: Request) -> Response:
        query = request.query_params
        return _json(bench.compare(query.get("reference", ""), query.get("test", "")))

    async def upload(request: Request) -> Response:
        options = dict(request.query_params)
        name = options.pop("name", "")
        path = await receive_file(request, bench.store.folder, name, UPLOAD_LIMIT)
        return _json(await run_in_threadpool(bench.upload, path, options))

    async def environment(request: Request) -> Response:
        name = request.query_params.get("name", "")
        path = await receive_file(request, bench.store.folder, name, UPLOAD_LIMIT)
        return _json(await run_in_threadpool(bench.environment, path))

    async def fit(request: Request) -> Response:
        body = await body_within(request, _LONGEST_REQUEST)
        wanted = msgspec.json.decode(body, type=FitRequest)
        return _json(await run_in_threadpool(bench.fit, wanted))

    async def events(request: Request) -> Response:
        id = request.path_params["id"]
        bench.jobs.get(id)
        return StreamingResponse(
            _events(bench, id), media_type="text/event-stream", headers=HEADERS
        )

    def cancel(request: Request) -> Response:
        return _json(bench.jobs.cancel(request.path_params["id"]))

    return [
        Route("/api/home", home),
        Route("/api/comparison", comparison),
        Route("/api/uploads", upload, methods=["POST"]),
        Route("/api/environments", environment, methods=["POST"]),
        Route("/api/fits", fit, methods=["POST"]),
        Route("/api/jobs/{id}/events", events),
        Route("/api/jobs/{id}", cancel, methods=["DELETE"]),
    ]


async def _events(bench: Workbench, id: str) -> AsyncIterator[bytes]:
    bench.jobs.watch(id)
    try:
        said, quiet = b"", 0.0
        while True:
            job = bench.jobs.get(id)
            text = msgspec.json.encode(job)
            if text != said or quiet >= _HEARTBEAT:
                yield b"data: " + text + b"\n\n"
                said, quiet = text, 0.0
            if job.state in ("done", "failed", "cancelled"):
                return
            await asyncio.sleep(_TICK)
            quiet += _TICK
    finally:
        bench.jobs.unwatch(id)


def _json(message: Any, code: int = 200) -> Response:
    # msgspec writes what is not finite as null
    content = msgspec.json.encode(message)
    return Response(content, code, media_type="application/json", headers=HEADERS)


def _number(request: Request, name: str, default: float) -> float:
    text = request.query_params.get(name)
    if text is None:
        return default
    try:
        value = float(text)
    except ValueError:
        value = float("nan")
    if not -1e6 < value < 1e6:
        raise UsageError(f"{name}: found {text!r} but expected a number of degrees.")
    return value


async def _refused(request: Request, error: Exception) -> Response:
    code = next(code for kind, code in _CODES if isinstance(error, kind))
    return _json(Problem(type(error).__name__, str(error)), code)


async def _nonsense(request: Request, error: Exception) -> Response:
    # msgspec.ValidationError and .DecodeError are ValueErrors; anything else is a defect
    if isinstance(error, msgspec.MsgspecError):
        return _json(Problem("UsageError", f"the request cannot be understood: {error}"), 400)
    raise error


async def _no_such_address(request: Request, error: Exception) -> Response:
    return _json(Problem("NotThere", f"{request.url.path}: there is no such address."), 404)
