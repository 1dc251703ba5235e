"""The cases of a sweep: which names vary, and a row of their values for each case."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal
from numbers import Rational, Real
from typing import Final, Literal, TypeGuard

import numpy as np
from numpy.typing import NDArray

from symbody.arguments import checked_fields, is_sympy
from symbody.codegen.formation.names import Value
from symbody.errors import ExpressionError, Problem, UsageError
from symbody.expr.language.formula import Formula
from symbody.model.declarations.arguments import plain_value
from symbody.model.numbers import as_float, formula_value

Floats = NDArray[np.float64]
Law = Literal["uniform", "loguniform", "normal"]
Combine = Literal["product", "list"]

_LAWS: Final = ("uniform", "loguniform", "normal")
_KINDS: Final = ("parameters", "initial")


@checked_fields
@dataclass(frozen=True, slots=True)
class Samples:
    """Random values of a parameter or initial value, the same for the same seed.

    Attributes
    ----------
    law : "uniform", "loguniform" or "normal"
        How they are distributed.
    first, second : float
        Lower and upper bound, or mean and standard deviation.

    Raises
    ------
    UsageError
        If the law is unknown, or its numbers make no sense.

    Examples
    --------
    >>> import symbody as sb
    >>> rail = sb.Prismatic("rail", "ground", sb.Body("Cart", mass="m"), axis="x", coordinate="x")
    >>> eqs = sb.form_equations(sb.Model("cart", [rail], parameters={"m": 2}))
    >>> result = sb.sweep(eqs, 1.0, {"m": sb.Samples("normal", 2.0, 0.1)}, samples=100, times=[0, 1])
    >>> result["x"].shape, result.cases["m"].shape
    ((100, 2), (100,))
    """

    law: Law
    first: float
    second: float

    def __post_init__(self) -> None:
        finite = bool(np.isfinite(self.first) and np.isfinite(self.second))
        legal = finite and (self.second >= 0.0 if self.law == "normal" else self.second >= self.first)
        if self.law == "loguniform":
            legal = legal and self.first > 0.0
        if self.law not in _LAWS or not legal:
            raise UsageError(
                Problem("sweep.samples", repr(self), "this is not a known distribution", "",
                        "give sb.Samples('uniform', low, high), ('loguniform', low, high) with low above 0, "
                        "or ('normal', mean, deviation)")
            )  # fmt: skip

    def draw(self, name: str, count: int, seed: int) -> Floats:
        """Return `count` values; more of them begin with the same ones, regardless of what else is drawn."""
        generator = np.random.default_rng([seed, *name.encode()])
        if self.law == "normal":
            return generator.normal(self.first, self.second, count)
        if self.law == "uniform":
            return generator.uniform(self.first, self.second, count)
        return np.exp(generator.uniform(np.log(self.first), np.log(self.second), count))


Varied = Value | Samples | Sequence[float] | Floats


@dataclass(frozen=True, slots=True, eq=False)
class CaseTable:
    """All cases of a sweep.

    Attributes
    ----------
    parameter_names, initial_names : tuple of str
        What varies.
    parameters, initial : (cases, names) arrays
        Its values.
    fixed_parameters, fixed_initial : mapping of name to number or formula
        What is the same in all cases.
    """

    parameter_names: tuple[str, ...]
    initial_names: tuple[str, ...]
    parameters: Floats
    initial: Floats
    fixed_parameters: Mapping[str, Value]
    fixed_initial: Mapping[str, Value]

    @property
    def count(self) -> int:
        """How many cases there are."""
        return len(self.parameters)

    def values(self, k: int) -> tuple[dict[str, Value], dict[str, Value]]:
        """Return all parameters and initial values of case k, by name."""
        parameters = dict(zip(self.parameter_names, self.parameters[k].tolist(), strict=True))
        initial = dict(zip(self.initial_names, self.initial[k].tolist(), strict=True))
        return {**self.fixed_parameters, **parameters}, {**self.fixed_initial, **initial}

    def columns(self) -> dict[str, Floats]:
        """Return what varies as columns by name; a parameter and a state of one name cannot be."""
        names = (*self.parameter_names, *self.initial_names)
        rows = np.concatenate([self.parameters, self.initial], axis=1)
        return {name: rows[:, k].copy() for k, name in enumerate(names)}


def case_table(
    parameters: Mapping[str, Varied],
    initial: Mapping[str, Varied],
    combine: Combine = "product",
    samples: int | None = None,
    seed: int = 0,
    check: Callable[[int, int], None] | None = None,
) -> CaseTable:
    """Return the cases that mappings of names to values, sequences of values, or `Samples` stand for.

    Raises UsageError listing every sequence that is empty, not finite, or of another length than the others
    in a list.

    Parameters
    ----------
    check : callable, optional
        Called with the numbers of cases and of names that vary, before any memory is taken for them.
    """
    if isinstance(seed, bool) or not isinstance(seed, int | np.integer) or seed < 0:
        raise UsageError(
            Problem("sweep.seed", "seed", f"seed = {seed!r} is not a whole number, 0 or greater",
                    "the seed determines the random numbers", "give such a number, or leave it out")
        )  # fmt: skip
    entries = {("parameters", name): value for name, value in parameters.items()}
    entries |= {("initial", name): value for name, value in initial.items()}
    lists = {
        key: value
        for key, value in entries.items()
        if not (isinstance(value, Samples) or _is_constant(value))
    }
    drawn = {key: value for key, value in entries.items() if isinstance(value, Samples)}
    columns = _check_columns(lists, combine, bool(drawn), samples)
    sizes = [column.size for column in columns.values()]
    count = math.prod(sizes) if combine == "product" else max(sizes, default=1)
    each = samples if drawn and samples is not None else 1
    if check is not None:
        check(count * each, len(columns) + len(drawn))
    rows: dict[tuple[str, str], Floats] = {}
    for key, column in zip(columns, _combine(columns, combine, count), strict=True):
        rows[key] = np.repeat(column, each)
    for key, value in drawn.items():
        rows[key] = np.tile(value.draw(key[1], each, seed), count)
    # In the order of the mappings, so that the same cases have the same names in the same places.
    names = {kind: tuple(key[1] for key in entries if key in rows and key[0] == kind) for kind in _KINDS}
    nothing = np.empty((count * each, 0))
    first, second = (
        np.column_stack([nothing, *(rows[kind, name] for name in names[kind])]) for kind in _KINDS
    )
    constants = _constants(parameters), _constants(initial)
    return CaseTable(names["parameters"], names["initial"], first, second, *constants)


def _is_constant(value: Varied) -> TypeGuard[Value]:
    return isinstance(value, Real | str | Formula | Decimal) or is_sympy(value)


def _constants(values: Mapping[str, Varied]) -> dict[str, Value]:
    return {name: value for name, value in values.items() if _is_constant(value)}


def _check_columns(
    lists: Mapping[tuple[str, str], Varied], combine: str, has_samples: bool, samples: int | None
) -> dict[tuple[str, str], Floats]:
    problems = []
    if combine not in ("product", "list"):
        problems.append(
            Problem("sweep.combine", "combine", f"combine = {combine!r} is not a valid choice", "",
                    "give 'product' for every combination, or 'list' to combine the first values, the "
                    "second values, ...")
        )  # fmt: skip
    if has_samples != (samples is not None) or (samples is not None and samples < 1):
        problems.append(
            Problem("sweep.sample_count", "samples", f"samples = {samples!r} is not consistent with the "
                f"values",
                    "it is the number of values drawn for each sb.Samples",
                    "give samples=1000 if any value is "
                    "sb.Samples(...), and leave it out otherwise")
        )  # fmt: skip
    columns: dict[tuple[str, str], Floats] = {}
    for (kind, name), value in lists.items():
        column = _column(value)
        if column is None:
            problems.append(
                Problem("sweep.values", f"{kind}, {name}", f"{value!r} is not a list of numbers",
                        "each case takes one finite number",
                        "give numbers such as np.linspace(1, 2, 11), or angles such as '30 deg'")
            )  # fmt: skip
        else:
            columns[kind, name] = column
    sizes = {f"{name} {column.size}" for (_, name), column in columns.items()}
    if combine == "list" and len({column.size for column in columns.values()}) > 1:
        problems.append(
            Problem("sweep.lengths", "combine", f"lists differ in length: {', '.join(sorted(sizes))}",
                    "combine='list' combines the first values, then the second values",
                    "give lists of equal length, or combine='product'")
        )  # fmt: skip
    if problems:
        raise UsageError(*problems)
    return columns


def _column(value: Varied) -> Floats | None:
    try:
        entries = [_number(entry) for entry in value] if isinstance(value, list | tuple) else value
        column = np.array(entries, dtype=np.float64)
    except (TypeError, ValueError, ExpressionError):
        return None
    return column if column.ndim == 1 and column.size and np.isfinite(column).all() else None


def _number(entry: object) -> object:
    """Return the number that a text, a fraction or an expression of SymPy stands for, ``"30 deg"`` too."""
    if isinstance(entry, str | Rational) or is_sympy(entry):
        number = formula_value(Formula.from_value(plain_value(entry)))
        return math.nan if number is None else as_float(number)
    return entry


def _combine(columns: Mapping[tuple[str, str], Floats], combine: str, count: int) -> Iterator[Floats]:
    """Yield the values of each name in all combinations, the last name varying fastest."""
    within = count
    for column in columns.values():
        if combine == "list":
            yield column
            continue
        within //= column.size
        yield np.tile(np.repeat(column, within), count // (within * column.size))
