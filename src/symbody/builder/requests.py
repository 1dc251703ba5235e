"""What the page sends, a class a request; keys that are not listed are refused."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field

Data = dict[str, Any]
Components = Annotated[list[float], Field(min_length=3, max_length=3)]
JobKind = Literal[
    "equations", "simulate", "equilibrium", "modes", "singular", "ratios", "torque", "inverse", "sweep"
]
ExportKind = Literal["python", "c", "latex", "html", "fmu", "toml"]


class PageRequest(BaseModel):
    """A request of the page."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


class NothingRequest(PageRequest):
    """A request without content."""


class OpenRequest(PageRequest):
    """What to open: exactly one of these; `name` beside `text`."""

    path: str | None = None
    example: str | None = None
    text: str | None = None
    name: str = ""
    draft: str | None = None
    urdf: str | None = None


class FolderRequest(PageRequest):
    """A folder to list; empty: the current one."""

    path: str = ""


class SaveRequest(PageRequest):
    """A document to be written to a file."""

    document: str = Field(max_length=64)
    path: str
    data: Data
    fingerprint: str | None = None
    overwrite: bool = False


class DraftRequest(PageRequest):
    """The state of a document, to be recovered after a crash."""

    document: str = Field(max_length=64)
    data: Data


class AdoptRequest(PageRequest):
    """A document of a page that an earlier run of the server opened."""

    document: str = Field(max_length=64)
    path: str | None = None
    name: str = Field(default="untitled", max_length=1000)
    fingerprint: str | None = Field(default=None, max_length=64)


class ChangedRequest(PageRequest):
    """Whether the file of a document still has a fingerprint."""

    document: str = Field(max_length=64)
    fingerprint: str | None = None


class CheckRequest(PageRequest):
    """A model to be checked; of the requests of a page only the newest is answered.

    `turn` counts the requests of a page, which may arrive in another order; 0: as they arrive.
    """

    data: Data
    turn: int = 0
    page: str = Field(default="", max_length=64)
    document: str = Field(default="", max_length=64)


class PoseRequest(PageRequest):
    """Coordinates that are dragged, and where to look for the others."""

    data: Data
    fixed: dict[str, float]
    guess: dict[str, float] = {}
    page: str = Field(default="", max_length=64)
    document: str = Field(default="", max_length=64)


class DragRequest(PageRequest):
    """A body that is dragged by a `point`, in its axes, to a line of sight, in ground's axes [m]."""

    data: Data
    body: str = Field(max_length=1000)
    point: Components
    origin: Components
    direction: Components
    guess: dict[str, float] = {}
    page: str = Field(default="", max_length=64)
    document: str = Field(default="", max_length=64)


class FormulaRequest(PageRequest):
    """A formula to be shown."""

    text: str = Field(max_length=10_000)
    pointer: str = Field(default="", max_length=1000)


class JobRequest(PageRequest):
    """Work that takes long."""

    kind: JobKind
    data: Data
    options: Data = {}
    document: str = Field(default="", max_length=64)


class JobStateRequest(PageRequest):
    """What has become of a job since the page saw state `seen`."""

    job: str = Field(max_length=64)
    seen: int = -1


class CancelRequest(PageRequest):
    """A job to be ended."""

    job: str = Field(max_length=64)


class OutputsRequest(PageRequest):
    """More curves of a finished run."""

    job: str = Field(max_length=64)
    names: list[str] = Field(max_length=200)


class EquationTabRequest(PageRequest):
    """A tab of derived equations."""

    job: str = Field(max_length=64)
    name: str = Field(max_length=64)


class ExportRequest(PageRequest):
    """A model in another form; `job` is a finished run, for what shows a motion."""

    data: Data
    kind: ExportKind
    document: str = Field(default="", max_length=64)
    job: str | None = Field(default=None, max_length=64)
