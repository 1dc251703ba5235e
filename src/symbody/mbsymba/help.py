"""`Describe` and `show`."""

from __future__ import annotations

import inspect
from collections.abc import Callable


def Describe(command: Callable[..., object]) -> None:
    """Print what a command does and how it is called."""
    text = (inspect.getdoc(command) or "").partition("\n")[0]
    names = [_parameter(p) for p in inspect.signature(command).parameters.values()]
    print(f"# {text}\n{command.__name__}({', '.join(names)})")


def show(thing: object) -> None:
    """Print a frame, point, vector, body, force or constraint as a table, and anything else as it is."""
    print(thing)


def _parameter(parameter: inspect.Parameter) -> str:
    star = "*" if parameter.kind is inspect.Parameter.VAR_POSITIONAL else ""
    default = parameter.default
    return f"{star}{parameter.name}" + ("" if default is inspect.Parameter.empty else f"={default!r}")
