"""`plain_state`: a state that fulfils the constraints, where these are independent by a wide margin.

The usual case, computed by one call of the kernel `first_state`. All else is left to `assemble`, which judges
what is singular, redundant, inconsistent or far away, and says so.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.curvature import limited_coordinates
from symbody.analysis.named_values import unit_quaternions
from symbody.analysis.scales import Scales
from symbody.codegen.call_arguments import address
from symbody.codegen.formation.bound_function import bound_function
from symbody.codegen.formation.names import Value
from symbody.codegen.function import CompiledFunction
from symbody.codegen.llvm.kernel_library import load_kernels
from symbody.equations.equation_set import EquationSet
from symbody.equations.outputs.output_roots import OF_STEPS
from symbody.kernels.block import FunctionNumbers
from symbody.kernels.configurations.assembly import ASSEMBLED as SOLVED
from symbody.kernels.configurations.assembly_problem import AssemblyProblem
from symbody.kernels.configurations.closing import closing_size
from symbody.kernels.configurations.first_state import speeds_size
from symbody.kernels.pack import pack
from symbody.single_flight import once
from symbody.tolerances import ASSEMBLED, EXACT

Floats = NDArray[np.float64]

_OUTPUTS: Final = (
    "constraints", "position_jacobian", "velocity_residual", "jacobian", "alignment", "gamma", "udot",
    "lambda", "kinetic_energy",
)  # fmt: skip
# Speeds and coordinates above which rows are not made independent one by one.
_MOST_STATES: Final = 300
# Speeds from which on a tree has no code of its own for first states: compiling takes a share of the time to
# the first motion then, and the code of motions gives the accelerations too.
LARGE_TREE: Final = 100


@dataclass(frozen=True, slots=True, eq=False)
class PlainState:
    """A state on the constraints.

    Attributes
    ----------
    start, q : (n_q,) array
        Where the search began, and where it ended.
    u, udot, multipliers : (n_u,), (n_u,), (n_c,) array
    residual : float
    kinetic_energy : float or None
        None where it was not computed.
    is_regular : bool
        Whether all constraints that are not 0 = 0 are independent by a wide margin.
    """

    start: Floats
    q: Floats
    u: Floats
    udot: Floats
    multipliers: Floats
    residual: float
    kinetic_energy: float | None
    is_regular: bool


def plain_state(
    eqs: EquationSet,
    fixed: Mapping[str, float],
    near: Mapping[str, float],
    values: tuple[Mapping[str, Value], Mapping[str, Value]],
    t: float,
    mechanism: Scales,
) -> PlainState | None:
    """Return the state nearest to a guess, or None where it is not plain.

    Parameters
    ----------
    fixed, near : mapping of name to float
        Values that are kept, and those that are guessed.
    values : pair of mappings
        Of parameters and of inputs.

    Raises
    ------
    CompileError, ExpressionError, FormulationError
        If values are impossible or missing.
    """
    if is_large_tree(eqs, fixed, near):
        return _tree_state(eqs, fixed, near, values, t)
    if not is_plain(eqs, fixed, near):
        return None
    function = plain_function(eqs, values[0], (), values[1])
    if function.signature.r:
        return None
    return plain_assembly(eqs, function).solve(function.constants(), mechanism, fixed, near, t)


def is_large_tree(eqs: EquationSet, fixed: Mapping[str, float], near: Mapping[str, float]) -> bool:
    """Return whether there is nothing to close, and so much to compile that code should serve twice."""
    if len(eqs.speed_names) < LARGE_TREE or eqs.multiplier_names:
        return False
    counts = [sum(name in fixed for name in four) for four in eqs.quaternions]
    return _are_states(eqs, fixed, near) and all(count in (0, 4) for count in counts)


def _tree_state(
    eqs: EquationSet,
    fixed: Mapping[str, float],
    near: Mapping[str, float],
    values: tuple[Mapping[str, Value], Mapping[str, Value]],
    t: float,
) -> PlainState | None:
    """Return the state of a tree, where every value is kept; None where accelerations do not exist."""
    given = dict.fromkeys(eqs.input_names, 0) | dict(values[1])
    function = bound_function(eqs, OF_STEPS, values[0], (), given)
    if function.signature.r:
        return None
    fixed, near = unit_quaternions(eqs.quaternions, fixed, near)
    chosen = {**near, **fixed}
    q, u = _start(eqs, chosen), np.array([chosen.get(name, 0.0) for name in eqs.speed_names])
    udot = np.array(function(t, q, u)[0][: u.size])
    if not np.isfinite(udot).all():
        return None
    return PlainState(q, q.copy(), u, udot, np.zeros(0), 0.0, None, True)


def plain_function(
    eqs: EquationSet, parameters: Mapping[str, Value], free: Iterable[str], inputs: Mapping[str, Value]
) -> CompiledFunction:
    """Return what `plain_assembly` takes; inputs without a value are 0."""
    given = dict.fromkeys(eqs.input_names, 0) | dict(inputs)
    weighed = ("mass_matrix",) if eqs.multiplier_names else ()
    return bound_function(eqs, (*_OUTPUTS, *weighed), parameters, free, given, quick=True)


def plain_assembly(eqs: EquationSet, function: CompiledFunction) -> PlainAssembly:
    """Return what finds plain states with a `plain_function`, kept with its code."""
    made: PlainAssembly = function.kept_with_code("first state", lambda: PlainAssembly(eqs, function))
    return made


def is_plain(eqs: EquationSet, fixed: Mapping[str, float], near: Mapping[str, float]) -> bool:
    """Return whether values are those of states, and constraints few enough to be taken one by one."""
    is_long = len(eqs.state_names) > _MOST_STATES
    return not (is_long and (eqs.multiplier_names or eqs.quaternions)) and _are_states(eqs, fixed, near)


def _are_states(eqs: EquationSet, fixed: Mapping[str, float], near: Mapping[str, float]) -> bool:
    """Return whether all values are those of states, nothing is eliminated, and no signal has a state."""
    if eqs.formed.elimination is not None or eqs.signal_state_names:
        return False
    states = eqs.plans.get("states", lambda: frozenset(eqs.state_names))
    return bool(fixed.keys() <= states and near.keys() <= states)


def _start(eqs: EquationSet, values: Mapping[str, float]) -> Floats:
    """Return coordinates with given values, 0 for the others, and quaternions of norm 1."""
    places = {name: k for k, name in enumerate(eqs.coordinate_names)}
    q = np.array([values.get(name, 0.0) for name in places])
    for four in eqs.quaternions:
        own = [places[name] for name in four]
        norm = float(np.linalg.norm(q[own]))
        q[own] = q[own] / norm if norm > 0 else np.array([1.0, 0.0, 0.0, 0.0])
    return q


class PlainAssembly:
    """Finds plain states with one function, by `kernels.configurations.first_state` without values."""

    def __init__(self, eqs: EquationSet, function: CompiledFunction) -> None:
        self._eqs = eqs
        self._function = function.address
        self._code = function  # keeps the machine code alive
        sizes = [len(output.values) for output in function.outputs]
        n_u, n_q = len(eqs.speed_names), len(eqs.coordinate_names)
        residuals, rows = sizes[0], sizes[2]
        four = [eqs.coordinate_names.index(name) for names in eqs.quaternions for name in names]
        closed = max(n_u, n_q) if residuals or rows or four else 0
        constants = function.constant_count
        numbers = pack(FunctionNumbers, constant_count=constants, work_size=function.work_size)
        self._template = pack(
            AssemblyProblem, speeds=n_u, coordinates=n_q, residuals=residuals, rows=rows, out_size=sum(sizes),
            quaternion_count=len(eqs.quaternions), share=ASSEMBLED, enough=EXACT, cosines=sizes[4],
            held=np.zeros(n_u + n_q), sizes=np.zeros(n_u + n_q), matrices=np.zeros(closing_size(closed)),
            numbers=numbers, quaternion_places=four, limited=limited_coordinates(eqs),
            row_room=np.zeros(speeds_size(n_u) if rows else 0),
        )  # fmt: skip
        self._begins = {
            name: int(self._template[field.place])
            for name, field in AssemblyProblem.fields.items()
            if field.pointer is not None
        }
        begin = self._begins["numbers"]
        begin += int(self._template[begin + FunctionNumbers.layout["constants"]])
        self._constants = slice(begin, begin + constants)
        self._outputs = np.cumsum([self._begins["out"], *sizes]).tolist()
        self._residuals = residuals
        self._silent = _silent_rows(function, rows)
        self._speeds = {name: float(k) for k, name in enumerate(eqs.speed_names)}

    def solve(
        self,
        constants: Floats,
        mechanism: Scales,
        fixed: Mapping[str, float],
        near: Mapping[str, float],
        t: float,
    ) -> PlainState | None:
        """Return the state nearest to a guess, or None where it is not plain.

        Parameters
        ----------
        constants : array
            Of the function.
        fixed, near : mapping of name to float
            Values that are kept, and those that are guessed; see `is_plain`.
        """
        eqs, begins = self._eqs, self._begins
        fixed, near = unit_quaternions(eqs.quaternions, fixed, near)
        start = _start(eqs, {**near, **fixed})
        A, n_u, n = self._template.copy(), len(eqs.speed_names), len(eqs.state_names)
        held = begins["held"] + n_u
        for k, name in enumerate(eqs.coordinate_names):
            A[held + k] = name in fixed
        first = begins["sizes"]
        A[first : first + n_u], A[first + n_u : first + n] = (
            mechanism.displacements(eqs), mechanism.coordinates(eqs),
        )  # fmt: skip
        first = begins["scales"]
        A[first : first + self._residuals] = mechanism.constraints(eqs)[: self._residuals]
        self._choose_speeds(A, fixed, near)
        A[self._constants] = constants
        x = np.concatenate([np.zeros(n_u), start])
        if _kernel()(self._function, address(A), t, address(x)) != SOLVED or not (np.isfinite(x).all()):
            return None
        return self._state(A, x, start)

    def _choose_speeds(self, A: Floats, fixed: Mapping[str, float], near: Mapping[str, float]) -> None:
        """Enter speeds in the order in which they take their values: fixed, then guessed."""
        speeds, chosen = self._speeds, []
        for values in (fixed, near):
            for name, value in values.items():
                if name in speeds and (values is fixed or name not in fixed):
                    chosen += [speeds[name], value]
            if values is fixed:
                AssemblyProblem(A).kept = len(chosen) // 2
        AssemblyProblem(A).choices = len(chosen) // 2
        first = self._begins["chosen"]
        A[first : first + len(chosen)] = chosen

    def _state(self, A: Floats, x: Floats, start: Floats) -> PlainState:
        """Return what the kernel left."""
        n_u, outputs = len(self._speeds), self._outputs
        phi = A[outputs[0] : outputs[1]]
        return PlainState(
            start, x[n_u:], x[:n_u], A[outputs[6] : outputs[7]], A[outputs[7] : outputs[8]],
            float(np.abs(phi).max(initial=0.0)), float(A[outputs[8]]),
            AssemblyProblem(A).zero_rows == self._silent,
        )  # fmt: skip


def _silent_rows(function: CompiledFunction, rows: int) -> int:
    """Return how many rows of J are zero whatever moves."""
    if not rows:
        return 0
    sequence = function.shared_sequence
    entries = sequence.outputs[3].values
    width = len(entries) // rows
    zeros = [sequence.constant_value(entry) == 0 for entry in entries]
    return sum(all(zeros[k * width : (k + 1) * width]) for k in range(rows))


@once
def _kernel() -> Callable[[int, int, float, int], int]:
    """Return the kernel, ready to be called."""
    pointer, kind = ctypes.c_void_p, ctypes.CFUNCTYPE
    function = kind(ctypes.c_int64, pointer, pointer, ctypes.c_double, pointer)
    call: Callable[[int, int, float, int], int] = function(
        load_kernels("first_state", ["first_state"], light=True)["first_state"]
    )
    return call
