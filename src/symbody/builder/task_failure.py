"""What a task of the builder is given to report its progress, and the exception by which it fails."""

from __future__ import annotations

from typing import Any, Protocol


class Report(Protocol):
    """Takes the stage of a task, and its percentage if there is one."""

    def __call__(self, stage: str, percent: int | None, /) -> None:
        """Hand on what is new."""


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
