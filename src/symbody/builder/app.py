"""The application: what each request of the page leads to."""

from __future__ import annotations

import mimetypes
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from html import escape
from pathlib import Path
from typing import Annotated, Any, Final

from fastapi import APIRouter, Depends, FastAPI, Request
from fastapi.exceptions import RequestValidationError
from fastapi.responses import HTMLResponse, JSONResponse, RedirectResponse, Response
from fastapi.staticfiles import StaticFiles
from starlette.exceptions import HTTPException

from symbody.builder import requests as asked
from symbody.builder.catalog import CARDS
from symbody.builder.formulas import formula_mathml
from symbody.builder.page_problems import fault_problem, page_problem, page_problems
from symbody.builder.refusal import status_of
from symbody.builder.security import Application, LocalOnly
from symbody.builder.services import Services
from symbody.builder.settings import BuilderSettings
from symbody.builder.task_failure import TaskFailure
from symbody.errors import Problem, SymbodyError
from symbody.formats.schema import file_schema
from symbody.model import elements

Answer = dict[str, Any]

_TOKEN_TAG: Final = '<meta name="symbody-token" content="{}">'
_CLOSED: Final = (
    "<!doctype html><meta charset=utf-8><title>symbody</title><p>Open this page by its full address: the "
    "one that <code>symbody builder</code> prints, with <code>?key=</code>."
)
# Some systems take .js for text, and browsers then run nothing of it.
_TYPES: Final = (
    ("text/javascript", ".js"),
    ("text/javascript", ".mjs"),
    ("text/css", ".css"),
    ("image/svg+xml", ".svg"),
    ("image/webp", ".webp"),
    ("font/woff2", ".woff2"),
    ("application/json", ".json"),
    ("application/wasm", ".wasm"),
)


def _services(request: Request) -> Services:
    services: Services = request.app.state.services
    return services


Builder = Annotated[Services, Depends(_services)]
# What helps a page that asks for what this server does not have: it is one of another version.
_RELOAD: Final = "reload the page; if that does not help, start symbody builder again"
api: Final = APIRouter(prefix="/api")


def make_app(settings: BuilderSettings) -> Application:
    """Return the application of a builder, behind all checks of `LocalOnly`."""
    for kind, ending in _TYPES:
        mimetypes.add_type(kind, ending)
    services = Services(settings)

    @asynccontextmanager
    async def lifespan(app: FastAPI) -> AsyncIterator[None]:
        yield
        services.close()

    app = FastAPI(title="symbody builder", docs_url=None, redoc_url=None, openapi_url=None, lifespan=lifespan)
    app.state.services = services
    app.include_router(api)
    app.add_api_route("/", _page, methods=["GET"], response_model=None)
    app.mount("/assets", StaticFiles(directory=settings.pages / "assets", check_dir=False))
    app.mount("/cards", StaticFiles(directory=CARDS))
    app.add_exception_handler(SymbodyError, _symbody_answer)
    app.add_exception_handler(TaskFailure, _failure_answer)
    app.add_exception_handler(RequestValidationError, _request_answer)
    app.add_exception_handler(HTTPException, _http_answer)
    app.add_exception_handler(Exception, _fault_answer)
    return LocalOnly(app, settings)


def _page(request: Request, builder: Builder) -> Response:
    """Answer with the page, to a browser that was given the key."""
    settings = builder.settings
    cookie = f"symbody-{settings.port}"
    if settings.is_key(request.query_params.get("key", "")):
        answer = RedirectResponse("/", status_code=303)
        answer.set_cookie(cookie, settings.key, httponly=True, samesite="strict")
        return answer
    if not settings.is_key(request.cookies.get(cookie, "")):
        return HTMLResponse(_CLOSED, status_code=403)
    builder.warm()  # while the page loads
    text = Path(settings.pages, "index.html").read_text(encoding="utf-8")
    tag = _TOKEN_TAG.format(escape(settings.token))
    empty = _TOKEN_TAG.format("")
    page = text.replace(empty, tag) if empty in text else text.replace("<head>", f"<head>{tag}", 1)
    return HTMLResponse(page)


@api.post("/schema")
def _schema(request: asked.NothingRequest) -> Answer:
    return {"schema": file_schema(), "elements": elements()}


@api.post("/examples")
def _examples(request: asked.NothingRequest, builder: Builder) -> Answer:
    return builder.documents.examples()


