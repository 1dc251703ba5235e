"""Laws of inputs: formulas and short tables become part of the equations, others are called at run time."""

from __future__ import annotations

import ctypes
import signal
import threading
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field, replace
from types import FrameType
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from symbody.codegen.formation.names import Value, unknown_name
from symbody.codegen.function import CompiledFunction
from symbody.equations.equation_set import EquationSet
from symbody.errors import CompileError, Problem, SimulationError
from symbody.expr.language.formula import Formula
from symbody.model.model import Model
from symbody.model.tables.lookup import Lookup
from symbody.simulation.inputs.fmu_input import FmuInput, check_fmu_inputs, refuse_fmu_inputs
from symbody.simulation.inputs.held_law import HeldLaw
from symbody.simulation.inputs.tables import Table, table_numbers
from symbody.simulation.native.description import NO_TABLES

Floats = NDArray[np.float64]
Callback = Callable[[float, Floats, Floats], float]
Law = Value | Table | tuple[ArrayLike, ArrayLike] | Callback | FmuInput

NATIVE: Final = ctypes.CFUNCTYPE(ctypes.c_int32, *[ctypes.c_void_p] * 8)
# Differences of a law are taken over a share of the state, or of this where the state is smaller.
_SHARE: Final = 1.5e-8  # the root of what numbers are rounded by
_LEAST: Final = 1e-2


@dataclass(frozen=True, slots=True)
class InputLaws:
    """The laws of all inputs of a run.

    Attributes
    ----------
    formulas : mapping of name to formula
        Part of the equations.
    callbacks : mapping of name to callable
        Of t, q and u: what is not part of the equations.
    notes : tuple of str
        What is slow, and why.
    tables : mapping of place to Table
        Those among `callbacks` that are tables.
    coordinates : int, optional
        How many coordinates there are, where states of signals may stand behind them.
    """

    formulas: Mapping[str, Value]
    callbacks: Mapping[str, Callback]
    notes: tuple[str, ...]
    tables: Mapping[int, Table]
    coordinates: int | None = field(default=None, kw_only=True)

    def values(self, t: Floats, q: Floats, u: Floats) -> Floats:
        """Return the values of callbacks at times (N,) with q (n_q, N) and u (n_u, N): (N, n).

        Raises SimulationError if a law fails.
        """
        if not self.callbacks:
            return np.empty((t.size, 0))
        values = np.zeros((t.size, len(self.callbacks)))
        held_laws = self.held_laws
        for place, name in enumerate(self.callbacks):
            if place in self.tables:
                values[:, place] = self.tables[place].at(t)
            elif place in held_laws:
                values[:, place] = held_laws[place].values_at(t)
            else:
                points = zip(t.tolist(), q[: self.coordinates].T, u.T, strict=True)
                values[:, place] = [self.call(name, *point) for point in points]
        return values

    @property
    def held_laws(self) -> dict[int, HeldLaw]:
        """Those among `callbacks` that are held values, by their places."""
        return {k: law for k, law in enumerate(self.callbacks.values()) if isinstance(law, HeldLaw)}

    def held_now(self) -> Floats:
        """Return numbers for all callbacks: held values at present, 0 for others, which are computed."""
        values = np.zeros(len(self.callbacks))
        for place, law in self.held_laws.items() if self.callbacks else ():
            values[place] = law.current()
        return values

    def with_held(self, laws: Mapping[str, HeldLaw]) -> InputLaws:
        """Return the laws with more inputs that are held."""
        return replace(self, callbacks={**self.callbacks, **laws})

    @property
    def need_python(self) -> bool:
        """Whether some callbacks are more than tables and held values, which compiled loops read."""
        return bool(self.callbacks) and len(self.tables) + len(self.held_laws) < len(self.callbacks)

    def table_numbers(self) -> Floats:
        """Return all tables as `symbody.kernels.tables` reads them, nothing where Python has to be called."""
        return NO_TABLES if self.need_python or not self.tables else table_numbers(self.tables)

    def evaluate(self, t: float, q: Floats, u: Floats) -> list[float]:
        """Return the values of callbacks at one time.

        Raises SimulationError if a law raises, or returns anything but a finite number.
        """
        q = q[: self.coordinates]
        return [self.call(name, t, q, u) for name in self.callbacks]

    def call(self, name: str, t: float, q: Floats, u: Floats) -> float:
        """Return the value of one callback."""
        return _call_law(name, self.callbacks[name], t, q, u)

    def slopes(self, t: float, x: Floats, n_u: int) -> Floats:
        """Return the derivatives of callbacks by x = (u, q), (n, x.size), as differences.

        Raises SimulationError if a law fails.
        """
        here = np.array(self.evaluate(t, x[n_u:].copy(), x[:n_u].copy()))
        found = np.empty((here.size, x.size))
        for k, value in enumerate(x):
            beside = x.copy()
            beside[k] += _SHARE * max(abs(value), _LEAST)
            there = np.array(self.evaluate(t, beside[n_u:], beside[:n_u].copy()))
            found[:, k] = (there - here) / (beside[k] - value)
        return found


