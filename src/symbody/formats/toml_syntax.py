"""TOML text to plain data; what is wrong with the text is told with line and column."""

from __future__ import annotations

import re
import tomllib
from decimal import Decimal
from typing import Any, Final

from symbody.errors import FormatError, Problem
from symbody.expr.language.caret import Source

_PLACE: Final = re.compile(r" \(at (?:line (\d+), column (\d+)|end of document)\)$")


def parse_toml(text: str, where: str) -> dict[str, Any]:
    """Return the content of a TOML text; decimals come as `Decimal`, exact as written.

    Raises
    ------
    FormatError
        If it is not TOML, with line and column; or if it is beyond what can be read.
    """
    try:
        return tomllib.loads(text, parse_float=Decimal)
    except tomllib.TOMLDecodeError as error:
        raise FormatError(_syntax_problem(text, where, str(error))) from None
    except RecursionError:
        what = "lists or tables are nested too deeply"
    except (ValueError, ArithmeticError):
        what = "a number has too many digits"
    raise FormatError(
        Problem(
            "file.too_complex",
            where,
            what,
            "it was made by a program, or is not a model",
            "write it more simply",
        )
    )


def _syntax_problem(text: str, where: str, message: str) -> Problem:
    """Return the problem of a text that is not TOML, with the line in question."""
    found = _PLACE.search(message)
    what = message[: found.start()] if found else message
    if found is None or found.group(1) is None:
        return Problem(
            "file.syntax",
            f"{where}:{text.count(chr(10)) + 1}",
            f"the file ends too early: {what}",
            "a bracket or quote is never closed, or the file was cut off",
            "close it, or restore the file",
        )
    number, column = int(found.group(1)), int(found.group(2))
    line = text.split("\n")[number - 1]
    source = Source(line[: column + 200]).problem("file.syntax", min(column, len(line) + 1), what)
    is_twice = any(word in what for word in ("overwrite", "twice", "already", "immutable"))
    return Problem(
        "file.duplicate_key" if is_twice else "file.syntax",
        f"{where}:{number}",
        source.what,
        "a key or table stands twice" if is_twice else "this line is not TOML; texts stand in quotes",
        "remove one of them" if is_twice else f"mend it at column {column}",
    )
