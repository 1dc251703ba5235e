"""`Describe` and `show`."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Final

# Names of annotations in the words of scripts.
_KINDS: Final[Mapping[str, str]] = MappingProxyType(
    {
        "AnyVector": "VECTOR | FORCE | TORQUE",
        "AnyFrame": "FRAME | Matrix",
        "Objects": "BODY | FORCE | TORQUE | CONSTRAINT | Iterable",
        "Scalar": "Expr | float",
        "Equation": "Expr | Equality",
        "SympyExpr": "Expr",
        "SympyEquation": "Equality",
        "SympyMatrix": "Matrix",
    }
)


def Describe(command: Callable[..., object]) -> None:
    """Print what a command does, as a comment, and below it how it is called, with the kinds of arguments.

    As in ``Describe(cross_prod)``.
    """
    text = inspect.getdoc(command) or ""
    signature = inspect.signature(command)
    parts: list[str] = []
    for parameter in signature.parameters.values():
        if parameter.kind is inspect.Parameter.KEYWORD_ONLY and "*" not in parts:
            parts.append("*")
        parts.append(_parameter(parameter))
    result = signature.return_annotation
    returned = "" if result in ("None", None, inspect.Signature.empty) else f" -> {_kind(result)}"
    print("\n".join(f"# {line}".rstrip() for line in text.splitlines()))
    print(f"{command.__name__}({', '.join(parts)}){returned}")


def show(thing: object) -> None:
    """Print a frame, point, vector, body, force or constraint as a table, and anything else as it is."""
    print(thing)


def _parameter(parameter: inspect.Parameter) -> str:
    star = "*" if parameter.kind is inspect.Parameter.VAR_POSITIONAL else ""
    unsaid = parameter.annotation in ("object", inspect.Parameter.empty)
    kind = "" if unsaid else f": {_kind(parameter.annotation)}"
    default = parameter.default
    return f"{star}{parameter.name}{kind}" + ("" if default is inspect.Parameter.empty else f" = {default!r}")


def _kind(annotation: object) -> str:
    """Return an annotation in the words of scripts."""
    text = annotation if isinstance(annotation, str) else inspect.formatannotation(annotation)
    return re.sub(r"\w+", lambda word: _KINDS.get(word[0], word[0]), text)
