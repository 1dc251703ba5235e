"""What the application works with: documents, workers, jobs."""

from __future__ import annotations

from typing import Any

from symbody.builder.documents import Documents
from symbody.builder.file_names import file_stem
from symbody.builder.jobs import Jobs
from symbody.builder.model_text import text_from_data
from symbody.builder.requests import (
    CheckRequest,
    DragRequest,
    EquationTabRequest,
    ExportRequest,
    JobRequest,
    OutputsRequest,
    PoseRequest,
)
from symbody.builder.settings import BuilderSettings
from symbody.builder.workers import NewestOnly, Reserve

Answer = dict[str, Any]


class Services:
    """Everything behind the requests of one run."""

    def __init__(self, settings: BuilderSettings) -> None:
        self.settings = settings
        self.documents = Documents(settings)
        self._reserve = Reserve()
        self.jobs = Jobs(self._reserve, settings.limits)
        self._interactive = NewestOnly(self._reserve)
        self._pictures = NewestOnly(self._reserve)  # which do not wait for a check that is under way

    def warm(self) -> None:
        """Begin to load what the first check needs."""
        self._reserve.warm()

    def check(self, request: CheckRequest) -> bytes:
        """Return what is wrong with a model, what it is, and its picture, as JSON."""
        payload = {"data": request.data, "folder": self.documents.folder_of(request.document)}
        answer: bytes = self._interactive.run(
            "check", payload, request.page, self.settings.limits.check, request.turn
        )
        return answer

    def redraw(self, request: CheckRequest) -> bytes:
        """Return the picture of a model whose parameters changed, sooner than its check has it, as JSON."""
        payload = {"data": request.data, "folder": self.documents.folder_of(request.document)}
        answer: bytes = self._pictures.run(
            "redraw", payload, request.page, self.settings.limits.check, request.turn
        )
        return answer

    def pose(self, request: PoseRequest) -> bytes:
        """Return the configuration in which some coordinates have the values given, as JSON."""
        payload = {
            "data": request.data,
            "folder": self.documents.folder_of(request.document),
            "fixed": request.fixed,
            "guess": request.guess,
        }
        answer: bytes = self._interactive.run("pose", payload, request.page, self.settings.limits.pose)
        return answer

    def drag(self, request: DragRequest) -> bytes:
        """Return the configuration in which a point of a body is nearest to a line of sight, as JSON."""
        payload = {
            "data": request.data,
            "folder": self.documents.folder_of(request.document),
            "body": request.body,
            "point": request.point,
            "origin": request.origin,
            "direction": request.direction,
            "guess": request.guess,
        }
        answer: bytes = self._interactive.run("drag", payload, request.page, self.settings.limits.pose)
        return answer

    def start_job(self, request: JobRequest) -> Answer:
        """Begin a job."""
        folder = self.documents.folder_of(request.document)
        payload = {"data": request.data, "folder": folder, "options": request.options}
        return {"job": self.jobs.start(request.kind, payload)}

    def outputs(self, request: OutputsRequest) -> Answer:
        """Return more curves of a finished run."""
        answer: Answer = self.jobs.ask(request.job, "outputs", {"names": request.names})
        return answer

    def equation_tab(self, request: EquationTabRequest) -> Answer:
        """Return a tab of equations that a finished job has derived."""
        answer: Answer = self.jobs.ask(request.job, "equation_tab", {"name": request.name})
        return answer

    def export(self, request: ExportRequest) -> Answer:
        """Return a model in another form."""
        if request.kind == "toml":
            name = str(request.data.get("name") or "model")
            return {"name": f"{file_stem(name)}.toml", "text": text_from_data(request.data)}
        payload = {
            "data": request.data,
            "folder": self.documents.folder_of(request.document),
            "kind": request.kind,
        }
        if request.job is not None:
            answer: Answer = self.jobs.ask(request.job, "export", payload)
            return answer
        worker = self._reserve.take()
        try:
            answer = worker.run("export", payload)
        finally:
            worker.kill()
        return answer

    def close(self) -> None:
        """End all processes."""
        self._reserve.close()
