"""One motion to compute: equations with the values of parameters, and the laws of inputs."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, Final, TypeVar

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.configurations.plain_assembly import PlainState
from symbody.analysis.derivatives import with_outputs
from symbody.analysis.scales import Scales
from symbody.analysis.state import State
from symbody.codegen.formation.bound_function import bound_function
from symbody.codegen.formation.names import Value
from symbody.codegen.formation.parameter_set import parameter_set
from symbody.codegen.function import CompiledFunction
from symbody.equations.equation_set import EquationSet
from symbody.equations.outputs.output_roots import OF_MOTIONS, OF_STEPS, combined_roots
from symbody.simulation.inputs.breakpoints import NO_BREAKPOINTS, Breakpoints, search_ahead
from symbody.simulation.inputs.input_laws import InputLaws
from symbody.simulation.inputs.time_functions import function_of_time
from symbody.simulation.native.dense_output import DenseOutput
from symbody.simulation.native.description import RightHandSide
from symbody.simulation.results.evaluate import OutputEvaluator
from symbody.simulation.sampling.sampler import Sampler
from symbody.single_flight import SingleFlight

Floats = NDArray[np.float64]
T = TypeVar("T")

# A name, or several combined into one output. Each output is merged by itself, so that it has the same
# bits whatever else is asked for; what only solvers read is merged at once, in a time that does not grow with
# its number where formulas are shared, as those of accelerations and reactions are.
OutputName = str | tuple[str, ...]

NOTHING: Final = np.zeros(0)
# Outputs that are measured by the scales of a motion.
VIOLATIONS: Final = OF_MOTIONS[1:]


@dataclass(frozen=True, slots=True)
class SimulationProblem:
    """Equations with the values of parameters, the laws of all inputs, and what counts as large.

    Attributes
    ----------
    first : State, optional
        Where a motion starts, whose numbers need not be computed again.
    sampler : Sampler, optional
        Takes the samples of held values that the motion reads.
    permanent : SimulationProblem, optional
        The same without constraints that hold in some modes only; None where all hold.
    free : tuple of str
        Parameters that are arguments of compiled functions, as in a sweep; the others are part of them.
    p : (k,) or (N, k) array
        Their values, for all samples or for each.
    """

    eqs: EquationSet
    parameters: Mapping[str, Value]
    laws: InputLaws
    scales: Scales
    first: State | None = None
    sampler: Sampler | None = None
    permanent: SimulationProblem | None = None
    free: tuple[str, ...] = ()
    p: Floats = field(default_factory=lambda: NOTHING, compare=False)
    # Functions already compiled; they follow from the fields above.
    _functions: SingleFlight[tuple[EquationSet, tuple[OutputName, ...], bool, bool], CompiledFunction] = (
        field(default_factory=SingleFlight, repr=False, compare=False)
    )
    _breakpoints: dict[tuple[EquationSet, tuple[OutputName, ...]], tuple[list[float], Breakpoints]] = field(
        default_factory=dict, repr=False, compare=False
    )

    # What else follows from them, by its kind and what it is made of.
    _made: SingleFlight[Hashable, Any] = field(
        default_factory=partial(SingleFlight, 64), repr=False, compare=False
    )

    def keep(self, key: Hashable, make: Callable[[], T]) -> T:
        """Return what `make` makes from these equations and values, made once for each key."""
        made: T = self._made.get((self.eqs, key), make)
        return made

    def compile_outputs(
        self, outputs: str | Sequence[OutputName], *, quick: bool = False
    ) -> CompiledFunction:
        """Return a function of t, q and u, and of the inputs that are callbacks; `quick` for few calls."""
        is_one = isinstance(outputs, str)
        names: tuple[OutputName, ...] = (outputs,) if isinstance(outputs, str) else tuple(outputs)
        key = (self.eqs, names, is_one, quick)

        def compile_function() -> CompiledFunction:
            eqs, words = self._combine(names)
            asked = words[0] if is_one else words
            return bound_function(eqs, asked, self.parameters, self.free, self.laws.formulas, quick=quick)

        return self._functions.get(key, compile_function)

    def _combine(self, names: tuple[OutputName, ...]) -> tuple[EquationSet, tuple[str, ...]]:
        """Return equations in which outputs that are combined are one, and the names of all there."""
        words = tuple([name if isinstance(name, str) else f"combined {', '.join(name)}" for name in names])
        if words == names:
            return self.eqs, words
        # its formulas contain those rows alone that count with these values
        eqs = parameter_set(self.eqs, self.parameters, self.free).eqs

        def make() -> EquationSet:
            roots = [
                combined_roots(eqs.formed, word, name)
                for word, name in zip(words, names, strict=True)
                if not isinstance(name, str)
            ]
            return with_outputs(eqs, roots)

        return eqs.plans.get(words, make), words

    def with_other_times(self) -> SimulationProblem:
        """Return the problem without what was looked up of times at which it changes."""
        return replace(self, _breakpoints={})

    def breakpoints(self, span: tuple[float, float], watched: Sequence[OutputName] = ()) -> Breakpoints:
        """Return where what depends on time alone changes, in the equations and in expressions `watched`."""
        pieces_of_all = NO_BREAKPOINTS
        for outputs in (OF_STEPS, tuple(watched)):
            key = self.eqs, outputs
            if outputs and (key not in self._breakpoints or not _contains(self._breakpoints[key][0], span)):
                self._breakpoints[key] = sorted(span), self._find_breakpoints(outputs, span)
            if outputs:
                pieces_of_all = pieces_of_all.unite(self._breakpoints[key][1])
        return pieces_of_all

    def _find_breakpoints(self, outputs: tuple[OutputName, ...], span: tuple[float, float]) -> Breakpoints:
        function = self.compile_outputs(outputs)
        functions = [function_of_time(function, self.laws.tables)]
        return search_ahead(functions, span, function.bound_values[np.newaxis])[0]

    def evaluate(self, function: CompiledFunction, t: Floats, q: Floats, u: Floats) -> Any:
        """Return what a function gives at times (N,) with q (n_q, N) and u (n_u, N)."""
        r = self.laws.values(t, q, u)
        return function(t, q.T, u.T, r, self.p) if self.free else function.at_states(t, q.T, u.T, r)

    def numbers(self, function: CompiledFunction) -> RightHandSide:
        """Return what compiled loops call a function with; of several motions the numbers of the first."""
        p = self.p.reshape(-1, len(self.free))[0] if self.free else NOTHING
        inputs, constants = self.laws.held_now(), function.constants(p)
        tables, n_u = self.laws.table_numbers(), len(function.signature.u)
        return RightHandSide(function.address, n_u, inputs, p, constants, function.work_size, tables)

    def values_at(self, names: Sequence[OutputName], t: float, x: Floats) -> tuple[Any, ...]:
        """Return outputs at one time and state x = (u, q); those of a tuple of names as one array."""
        n_u = len(self.eqs.speed_names)
        q, u = x[n_u:], x[:n_u]
        values = self.compile_outputs(names)(t, q, u, self.laws.evaluate(t, q, u))
        return tuple(values) if len(names) > 1 else (values,)

    def value(self, output: str, t: float, q: Floats, u: Floats) -> float:
        """Return a number at one state."""
        inputs = self.laws.evaluate(t, q, u) if self.laws.callbacks else NOTHING
        return float(self.compile_outputs(output, quick=True)(t, q, u, inputs))

    def first_numbers(self, t: float, x: Floats) -> PlainState | None:
        """Return what was computed at a state x = (u, q), if that is the first and a plain one."""
        first = self.first
        if first is None or first.plain is None or first.eqs is not self.eqs or t != first.t:
            return None
        plain = first.plain
        n_u = plain.u.size
        return plain if (plain.u == x[:n_u]).all() and (plain.q == x[n_u:]).all() else None

    @property
    def is_closed(self) -> bool:
        """Whether states have to be projected."""
        return bool(self.eqs.multiplier_names or self.eqs.quaternions)


def _contains(known: Sequence[float], span: tuple[float, float]) -> bool:
    """Return whether a span lies in one that is known."""
    return known[0] <= min(span) and max(span) <= known[1]


@dataclass(frozen=True, slots=True)
class Evaluator(OutputEvaluator):
    """Computes outputs that are not stored, each compiled when it is first read."""

    problem: SimulationProblem
    work: DenseOutput | None

    @property
    def wrapped_angles(self) -> tuple[str, ...]:
        """Angles of cut joints, which are given within half a turn."""
        return self.problem.eqs.wrapped_angles

    def together(self, names: Sequence[str], t: Floats, q: Floats, u: Floats) -> list[Floats]:
        """Return outputs with time last, all that are compiled in one function."""
        special = {name: self._special(name, t, q, u) for name in names}
        plain = tuple(name for name, values in special.items() if values is None)
        made: dict[str, Floats] = {}
        if plain:
            outputs = plain[0] if len(plain) == 1 else plain
            values = self.problem.evaluate(self.problem.compile_outputs(outputs, quick=True), t, q, u)
            made = dict(zip(plain, (values,) if len(plain) == 1 else values, strict=True))
        return [
            np.moveaxis(made[name], 0, -1) if (array := special[name]) is None else array for name in names
        ]

    def _special(self, name: str, t: Floats, q: Floats, u: Floats) -> Floats | None:
        """Return what is not compiled as it stands; None for all else."""
        if name == "work" and self.work is not None:
            done: Floats = self.work(t)[0]
            return done
        if name == VIOLATIONS[0]:
            return self._violation("constraints", t, q, u)
        if name == VIOLATIONS[1]:
            sizes = np.atleast_2d(self.problem.scales.displacements(self.problem.eqs)).T
            fastest = np.abs(u / sizes).max(axis=0, initial=0.0)
            violation = self._violation("velocity_constraints", t, q, u)
            moving = fastest > 0.0
            return np.where(moving, violation / np.where(moving, fastest, 1.0), violation)
        return None

    def _violation(self, name: str, t: Floats, q: Floats, u: Floats) -> Floats:
        """Return the largest constraint over its scale at each time."""
        problem = self.problem
        if not problem.eqs.multiplier_names:
            return np.zeros_like(t)
        values = problem.evaluate(problem.compile_outputs(name, quick=True), t, q, u)
        scales = problem.scales.constraints(problem.eqs)[..., : values.shape[-1]]
        largest: Floats = np.abs(values / scales).max(axis=-1, initial=0.0)
        return largest
