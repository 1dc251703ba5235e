"""`solve_index_1`: rates and reactions from one linear system, for whoever integrates equations himself.

Equations of index 1 are linear in the highest derivatives and in the reactions together, and determine both:
``A (x', reactions) = b``. The first are integrated, the others follow at every state (Ascher & Petzold 1998,
section 9.1).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final, NoReturn

import numpy as np
from numpy.typing import ArrayLike, NDArray

from symbody.arguments import checked_arguments, named_after
from symbody.codegen.formation.bound_function import bound_function
from symbody.codegen.formation.names import Value
from symbody.codegen.function import CompiledFunction
from symbody.codegen.signature import Signature
from symbody.equations.equation_set import EquationSet
from symbody.equations.index_reduction.index_one_form import IndexOneForm, index_one_form
from symbody.errors import CompileError, FormulationError, Problem, SimulationError, nearest
from symbody.expr.graph import TIME
from symbody.expr.rewrite import substitute
from symbody.expr.sequences.sequence import Input, Roots, build_sequence
from symbody.expr.sympy.sympy_bridge import SympyEquation, SympyExpr

Floats = NDArray[np.float64]

# A matrix is singular where its least singular value is that share of the largest: of scaled rows rounding
# alone leaves about n eps.
_SINGULAR: Final = 1e-13


@dataclass(frozen=True, slots=True)
class IndexOneSolution:
    """Rates ``f(t, x)`` for `scipy.integrate.solve_ivp`, and the reactions at a state.

    Attributes
    ----------
    state_names : tuple of str
        The entries of x.
    reaction_names : tuple of str
        The entries of `reactions`.

    Examples
    --------
    >>> import symbody as sb
    >>> x, y = (sb.Prismatic(c, "ground", sb.Body(c.upper(), mass=1), axis=c, coordinate=c) for c in "xy")
    >>> ladder = sb.Model("ladder", [x, y, sb.Distance("rod", "X", "Y", 5)], initial={"x": 3, "y": 4})
    >>> solution = sb.solve_index_1(sb.form_equations(ladder))
    >>> solution.state_names, solution(0.0, [4.0, -3.0, 3.0, 4.0])[2:]
    (('x_dot', 'y_dot', 'x', 'y'), array([ 4., -3.]))
    """

    state_names: tuple[str, ...]
    reaction_names: tuple[str, ...]
    _solve: Callable[[Floats, Floats], tuple[Floats, Floats]]

    def __call__(self, t: float, x: ArrayLike) -> Floats:
        """Return x', (n,)."""
        return self._solve(np.asarray(t, dtype=float), self._state(x))[0]

    @checked_arguments
    def reactions(self, t: ArrayLike, x: ArrayLike) -> Floats:
        """Return the reactions, (m,), at a state (n,); or (m, N) at the states (n, N) of N times."""
        found = self._solve(np.asarray(t, dtype=float), self._state(x).T)[1]
        return np.asarray(found.T)

    def _state(self, x: ArrayLike) -> Floats:
        state = np.asarray(x, dtype=float)
        if state.ndim not in (1, 2) or state.shape[0] != len(self.state_names):
            raise CompileError(
                Problem("index_1.state", "x", f"the state has shape {state.shape}",
                        f"it needs {len(self.state_names)} entries",
                        f"give {', '.join(self.state_names)}, in this order")
            )  # fmt: skip
        return state


@named_after(3)
@checked_arguments
def solve_index_1(
    equations: EquationSet | Sequence[SympyExpr | SympyEquation],
    derivatives: Sequence[SympyExpr] = (),
    reactions: Sequence[SympyExpr] = (),
    parameters: Mapping[object, Value] | None = None,
) -> IndexOneSolution:
    """Return rates and reactions of equations of index 1 as functions of time and state.

    Parameters
    ----------
    equations : EquationSet or sequence of SymPy equations
        The constraints among SymPy's differentiated until they hold the highest derivatives, with
        stabilizing terms or without; an expression stands for an equation with 0. An EquationSet is brought
        to this form: ``M u' - J^T lambda = F``, ``J u' = gamma``; `Baumgarte.applied` adds its terms.
    derivatives : sequence of SymPy derivatives
        The highest of each unknown: ``x.diff(t)``, or ``q.diff(t, 2)`` for equations of second order.
        The state is what each is the rate of, then the lower derivatives: (x), or (q', q).
    reactions : sequence of SymPy functions of time
        Unknowns without derivative: reactions or multipliers.
    parameters : mapping of symbol or name to number
        The values of all parameters; of an EquationSet those that differ from the model's.

    Returns
    -------
    IndexOneSolution
        A function of t and the states that returns their rates, with ``reactions``.

    Raises
    ------
    FormulationError
        If the equations are not linear in derivatives and reactions, or not as many as these.
    CompileError
        If parameters have no value, listing all of them, or are unknown.
    SimulationError
        In a call at a state where the system is singular.

    Examples
    --------
    >>> import symbody as sb
    >>> a = sb.Prismatic("a", "ground", sb.Body("A", mass=1), axis="x", coordinate="x")
    >>> b = sb.Prismatic("b", "ground", sb.Body("B", mass=1), axis="y", coordinate="y")
    >>> rod = sb.Distance("rod", "A", "B", 5)
    >>> eqs = sb.form_equations(sb.Model("ladder", [a, b, rod], initial={"x": 3, "y": 4}))
    >>> solution = sb.solve_index_1(eqs)
    >>> solution.state_names
    ('x_dot', 'y_dot', 'x', 'y')
    """
    given = {str(name): value for name, value in (parameters or {}).items()}
    if isinstance(equations, EquationSet):
        return _of_mechanism(equations, given)
    form = index_one_form(equations, derivatives, reactions)
    compiled = _compile(form, given)
    n, m = len(form.derivatives), len(form.reaction_names)
    low = form.lower

    def solve(t: Floats, x: Floats) -> tuple[Floats, Floats]:
        system = compiled(t, x, ())
        right = system.right[..., np.newaxis]
        try:
            solution = np.linalg.solve(system.matrix, right)[..., 0]
        except np.linalg.LinAlgError:
            _singular(form, system.matrix)
        if not np.isfinite(solution).all() or _is_singular(system.matrix):
            _singular(form, system.matrix)
        rates = np.concatenate([solution[..., :n], x[..., low]], axis=-1)
        return rates, solution[..., n : n + m]

    return IndexOneSolution(form.state_names, form.reaction_names, solve)


