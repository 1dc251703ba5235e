"""Options of jobs, a class a kind."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal, TypeVar

from pydantic import BaseModel, ConfigDict, Field, ValidationError, field_validator

from symbody.builder.page_problems import page_problem
from symbody.builder.task_failure import TaskFailure
from symbody.equations.formulations.registry import formulation_types
from symbody.errors import Problem

Options = TypeVar("Options", bound="JobOptions")
Values = dict[str, str | float]


class JobOptions(BaseModel):
    """Options of a job."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class EquationOptions(JobOptions):
    """How equations are formed."""

    formulation: str = ""

    @field_validator("formulation")
    @classmethod
    def check_formulation(cls, word: str) -> str:
        """Refuse a formulation that does not exist."""
        if word and word not in formulation_types():
            raise ValueError(f"there is no formulation {word!r}; there are {', '.join(formulation_types())}")
        return word


class SimulateOptions(JobOptions):
    """A motion: `inputs` are formulas in t, states and parameters; `samples` are evenly spaced."""

    t_end: float = Field(default=10.0, gt=0.0, le=1e6, allow_inf_nan=False)
    samples: int | None = Field(default=None, ge=2, le=200_000)
    times: list[float] | None = Field(default=None, max_length=200_000)
    inputs: dict[str, str] = {}
    rtol: float = Field(default=1e-8, gt=0.0, lt=1.0)
    solver: Literal["", "explicit", "stiff"] = ""
    vectors: Literal["all", "applied", "none", ""] = ""


class EquilibriumOptions(JobOptions):
    """A rest: near the guess, with constant inputs, some of which may be unknown."""

    guess: Values = {}
    inputs: Values = {}
    unknowns: list[str] = []
    fixed: Values = {}


class ModesOptions(JobOptions):
    """Small motions about a rest, or about the start."""

    at: Literal["equilibrium", "start"] = "equilibrium"
    inputs: Values = {}


class SingularOptions(JobOptions):
    """Where independent coordinates do not determine the others; by default the first, over a turn."""

    independent: list[str] = []
    over: dict[str, float | tuple[float, float]] = {}


class RatioOptions(JobOptions):
    """Velocity ratios: the independent speeds; by default those that determine the others best."""

    independent: list[str] = []


class TorqueOptions(JobOptions):
    """What drives a coordinate at a constant rate, over one turn or a time."""

    coordinate: str
    rate: float = Field(allow_inf_nan=False)
    t_end: float | None = Field(default=None, gt=0.0, le=1e6, allow_inf_nan=False)
    samples: int = Field(default=361, ge=2, le=20_000)

    @field_validator("rate")
    @classmethod
    def check_rate(cls, rate: float) -> float:
        """Refuse a drive that stands still."""
        if rate == 0.0:
            raise ValueError("a nonzero rate is needed")
        return rate


class InverseOptions(JobOptions):
    """The inputs that make coordinates follow formulas in t."""

    motion: dict[str, str]
    unknowns: list[str]
    t_end: float = Field(default=1.0, gt=0.0, le=1e6, allow_inf_nan=False)
    samples: int = Field(default=201, ge=2, le=20_000)


class SweepOptions(JobOptions):
    """Motions for several values of a parameter."""

    parameter: str
    values: list[float] = Field(min_length=1, max_length=500)
    outputs: list[str] = Field(default=[], max_length=20)
    inputs: dict[str, str] = {}
    t_end: float = Field(default=10.0, gt=0.0, le=1e6, allow_inf_nan=False)
    samples: int = Field(default=301, ge=2, le=5000)


def read_options(kind: type[Options], given: Mapping[str, Any]) -> Options:
    """Return options that were checked.

    Raises
    ------
    TaskFailure
        With each that is unknown or does not fit.
    """
    try:
        return kind.model_validate(given)
    except ValidationError as error:
        faults = [(".".join(map(str, each["loc"])), str(each["msg"])) for each in error.errors()[:20]]
        known = f"the options are {', '.join(kind.model_fields)}"
        problems = [Problem("builder.option", where, what, "", known) for where, what in faults]
        raise TaskFailure([page_problem(problem, {}) for problem in problems]) from None
