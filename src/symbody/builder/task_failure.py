"""What a task of the builder is given to report its progress, and the exception by which it fails."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

Report = Callable[[str, int | None], None]  # a stage and how much of it is done [percent]


class TaskFailure(Exception):
    """What a task could not do, as problems of the page.

    Attributes
    ----------
    problems : list of dict
        For the page.
    """

    def __init__(self, problems: list[dict[str, Any]]) -> None:
        Exception.__init__(self, problems)
        self.problems = problems