def _of_mechanism(eqs: EquationSet, parameters: Mapping[str, Value]) -> IndexOneSolution:
    function = bound_function(eqs, ("xdot", "lambda"), parameters)
    if eqs.input_names:
        raise FormulationError(
            Problem("index_1.inputs", "equations", f"the inputs {', '.join(eqs.input_names)} have no value",
                    "the rates may depend on time and state only",
                    "define the inputs in the model, or call simulate with inputs=")
        )  # fmt: skip

    def solve(t: Floats, x: Floats) -> tuple[Floats, Floats]:
        rates_and_multipliers = function.of_state(t, x)
        return rates_and_multipliers[0], rates_and_multipliers[1]

    return IndexOneSolution(eqs.state_names, eqs.multiplier_names, solve)


def _compile(form: IndexOneForm, given: Mapping[str, Value]) -> CompiledFunction:
    graph = form.graph
    missing = [name for name in form.parameters if name not in given]
    unknown = [name for name in given if name not in form.parameters]
    problems = [
        Problem("compile.unknown_parameter", name, f"the equations have no parameter {name!r}", "",
                nearest(name, form.parameters))
        for name in unknown
    ]  # fmt: skip
    if missing:
        problems.append(
            Problem("compile.missing_value", "parameters", f"no value is given for {', '.join(missing)}",
                    "the computation needs a number", f"give parameters={{{missing[0]!r}: ...}}")
        )  # fmt: skip
    values = {}
    for name, node in form.parameters.items():
        value = given.get(name, 0)
        try:
            values[node] = graph.constant(value if isinstance(value, int) else float(str(value)))
        except ValueError:
            problems.append(
                Problem("index_1.parameter", name, f"{value!r} is not a number", "",
                        "give a number for each parameter")
            )  # fmt: skip
    if problems:
        raise CompileError(*problems)
    n = len(form.right)
    matrix = substitute(graph, [entry for row in form.matrix for entry in row], values)
    roots = [
        Roots("matrix", (n, n), tuple(matrix)),
        Roots("right", (n,), tuple(substitute(graph, form.right, values))),
    ]
    places = {node: Input(name, "q", k)
              for k, (node, name) in enumerate(zip(form.state, form.state_names, strict=True))}  # fmt: skip
    places[graph.symbol(TIME)] = Input("t", "t", 0)
    return CompiledFunction(build_sequence(graph, roots, places), Signature(form.state_names, (), (), ()))


def _is_singular(matrix: Floats) -> bool:
    """Return whether rows, each over its largest entry, are dependent up to rounding."""
    scale = np.abs(matrix).max(axis=-1, initial=0.0, keepdims=True)
    values = np.linalg.svd(matrix / np.where(scale > 0.0, scale, 1.0), compute_uv=False)
    return bool(values.size and (values[..., -1] <= _SINGULAR * values[..., 0]).any())


def _singular(form: IndexOneForm, matrix: Floats) -> NoReturn:
    """Raise an error that names the unknowns the equations leave open."""
    batch = np.reshape(matrix, (-1, *matrix.shape[-2:]))
    finite = [one for one in batch if np.isfinite(one).all()]
    worst = min(finite, key=lambda one: float(np.linalg.svd(one, compute_uv=False)[-1]), default=None)
    names = form.unknown_names
    if worst is not None:
        null = np.abs(np.linalg.svd(worst)[2][-1])
        names = tuple(name for name, share in zip(names, null, strict=True) if share > 0.1 * null.max())
    raise SimulationError(
        Problem("index_1.singular", "equations", f"{', '.join(names)} are not determined at this state",
                "a mass is zero, constraints are redundant, or the equations are of index higher than 1",
                "give every body its mass, leave out constraints that others imply, and differentiate "
                "constraints until they contain the highest derivatives")
    )  # fmt: skip
