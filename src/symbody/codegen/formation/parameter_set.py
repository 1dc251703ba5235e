"""`ParameterSet`: the values of parameters in one call, and what they decide about equations and code.

Numbers are arguments of the code. In it stand only those that are exactly 0, for what they multiply is not
computed, and formulas, which keep what is exact about them: the cosine of pi/2 is 0.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable, Mapping, Set
from collections.abc import Sequence as Items
from dataclasses import dataclass, field
from functools import partial
from typing import Any, Final, NamedTuple

from symbody.codegen.formation.names import Value, check_names, missing_value
from symbody.codegen.formation.quantities import Quantities, quantity_plan
from symbody.codegen.formation.rounding_rows import RoundingRows
from symbody.codegen.formation.sequences import parameter_nodes
from symbody.codegen.function import CompiledFunction
from symbody.equations.equation_set import EquationSet
from symbody.equations.solving.parameter_constraints import check_parameter_constraints
from symbody.errors import CompileError, ExpressionError, Problem
from symbody.expr.graph import Constant
from symbody.expr.language.formula import Formula
from symbody.expr.language.literals import read_number
from symbody.model.declarations.arguments import plain_value
from symbody.model.model import Model, value_problems
from symbody.model.numbers import as_float, formula_value
from symbody.single_flight import SingleFlight

_MOST_SETS: Final = 16
_MOST_FUNCTIONS: Final = 64
_MOST_NOTES: Final = 64
# Cosines and sines of so many parts of half a turn are roots of whole numbers, which formulas keep exact.
_EXACT_PARTS: Final = 12
_ROUNDING: Final = 1e-14
Entry = Constant | Formula | None


@dataclass(frozen=True, slots=True, eq=False)
class ParameterSet:
    """Values of the parameters of some equations.

    Attributes
    ----------
    original : EquationSet
        The equations, for any values.
    given : mapping of name to number or formula
        What differs from the model.
    free : tuple of str
        Parameters that have no value yet.
    values : mapping of name to number
        Exact where it is known so; parameters that follow from free ones are missing.
    numbers : tuple of str
        Parameters that are arguments of the code behind the free ones.
    written : mapping of name to 0 or formula
        What stands in the code, where it differs from the model.
    functions : SingleFlight
        Compiled functions with these values.
    """

    original: EquationSet
    given: Mapping[str, Value]
    free: tuple[str, ...]
    values: Mapping[str, Constant]
    numbers: tuple[str, ...]
    written: Mapping[str, Value]
    functions: SingleFlight[Hashable, CompiledFunction] = field(
        default_factory=lambda: SingleFlight(_MOST_FUNCTIONS), repr=False
    )
    _notes: SingleFlight[Hashable, Any] = field(default_factory=lambda: SingleFlight(_MOST_NOTES), repr=False)

    @property
    def floats(self) -> Mapping[str, float]:
        """The values as floats."""
        floats: Mapping[str, float] = self.note("floats", self._find_floats)
        return floats

    def _find_floats(self) -> dict[str, float]:
        declared = _entries_of(self.original)  # most values are those of the model
        return {
            name: declared.floats[name] if value is declared.values.get(name) else as_float(value)
            for name, value in self.values.items()
        }

    @property
    def quantities(self) -> Quantities:
        """Lengths, gravity, masses and moments of inertia of the model; no parameter is free."""
        numbers: Quantities = self.note(
            "quantities", lambda: quantity_plan(self.original).quantities(self.floats)
        )
        return numbers

    def require_possible(self) -> None:
        """Refuse values that no body or joint has.

        Raises
        ------
        CompileError
            If there are any, as a negative mass.
        """
        problems: list[Problem] = self.note("problems", partial(_problems, self))
        if problems:
            raise CompileError(*problems)

    def note(self, key: Hashable, make: Callable[[], Any]) -> Any:
        """Return what `make` derives from these values, made once."""
        return self._notes.get(key, make)

    @property
    def eqs(self) -> EquationSet:
        """The equations with the constraints that these values fulfil set to 0 = 0.

        Raises
        ------
        FormulationError
            If a constraint on parameters alone excludes these values.
        """
        return self._for_values[1]

    @property
    def pattern(self) -> Hashable:
        """What the code depends on: sets with the same pattern share it."""
        return self._for_values[0]

    def replacements(self) -> dict[int, int]:
        """Return the nodes that take the place of parameters that are no arguments."""
        return parameter_nodes(self.original, self.written, (*self.free, *self.numbers))

    @property
    def _for_values(self) -> tuple[Hashable, EquationSet]:
        """The pattern and the equations."""
        made: tuple[Hashable, EquationSet] = self.note("equations", self._find_equations)
        return made

    def _find_equations(self) -> tuple[Hashable, EquationSet]:
        eqs, silent = self.original, self._silent_rows()
        pattern = self.free, self.numbers, tuple(self.written.items()), silent
        return pattern, eqs.without_rows(silent)

    def _silent_rows(self) -> tuple[bool, ...]:
        """Return which constraints are 0 = 0 with these values; empty without constraints."""
        eqs = self.original
        if not (eqs.multiplier_names or eqs.formed.coupled.rows):
            return ()
        if eqs.formed.topology.model.constraints:
            check_parameter_constraints(eqs.formed, self.floats)
        if not eqs.multiplier_names:
            return ()
        rows: RoundingRows = eqs.plans.get("rounding rows", lambda: RoundingRows(eqs))
        return rows(self.floats)


def parameter_set(
    eqs: EquationSet, given: Mapping[str, Value] | None = None, free: Items[str] = ()
) -> ParameterSet:
    """Return values of parameters; equal ones are kept with the equations.

    Raises
    ------
    CompileError
        If a parameter has no value, or a name is unknown.
    """
    named, kept = given or {}, tuple(free)
    sets: SingleFlight[Hashable, ParameterSet] = eqs.plans.get("sets", lambda: SingleFlight(_MOST_SETS))
    key = kept, tuple([(name, type(value), str(value)) for name, value in named.items()])
    return sets.get(key, partial(_resolve_set, eqs, named, kept))


class _ModelEntries(NamedTuple):
    """What the model says of its parameters, in the order of their dependence.

    Attributes
    ----------
    entries : mapping of name to number, formula or None
    values : mapping of name to number
    floats : mapping of name to float
        The same values.
    sources : mapping of name to set of str
        All parameters that a formula reads, through others too.
    """

    entries: Mapping[str, Entry]
    values: Mapping[str, Constant]
    floats: Mapping[str, float]
    sources: Mapping[str, frozenset[str]]


def _entries_of(eqs: EquationSet) -> _ModelEntries:
    entries: _ModelEntries = eqs.plans.get("parameters of the model", partial(_model_entries, eqs))
    return entries


def _model_entries(eqs: EquationSet) -> _ModelEntries:
    entries: dict[str, Entry] = {}
    values: dict[str, Constant] = {}
    sources: dict[str, frozenset[str]] = {}
    for name in eqs.model.parameter_order():
        formula = eqs.model.parameters[name]
        plain = None if formula is None else formula.constant()
        entries[name] = formula if plain is None else plain
        if formula is None:
            continue
        read = frozenset(formula.names)
        sources[name] = read.union(*(sources.get(other, frozenset()) for other in read))
        try:
            value = formula_value(formula, values) if plain is None else plain
        except ExpressionError:  # it may be given another value
            continue
        if value is not None:
            values[name] = value
    floats = {name: as_float(value) for name, value in values.items()}
    return _ModelEntries(entries, values, floats, sources)


def _resolve_set(eqs: EquationSet, given: Mapping[str, Value], free: tuple[str, ...]) -> ParameterSet:
    model, declared = eqs.model, _entries_of(eqs)
    if not all(name in model.parameters for name in (*given, *free)):
        check_names(eqs, given, free)
    replaced = {name: _entry(name, value) for name, value in given.items() if name in model.parameters}
    formulas = {name: entry for name, entry in replaced.items() if isinstance(entry, Formula)}
    entries = {**declared.entries, **replaced}
    if formulas or free:
        order = model.parameter_order(formulas) if formulas else entries
        entries = {name: entries[name] for name in order if name not in free}
    missing = [name for name, entry in entries.items() if entry is None]
    if missing:
        raise CompileError(missing_value(missing))
    try:
        values = _values(entries, declared, {*given, *free})
    except ExpressionError:
        parameter_nodes(eqs, given, free)  # says whose formula it is
        raise
    zeros = dict.fromkeys((name for name, value in values.items() if value == 0), 0)
    numbers = tuple(
        name for name, entry in entries.items() if not isinstance(entry, Formula) and name not in zeros
    )
    return ParameterSet(eqs, dict(given), free, values, numbers, {**formulas, **zeros})


def _problems(chosen: ParameterSet) -> list[Problem]:
    """Return what is impossible about bodies and joints with values that were given."""
    model = chosen.original.model
    if not chosen.given or not isinstance(model, Model) or _are_plainly_possible(chosen):
        return []
    return value_problems(model, chosen.given, chosen.free)


def _are_plainly_possible(chosen: ParameterSet) -> bool:
    """Return whether values are possible at first sight, which is quicker than to look at all formulas."""
    eqs, given = chosen.original, chosen.given.keys()
    if chosen.free or not eqs.are_formed:
        return False
    sources = _entries_of(eqs).sources
    changed = {*given, *(name for name, read in sources.items() if not read.isdisjoint(given))}
    return quantity_plan(eqs).judged.isdisjoint(changed) and chosen.quantities.are_plainly_possible


def _values(entries: Mapping[str, Entry], declared: _ModelEntries, changed: Set[str]) -> dict[str, Constant]:
    """Return the values of all parameters that do not follow from free ones.

    Parameters
    ----------
    changed : set of str
        Parameters that are free, or not what they are in the model.
    """
    values: dict[str, Constant] = {}
    for name, entry in entries.items():
        value: Constant | None
        if not isinstance(entry, Formula):
            value = entry
        elif name not in changed and changed.isdisjoint(declared.sources[name]) and name in declared.values:
            value = declared.values[name]
        else:
            value = formula_value(entry, values)
        if value is not None:
            values[name] = value
    return values


def _entry(name: str, value: Value) -> Constant | Formula:
    """Return what a caller gives: a number, or a formula in which something is exact or is read."""
    plain = plain_value(value)
    if type(plain) is float and math.isfinite(plain):
        size = read_number(str(abs(plain)))
        return -size if plain < 0.0 else size
    formula = Formula.from_value(plain, where=name)
    number = formula.constant()
    if number is not None:
        return number
    if set(formula.names) <= {"pi"}:
        number = formula_value(formula)
        parts = as_float(number if number is not None else math.nan) * _EXACT_PARTS / math.pi
        is_exact = (
            isinstance(number, float) and abs(parts - round(parts)) < 1e-9 if math.isfinite(parts) else True
        )
        if number is not None and not is_exact:
            return number
    return formula
