"""Where the command line begins: it runs the commands and turns faults into messages and exit codes."""

from __future__ import annotations

import io
import sys
from collections.abc import Sequence

from rich.console import Console

from symbody import cli
from symbody.cli.doctor import run_doctor
from symbody.errors import SymbodyError


def main() -> None:
    """Run the command line; faults of the user end in a message and an exit code, never in a traceback."""
    sys.exit(run(sys.argv[1:]))


def run(arguments: Sequence[str]) -> int:
    """Run the command line and return its exit code."""
    _print_any_letter()
    try:
        if list(arguments) == ["doctor"]:  # it runs where the other commands cannot be loaded
            return run_doctor()
        cli.app(list(arguments))  # loads compilers, which may be broken: a fault like any other
        return 0
    except SystemExit as done:  # typer ends this way, after telling faults of usage
        return done.code if isinstance(done.code, int) else 0
    except SymbodyError as error:
        return _print_message(str(error), error.exit_code)
    except KeyboardInterrupt:
        return _print_message("interrupted", 130)
    except OSError as error:
        fix = "\n  fix: give a path in an existing folder with write permission" if error.filename else ""
        return _print_message(f"[cli.file] {error.filename or ''}: {error.strerror or error}{fix}", 5)


def _print_any_letter() -> None:
    """Let output that goes into a file or a pipe keep letters that the system's encoding lacks, as escapes.

    Windows writes such output in a code page of 256 letters, in which Greek names cannot be printed.
    """
    if isinstance(sys.stdout, io.TextIOWrapper) and sys.stdout.errors == "strict":
        sys.stdout.reconfigure(errors="backslashreplace")


def _print_message(message: str, code: int) -> int:
    Console(stderr=True, highlight=False).print(message, markup=False, soft_wrap=True)
    return code