@api.post("/recent")
def _recent(request: asked.NothingRequest, builder: Builder) -> Answer:
    return builder.documents.recent()


@api.post("/recovery")
def _recovery(request: asked.NothingRequest, builder: Builder) -> Answer:
    return builder.documents.recovery()


@api.post("/new")
def _new(request: asked.NothingRequest, builder: Builder) -> Answer:
    return builder.documents.new()


@api.post("/open")
def _open(request: asked.OpenRequest, builder: Builder) -> Answer:
    return builder.documents.open(request)


@api.post("/folder")
def _folder(request: asked.FolderRequest, builder: Builder) -> Answer:
    return builder.documents.folder(request.path)


@api.post("/save")
def _save(request: asked.SaveRequest, builder: Builder) -> Answer:
    return builder.documents.save(request)


@api.post("/draft")
def _draft(request: asked.DraftRequest, builder: Builder) -> Answer:
    return builder.documents.save_draft(request.document, request.data)


@api.post("/adopt")
def _adopt(request: asked.AdoptRequest, builder: Builder) -> Answer:
    return builder.documents.adopt(request.document, request.path, request.name, request.fingerprint)


@api.post("/changed")
def _compare_file(request: asked.ChangedRequest, builder: Builder) -> Answer:
    return builder.documents.has_changed(request.document, request.fingerprint)


@api.post("/check")
def _check(request: asked.CheckRequest, builder: Builder) -> Response:
    return _json_response(builder.check(request))


@api.post("/redraw")
def _redraw(request: asked.CheckRequest, builder: Builder) -> Response:
    return _json_response(builder.redraw(request))


@api.post("/pose")
def _pose(request: asked.PoseRequest, builder: Builder) -> Response:
    return _json_response(builder.pose(request))


@api.post("/drag")
def _drag(request: asked.DragRequest, builder: Builder) -> Response:
    return _json_response(builder.drag(request))


@api.post("/formula")
def _formula(request: asked.FormulaRequest) -> Answer:
    return {"mathml": formula_mathml(request.text, request.pointer)}


@api.post("/job")
def _job(request: asked.JobRequest, builder: Builder) -> Answer:
    return builder.start_job(request)


@api.post("/job_state")
def _job_state(request: asked.JobStateRequest, builder: Builder) -> Answer:
    return builder.jobs.state(request.job, request.seen)


@api.post("/cancel")
def _cancel(request: asked.CancelRequest, builder: Builder) -> Answer:
    return builder.jobs.cancel(request.job)


@api.post("/equation_tab")
def _equation_tab(request: asked.EquationTabRequest, builder: Builder) -> Answer:
    return builder.equation_tab(request)


@api.post("/outputs")
def _outputs(request: asked.OutputsRequest, builder: Builder) -> Answer:
    return builder.outputs(request)


@api.post("/export")
def _export(request: asked.ExportRequest, builder: Builder) -> Answer:
    return builder.export(request)


def _json_response(text: bytes) -> Response:
    return Response(text, media_type="application/json")


def _problem_response(status: int, problems: list[Any]) -> JSONResponse:
    return JSONResponse({"problems": problems}, status_code=status)


async def _symbody_answer(request: Request, error: Exception) -> Response:
    assert isinstance(error, SymbodyError)
    return _problem_response(status_of(error), page_problems(error.problems, {}))


async def _failure_answer(request: Request, error: Exception) -> Response:
    assert isinstance(error, TaskFailure)
    return _problem_response(422, error.problems)


async def _request_answer(request: Request, error: Exception) -> Response:
    assert isinstance(error, RequestValidationError)
    faults = [(".".join(map(str, each["loc"][1:])), str(each["msg"])) for each in error.errors()[:20]]
    problems = [Problem("builder.request", where, what, fix=_RELOAD) for where, what in faults]
    return _problem_response(422, [page_problem(problem, {}) for problem in problems])


async def _http_answer(request: Request, error: Exception) -> Response:
    assert isinstance(error, HTTPException)
    problem = Problem("builder.request", request.url.path, str(error.detail), fix=_RELOAD)
    return _problem_response(error.status_code, [page_problem(problem, {})])


async def _fault_answer(request: Request, error: Exception) -> Response:
    return _problem_response(500, [fault_problem(error)])
