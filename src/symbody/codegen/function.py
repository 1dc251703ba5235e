"""`CompiledFunction`: a sequence as native code behind a NumPy calling convention."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from collections.abc import Sequence as Items
from dataclasses import replace
from functools import partial
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from symbody.arguments import checked_arguments
from symbody.codegen.call_arguments import (
    as_array,
    broadcast,
    check_out,
    checked_group,
    checked_threads,
    length_problem,
    with_signals,
)
from symbody.codegen.direct_call import DirectCall
from symbody.codegen.llvm.native import NativeFunction
from symbody.codegen.portable_text import portable_text
from symbody.codegen.results import CallLayout, call_layout, split_outputs
from symbody.codegen.shared_code import SharedCode
from symbody.codegen.signature import Signature as Signature
from symbody.codegen.signature import source_text
from symbody.errors import CompileError
from symbody.expr.sequences.sequence import Output, Sequence
from symbody.single_flight import SingleFlight

Floats = NDArray[np.float64]
Specialize = Callable[[], Sequence]
NOTHING: Final = np.zeros(0)
_NO_SIGNALS: Final = ()
_NO_PARAMETERS: Final = ()
# Calls at a point after which a function has its own way into machine code; it takes some 50 us to make.
_FEW_CALLS: Final = 20


class CompiledFunction:
    """Native function ``f(t, q, u, r=(), p=(), *, s=(), out=None)``.

    Arguments are 1-D, or have leading batch axes that broadcast against each other: q of shape
    (B, n_q) gives results of shape (B, ...). Calls are reentrant; batches release the GIL; functions pickle.

    Parameters
    ----------
    sequence : Sequence
        What is computed.
    signature : Signature
        Names and order of the arguments, for messages.
    quick : bool
        Compile in less than half the time for calls that take 1.5 to 3 times as long; it pays below about
        100,000 evaluations. Results do not depend on it, nor on `lanes`.
    lanes : bool or None
        Whether batches are computed several points at once. True compiles that at the first batch, None when
        300,000 points have been asked for, False never.
    portable : bool
        Fuse no operation, so that `source` has the same bits.

    Examples
    --------
    >>> import symbody as sb
    >>> rail = sb.Prismatic("rail", "ground", sb.Body("Cart", mass="m"), axis="x", coordinate="x")
    >>> eqs = sb.form_equations(sb.Model("cart", [rail], parameters={"m": 2}))
    >>> energy = sb.compile(eqs, "kinetic_energy")
    >>> energy(0.0, [0.5], [3.0])
    array(9.)
    """

    def __init__(
        self, sequence: Sequence, signature: Signature, *, quick: bool = False, lanes: bool | None = None,
        portable: bool = False,
    ) -> None:  # fmt: skip
        code = SharedCode(sequence, quick=quick, lanes=lanes, portable=portable)
        self._bind_code(code, signature, NOTHING, None)

    @classmethod
    def from_code(
        cls, code: SharedCode, signature: Signature, values: Floats, specialize: Specialize | None = None,
        constants: Floats | None = None,
    ) -> CompiledFunction:  # fmt: skip
        """Return a function of code that others share.

        Parameters
        ----------
        signature : Signature
            What the function takes: p are the free parameters.
        values : (n,) array
            The other parameters of the code, behind the free ones.
        specialize : callable, optional
            Returns the sequence with the values put in, for source text.
        constants : (n_c,) array, optional
            What the code computes from the values, where that is known.
        """
        made = cls.__new__(cls)
        made._bind_code(code, signature, values, specialize)
        made._bound = constants
        return made

    def _bind_code(
        self, code: SharedCode, signature: Signature, values: Floats, specialize: Specialize | None
    ) -> None:
        self.signature = signature
        self._code = code
        self._values = values
        self._specialize = specialize
        key = "layout", len(signature.p)
        layout: CallLayout = code.notes.get(key, lambda: call_layout(code.sequence, signature))
        self._result, self._reads_s, self._sizes = layout
        # Made when they are first needed: what follows from the values, and calls at a point.
        self._made: SingleFlight[str, Any] = SingleFlight()
        self._bound: Floats | None = None
        self._at_point: Callable[..., Any] | None = None
        self._calls = 0

    @property
    def outputs(self) -> tuple[Output, ...]:
        """Names and shapes of the results."""
        return self._code.sequence.outputs

    @property
    def shared_sequence(self) -> Sequence:
        """What is computed, with all parameters as arguments p, the free ones first."""
        return self._code.sequence

    @property
    def bound_values(self) -> Floats:
        """The parameters of `shared_sequence` behind the free ones."""
        return self._values

    def kept_with_code(self, key: Hashable, make: Callable[[], Any]) -> Any:
        """Return what `make` derives from `shared_sequence`, once for all functions that share it."""
        return self._code.notes.get(key, make)

    @property
    def sequence(self) -> Sequence:
        """What is computed, with the values of all parameters that are not free."""
        if self._specialize is None:
            return self._code.sequence
        sequence: Sequence = self._made.get("sequence", self._specialize)
        return sequence

    def __call__(
        self,
        t: ArrayLike,
        q: ArrayLike,
        u: ArrayLike,
        r: ArrayLike = (),
        p: ArrayLike = (),
        *,
        s: ArrayLike = _NO_SIGNALS,
        out: Floats | None = None,
        threads: int = 1,
    ) -> Any:
        """Return the outputs: an array for one, a named tuple for several.

        Parameters
        ----------
        t : () or batch [s]
        q : (..., n_q) coordinates
        u : (..., n_u) speeds
        r : (..., n_r) inputs
        p : (..., n_p) free parameters
        s : (..., n_s) states of signals, where the outputs depend on them; they may also stand behind q
        out : array, optional
            Receives the result of a single output, of the result's shape, contiguous float64.
        threads : int
            Threads that share the points of a batch, fewer where that is faster; results do not depend on it.

        Raises
        ------
        CompileError
            If an argument has the wrong length or type, naming its entries in order.
        SimulationError
            If the mass matrix is singular on the admissible velocities.
        """
        if self.signature.s:
            q = self._with_signals(q, s)
        elif s is not _NO_SIGNALS and as_array("s", s).size:
            raise CompileError(length_problem("s", (), np.shape(s)))
        if out is None and self._at_point is not None:
            result = self._at_point(t, q, u, r, p)
            if result is not None:
                return result if self._result is None else self._taken_apart(result)
        points = self._points(t, q, u, r, p)
        if points is not None:
            check_out(out, (), self.outputs)
            return self._reshape_outputs(self._call_at_point(*points), (), out)
        given = {
            group: checked_group(group, x, self.signature.names(group))
            for group, x in zip("qurp", (q, u, r, p), strict=True)
        }
        given["t"] = checked_group("t", t, self.signature.names("t"))
        batch = broadcast(given)
        check_out(out, batch, self.outputs)
        given["c"] = self._constants(given.pop("p"))
        return self._reshape_outputs(self._code.tail(given, batch, checked_threads(threads)), batch, out)

    def _with_signals(self, q: ArrayLike, s: ArrayLike) -> Floats:
        """Return q with s behind."""
        return with_signals(q, s, (self.signature.q, self.signature.s), reads_s=self._reads_s)

    def _constants(self, p: Floats) -> Floats:
        """Return c for free parameters (..., n_p)."""
        if p.shape[-1]:
            return self._code.constants(self._all_parameters(p))
        return self.bound_constants

    @property
    def bound_constants(self) -> Floats:
        """The numbers c (n_c,) of a function without free parameters."""
        if self._bound is None:  # two threads may both compute them
            self._bound = self._code.constants(self._values)
        return self._bound

    def _all_parameters(self, p: Floats) -> Floats:
        """Return free parameters (..., n_p) with the others behind them."""
        if not self._values.size:
            return p
        if p.shape == (0,):
            return self._values
        return np.concatenate([p, np.broadcast_to(self._values, (*p.shape[:-1], self._values.size))], axis=-1)

    def at_states(self, t: Floats, q: Floats, u: Floats, r: Floats) -> Any:
        """Return the outputs at times () or (N,) for states (.., n); nothing is free, nor checked."""
        given = {"t": t[..., np.newaxis], "q": q, "u": u, "r": r, "c": self.bound_constants}
        return self._reshape_outputs(self._code.tail(given, q.shape[:-1]), q.shape[:-1], None)

    def of_state(self, t: ArrayLike, x: ArrayLike, r: ArrayLike = (), p: ArrayLike = ()) -> Any:
        """Return the outputs for a state (speeds, coordinates, signals), the order of ``eqs.states``."""
        state = as_array("x", x)
        count = len(self.signature.u)
        names = self.signature.states
        if state.ndim == 0 or state.shape[-1] != len(names):
            raise CompileError(length_problem("x", names, state.shape))
        return self(t, state[..., count:], state[..., :count], r, p)

    def bind(self, p: ArrayLike) -> Callable[..., Any]:
        """Return ``f(t, q, u, r=(), *, s=())`` with parameters fixed, and what depends on them computed."""
        values = checked_group("p", p, self.signature.names("p"))
        if values.ndim == 1:
            bound = CompiledFunction.from_code(
                self._code, replace(self.signature, p=()), self._all_parameters(values)
            )
            return partial(bound, p=())
        cached = self._constants(values)

        def evaluate_rest(
            t: ArrayLike, q: ArrayLike, u: ArrayLike, r: ArrayLike = (), *, s: ArrayLike = ()
        ) -> Any:
            q = self._with_signals(q, s) if self.signature.s else q
            now = {
                group: checked_group(group, x, self.signature.names(group))
                for group, x in zip("qur", (q, u, r), strict=True)
            }
            now |= {"t": checked_group("t", t, self.signature.names("t")), "p": values}
            batch = broadcast(now)
            return self._reshape_outputs(self._code.tail(now | {"c": cached}, batch), batch, None)

        return evaluate_rest

    @property
    def tail(self) -> Sequence:
        """What is computed at `address`: all but what depends on parameters alone."""
        return self._code.tail.sequence

    @property
    def address(self) -> int:
        """Address of ``int f(t, q, u, r, p, c, out, work)``, all pointers to double; see `constants`."""
        return self._code.tail.native.address

    @property
    def work_size(self) -> int:
        """Doubles of scratch that the function at `address` needs."""
        return self._code.tail.native.work_size

    def in_lanes(self) -> NativeFunction:
        """Return the same code for several points at once, for calls by address; the first call compiles."""
        return self._code.tail.in_lanes()

    @property
    def constant_count(self) -> int:
        """How many numbers `constants` returns."""
        return self._code.constant_count

    def constants(self, p: ArrayLike = _NO_PARAMETERS) -> Floats:
        """Return the values ``c`` that depend on parameters alone, for calls by address."""
        if p is _NO_PARAMETERS and not self.signature.p:
            return self.bound_constants
        return self._constants(checked_group("p", p, self.signature.names("p")))

    @property
    def operations(self) -> int:
        """Operations of one evaluation with parameters bound."""
        return self._code.tail.sequence.operation_count

    @property
    def inputs(self) -> tuple[str, ...]:
        """Names of all arguments: t, coordinates, speeds, inputs, free parameters, states of signals."""
        return self.signature.arguments

    @checked_arguments
    def source(self, language: str = "c") -> str:
        """Return the function as source text of another language; see `generate_code`."""
        if self._code.portable:
            groups = {group: self.signature.names(group) for group in "qurp"}
            return portable_text(self._code.sequence, language, groups)
        return source_text(self.sequence, language, self.signature)

    def __repr__(self) -> str:
        outputs = ", ".join(output.name for output in self.outputs)
        return f"CompiledFunction({outputs}): {self.operations} operations"

    def __reduce__(self) -> tuple[Callable[..., CompiledFunction], tuple[object, ...]]:
        code = self._code
        specialized = None if self._specialize is None else self.sequence
        choices = code.quick, code.lanes, code.portable
        return _remade, (code.sequence, self.signature, choices, self._values, specialized)

    def _made_direct(self) -> DirectCall:
        sizes = {group: size for group, size in self._sizes if group != "c"}
        if sizes["p"]:
            head, values = self._code.head, self._values
            return DirectCall(self._code.tail, sizes, self._result_shape, head=head, values=values)
        return DirectCall(self._code.tail, sizes, self._result_shape, constants=self.bound_constants)

    def _made_shared_direct(self) -> DirectCall:
        sizes = {**dict(self._sizes), "p": len(self.signature.p) + self._values.size}
        return DirectCall(self._code.tail, sizes, self._result_shape, head=self._code.head)

    @property
    def _result_shape(self) -> tuple[int, ...]:
        outputs = self.outputs
        return outputs[0].shape if len(outputs) == 1 else (self._code.tail.sequence.output_size,)

    def _taken_apart(self, flat: Floats) -> Any:
        """Return several outputs of one point, which lie one after the other."""
        results = split_outputs(self.outputs, flat)
        return self._result(*results) if self._result is not None else results[0]

    def _points(self, t: ArrayLike, *arguments: ArrayLike) -> tuple[float, list[Floats]] | None:
        """Return t, and q, u, r, p as arrays (n,) that native code reads; None if this is no single point."""
        if isinstance(t, float):  # also NumPy's
            time = float(t)
        else:
            instant = as_array("t", t)
            if instant.ndim or instant.dtype.char != "d":
                return None
            time = float(instant)
        points = []
        for (group, size), value in zip(self._sizes, arguments, strict=True):
            array = value if type(value) is np.ndarray else as_array(group, value)
            if array.shape != (size,) or (size and array.dtype.char != "d"):
                return None
            points.append(np.require(array, np.float64, ["A", "C"]))
        return time, points

    def _call_at_point(self, time: float, points: Items[Floats]) -> Floats:
        """Return the outputs at one point, one after the other.

        First calls go through a way that all functions with this code share. It pays to have one's own only
        where more follow.
        """
        self._calls += 1
        if self._calls > _FEW_CALLS and self._at_point is None:
            self._at_point = self._made.get("direct", self._made_direct).call
        p = self._all_parameters(points[3])
        direct = self._code.notes.get("direct", self._made_shared_direct).call
        result: Floats | None = None if direct is None else direct(time, *points[:3], p)
        if result is not None:
            return result.reshape(-1)
        q, u, r, _ = points
        return self._code.tail.at_point(t=np.array(time), q=q, u=u, r=r, c=self._code.constants(p))

    def _reshape_outputs(self, flat: Floats, batch: tuple[int, ...], out: Floats | None) -> Any:
        results = split_outputs(self.outputs, flat, batch)
        if self._result is not None:
            return self._result(*results)
        if out is None:
            return results[0]
        out[...] = results[0]
        return out


def _remade(
    sequence: Sequence,
    signature: Signature,
    choices: tuple[bool, bool | None, bool],
    values: Floats,
    specialized: Sequence | None,
) -> CompiledFunction:
    """Return a function from what was pickled of it."""
    quick, lanes, portable = choices
    specialize = None if specialized is None else partial(_itself, specialized)
    code = SharedCode(sequence, quick=quick, lanes=lanes, portable=portable)
    return CompiledFunction.from_code(code, signature, values, specialize)


def _itself(sequence: Sequence) -> Sequence:
    return sequence