def silent_input_note(units: Mapping[str, str], name: str) -> str:
    """Return the note on an input without a value; its unit, where it has one, says what it acts as.

    >>> silent_input_note({"T": "N m"}, "T")
    'input T has no value and is 0 N m'
    """
    return f"input {name} has no value and is 0 {units.get(name, '')}".rstrip()


def input_laws(
    names: Sequence[str],
    given: Mapping[str, Law],
    span: tuple[float, float],
    coordinates: int | None = None,
    *,
    has_fmus: bool = False,
) -> InputLaws:
    """Return the laws of inputs; those without one are 0; unknown names of formulas are left to `compile`.

    Raises CompileError if a function or a long table is given for an input that is not there; UsageError if a
    table cannot be read or does not reach over the span, or FMUs have no place here.

    Parameters
    ----------
    has_fmus : bool
        Whether FMUs may compute inputs; these are 0 until a first sample is taken.
    """
    if not has_fmus:
        refuse_fmu_inputs(given)
    if given:
        check_fmu_inputs(given, names)
    formulas: dict[str, Value] = dict.fromkeys(names, 0)
    callbacks: dict[str, Callback] = {}
    long: dict[str, Table] = {}
    notes = []
    for name, law in given.items():
        table = Table(*law) if isinstance(law, tuple) else law
        if isinstance(table, FmuInput):
            long[name] = Table((0.0, 1.0), (0.0, 0.0))
            callbacks[name] = long[name].reader()
        elif isinstance(table, Table):
            table.check_span(name, *span)
            if table.is_short:
                formulas[name] = table.formula()
            else:
                callbacks[name], long[name] = table.reader(), table
        elif isinstance(table, str | int | float | Formula) or not callable(table):
            formulas[name] = table
        elif isinstance(table, HeldLaw):
            callbacks[name] = table
        else:
            callbacks[name] = table
            notes.append(
                f"input {name} is a Python function, which is slow because every evaluation calls it; "
                f"implicit methods approximate its derivatives by differences; a step may miss a short "
                f"pulse: give the integrator a max_step="
            )
    unknown = [unknown_name("input", name, names) for name in callbacks if name not in names]
    if unknown:
        raise CompileError(*unknown)
    kept = {name: value for name, value in formulas.items() if name not in callbacks}
    in_order = {name: callbacks[name] for name in names if name in callbacks}
    tables = {place: long[name] for place, name in enumerate(in_order) if name in long}
    return InputLaws(kept, in_order, tuple(notes), tables, coordinates=coordinates)


def laws_of_tables(eqs: EquationSet) -> dict[str, Law]:
    """Return the laws that tables of the model give to inputs of their name, where a call gives no other."""
    model = eqs.model
    tables = (
        [table for table in model.tables if table.name in model.inputs] if isinstance(model, Model) else []
    )
    return {table.name: _law_of_table(table) for table in tables if table.name in eqs.input_names}


def _law_of_table(table: Lookup) -> Table:
    t, values = zip(*table.points, strict=True)
    return Table(t, values, table.interpolation)


