"""Templates of reports: a file of one's own, with names in double braces where parts of a report go."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Final

from symbody.errors import Problem, UsageError, nearest

_PLACE: Final = re.compile(r"\{\{ *(\w+) *\}\}")


def fill_template(template: str, pieces: Mapping[str, str], where: str) -> str:
    """Return a template with ``{{ name }}`` replaced by the piece of that name.

    Parameters
    ----------
    template : str
        Its text. All else in it stays as it is.
    pieces : mapping of name to str
        What there is to put in.
    where : str
        The path of the template, for messages.

    Raises
    ------
    UsageError
        If a name is no piece, or there is none.
    """
    names = _PLACE.findall(template)
    choices = f"there are {', '.join(pieces)}"
    problems = [
        Problem(
            "report.template_name",
            where,
            f"{name!r} is not a part of a report",
            choices,
            nearest(name, pieces),
        )
        for name in dict.fromkeys(names)
        if name not in pieces
    ]
    if not names:
        what = "the template does not contain the report"
        problems.append(
            Problem(
                "report.template_empty",
                where,
                what,
                choices,
                "write {{ body }} where the report should appear",
            )
        )
    if problems:
        raise UsageError(*problems)
    return _PLACE.sub(lambda place: pieces[place[1]], template)
