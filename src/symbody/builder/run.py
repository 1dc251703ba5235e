"""Runs the server until it is interrupted."""

from __future__ import annotations

import os
import socket
import threading
import webbrowser
from pathlib import Path
from typing import Final

import uvicorn

from symbody.arguments import checked_arguments
from symbody.builder.app import make_app
from symbody.builder.settings import BuilderSettings, make_settings
from symbody.errors import EnvironmentFault, Problem

_TRIES: Final = 20  # ports after a usual one that is taken
USUAL_PORT: Final = 8137


@checked_arguments
def run_builder(path: str | os.PathLike[str] = "", port: int | None = None, browser: bool = True) -> None:
    """Serve the builder on this computer until Ctrl-C, and open it in the browser.

    Parameters
    ----------
    path : str
        Model file to begin with; its folder is one that the page may read.
    port : int, optional
        By default 8137, or the next one that is free.
    browser : bool
        Whether the browser is opened; the address is printed in any case.

    Raises
    ------
    EnvironmentFault
        If the page was not built, or the port is taken.
    """
    given = Path(os.fsdecode(path)).resolve() if os.fsdecode(path) else None
    roots = [Path.home(), Path.cwd()]
    if given is not None and not any(given.is_relative_to(root.resolve()) for root in roots):
        roots.insert(0, given.parent)
    listener = listening_socket(port)
    settings = make_settings(listener.getsockname()[1], tuple(roots))
    address = settings.address("" if given is None else str(given))
    print(f"symbody builder: {address}\nPress Ctrl-C to stop it.", flush=True)
    if browser:
        # The socket listens already: the browser waits until the server answers.
        threading.Thread(target=webbrowser.open, args=(address,), daemon=True).start()
    serve(settings, listener)


def serve(settings: BuilderSettings, listener: socket.socket) -> None:
    """Answer requests on a socket until the process is interrupted."""
    config = uvicorn.Config(
        make_app(settings),
        log_level="warning",
        access_log=False,
        server_header=False,
        ws="none",
        timeout_keep_alive=30,
        timeout_graceful_shutdown=1,
        limit_concurrency=64,
        h11_max_incomplete_event_size=64 * 1024,
    )
    uvicorn.Server(config).run(sockets=[listener])


def listening_socket(port: int | None) -> socket.socket:
    """Return a socket on a port of 127.0.0.1.

    Raises
    ------
    EnvironmentFault
        If the port is taken.
    """
    candidates = range(USUAL_PORT, USUAL_PORT + _TRIES) if port is None else (port,)
    for candidate in candidates:
        listener = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
        if os.name == "posix":
            listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            listener.bind(("127.0.0.1", candidate))
            listener.listen(128)  # from now on the port is taken, and whoever connects waits
            return listener
        except (OSError, OverflowError):
            listener.close()
    raise EnvironmentFault(
        Problem(
            "builder.port",
            f"port {candidates[0]}",
            "the port cannot be used",
            "another program listens on it, or it is not a port",
            "symbody builder --port 0 uses any free port",
        )
    )