class NativeCallback(ABC):
    """A Python function with the signature of generated code.

    What it raises is kept in `error`, and every later call fails at once, which ends the loop.
    """

    def __init__(self) -> None:
        self.error: Exception | KeyboardInterrupt | None = None
        self._entry = NATIVE(self._call)

    @property
    def address(self) -> int:
        """Where it lies, as long as this object lives."""
        return ctypes.cast(self._entry, ctypes.c_void_p).value or 0

    @contextmanager
    def interruptible(self) -> Iterator[None]:
        """Let Ctrl-C end the loop from within: raised between native and Python code it would be lost."""
        usual = signal.getsignal(signal.SIGINT)
        is_main = threading.current_thread() is threading.main_thread()
        if not is_main or usual is not signal.default_int_handler:
            yield
            return
        signal.signal(signal.SIGINT, self._interrupt)
        try:
            yield
        finally:
            signal.signal(signal.SIGINT, usual)

    def _interrupt(self, number: int, frame: FrameType | None) -> None:
        self.error = KeyboardInterrupt()

    def _call(self, *places: int) -> int:
        if self.error is not None:
            return 1
        try:
            return self.answer(*places)
        except (Exception, KeyboardInterrupt) as error:  # nothing may pass through native code
            self.error = error
            return 1

    @abstractmethod
    def answer(self, t: int, q: int, u: int, r: int, p: int, c: int, out: int, work: int) -> int:
        """Store into the arrays at the last addresses; return 0, or what is wrong."""


class CallbackFunction(NativeCallback):
    """Calls laws of inputs, then another function.

    Parameters
    ----------
    function : CompiledFunction
        Its inputs r are the callbacks of `laws`.
    laws : InputLaws
        The laws.
    """

    def __init__(self, function: CompiledFunction, laws: InputLaws) -> None:
        super().__init__()
        self._function = function
        self._laws = laws
        signature = function.signature
        self._q, self._u = (ctypes.c_double * len(signature.names(group)) for group in "qu")
        self._r = ctypes.c_double * len(signature.r)
        self._inner = NATIVE(function.address)

    def answer(self, t: int, q: int, u: int, r: int, p: int, c: int, out: int, work: int) -> int:
        """Store what the function computes."""
        time = ctypes.c_double.from_address(t).value
        values = self._laws.evaluate(
            time, np.array(self._q.from_address(q)), np.array(self._u.from_address(u))
        )
        self._r.from_address(r)[:] = [ctypes.c_double(value) for value in values]
        return int(self._inner(t, q, u, r, p, c, out, work))


@contextmanager
def called_laws(functions: Sequence[CompiledFunction], laws: InputLaws) -> Iterator[list[int]]:
    """Give the addresses of functions that call the laws of inputs; raise what one of these raised."""
    if not laws.need_python:
        yield [function.address for function in functions]
        return
    calls = [CallbackFunction(function, laws) for function in functions]
    with ExitStack() as stack:
        stack.enter_context(calls[0].interruptible())
        yield [call.address for call in calls]
    for call in calls:
        if call.error is not None:
            raise call.error


def _call_law(name: str, law: Callback, t: float, q: Floats, u: Floats) -> float:
    try:
        given = np.asarray(law(t, q, u))
    except Exception as error:
        what = f"at t = {t:.9g} s the function raised {type(error).__name__}: {error}"
        raise _law_fault(name, what, "correct the function; it is called as f(t, q, u)") from error
    if given.shape != () or given.dtype.kind not in "fiu":
        what = f"at t = {t:.9g} s the function returned {_describe(given)}"
        raise _law_fault(name, what, "return one number")
    value = float(given)
    if not np.isfinite(value) and np.isfinite(q).all() and np.isfinite(u).all():
        raise _law_fault(name, f"at t = {t:.9g} s the function returned {value}", "return finite numbers")
    return value


def _describe(given: NDArray[np.generic]) -> str:
    return f"an array of shape {given.shape}" if given.shape else repr(given.item())


def _law_fault(name: str, what: str, fix: str) -> SimulationError:
    return SimulationError(Problem("simulation.input", f"input {name}", what, fix=fix))
