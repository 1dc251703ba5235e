"""What a builder is started with."""

from __future__ import annotations

import hmac
import os
import secrets
import sys
from dataclasses import dataclass, field
from pathlib import Path
from urllib.parse import quote

from symbody.errors import EnvironmentFault, Problem
from symbody.formats.model_files import examples_folder
from symbody.visual.viewer.built_files import why_no_pages


@dataclass(frozen=True, slots=True)
class ServerLimits:
    """How much one page may ask for.

    Attributes
    ----------
    body : int
        Bytes of a request.
    receive : float
        Seconds in which a request has to arrive.
    check, pose, job : float
        Seconds of computing.
    jobs : int
        Jobs at once.
    """

    body: int = 20_000_000
    receive: float = 30.0
    check: float = 20.0
    pose: float = 5.0
    job: float = 3600.0
    jobs: int = 2


@dataclass(frozen=True, slots=True)
class BuilderSettings:
    """What a builder is started with.

    Attributes
    ----------
    port : int
        The port of 127.0.0.1 it listens on.
    pages : Path
        Folder of the built page.
    examples : Path
        Folder of the examples.
    roots : tuple of Path
        Folders whose files may be opened and saved, links resolved.
    state : Path
        Folder of drafts and of the list of recent files.
    token : str
        Secret of this run that every request of the page carries.
    key : str
        Secret in the address that is opened; the page is shown to nobody without it.
    """

    port: int
    pages: Path
    examples: Path
    roots: tuple[Path, ...]
    state: Path
    limits: ServerLimits = ServerLimits()
    token: str = field(default_factory=lambda: secrets.token_urlsafe(32), repr=False)
    key: str = field(default_factory=lambda: secrets.token_urlsafe(32), repr=False)

    @property
    def hosts(self) -> frozenset[str]:
        """The names under which the server may be addressed."""
        return frozenset({f"127.0.0.1:{self.port}", f"localhost:{self.port}"})

    def is_key(self, text: str) -> bool:
        """Return whether a text is the key, in a time that does not depend on it."""
        return hmac.compare_digest(text.encode(), self.key.encode())

    def address(self, path: str = "") -> str:
        """Return what is opened in the browser; `path` is that of a model to begin with."""
        fragment = f"#open={quote(path)}" if path else ""
        return f"http://127.0.0.1:{self.port}/?key={self.key}{fragment}"


def make_settings(
    port: int,
    roots: tuple[Path, ...] | None = None,
    state: Path | None = None,
    pages: Path | None = None,
    limits: ServerLimits | None = None,
) -> BuilderSettings:
    """Return the settings of a builder.

    Parameters
    ----------
    roots : tuple of Path, optional
        Folders whose files may be opened and saved; by default the home and the current folder.
    state : Path, optional
        Folder of drafts; by default one of the user's, see `state_folder`.
    pages : Path, optional
        Folder of the built page; by default that of the package.

    Raises
    ------
    EnvironmentFault
        If the page was not built, or there are no examples.
    """
    return BuilderSettings(
        port=port,
        pages=pages_folder() if pages is None else pages,
        examples=examples_folder().resolve(),
        roots=tuple(root.resolve() for root in (roots or _usual_roots())),
        state=state_folder() if state is None else state,
        limits=limits or ServerLimits(),
    )


def pages_folder() -> Path:
    """Return the folder of the built page.

    Raises
    ------
    EnvironmentFault
        If it is not there.
    """
    folder = Path(__file__).parent / "pages"
    if not (folder / "index.html").is_file():
        raise EnvironmentFault(
            Problem(
                "builder.no_page",
                str(folder),
                "the page of the builder has not been built",
                why_no_pages(),
                "npm ci && npm run build in the folder frontend, or install a released package",
            )
        )
    return folder


def state_folder() -> Path:
    """Return where drafts are kept: ``SYMBODY_STATE``, or a folder of the user's by the system's rules."""
    chosen = os.environ.get("SYMBODY_STATE", "")
    if chosen:
        return Path(chosen)
    home = Path.home()
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA", home / "AppData" / "Local"), "symbody", "builder")
    if sys.platform == "darwin":
        return home / "Library" / "Application Support" / "symbody" / "builder"
    return Path(os.environ.get("XDG_STATE_HOME", "") or home / ".local" / "state", "symbody", "builder")


def _usual_roots() -> tuple[Path, ...]:
    return (Path.home(), Path.cwd())
