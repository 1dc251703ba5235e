"""Refusals: what a request cannot have, as problems for the page."""

from __future__ import annotations

from types import MappingProxyType
from typing import Final

from symbody.errors import Problem, SymbodyError, UsageError

# Answers that are not 422: what the page reacts to by other means than a list of problems.
_STATUS: Final = MappingProxyType(
    {
        "builder.changed_outside": 409,
        "builder.superseded": 409,
        "builder.outside_roots": 403,
        "builder.unknown_document": 404,
        "builder.unknown_draft": 404,
        "builder.unknown_job": 404,
        "builder.unknown_example": 404,
        "builder.too_many_jobs": 429,
    }
)


def refusal(code: str, where: str, what: str, why: str = "", fix: str = "") -> UsageError:
    """Return the error of a request that cannot be granted."""
    return UsageError(Problem(code, where, what, why, fix))


def status_of(error: SymbodyError) -> int:
    """Return the status of the answer to a request that failed."""
    return _STATUS.get(error.problems[0].code, 422) if error.problems else 422
