"""What calls of compiled functions are given: as arrays of floats, or refused with its name."""

from __future__ import annotations

from collections.abc import Mapping
from collections.abc import Sequence as Items
from ctypes import addressof, c_char
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from symbody.errors import CompileError, Problem
from symbody.expr.sequences.sequence import Output

Floats = NDArray[np.float64]
WORDS: Final = {
    "q": "coordinates", "u": "speeds", "r": "inputs", "p": "parameters", "t": "time", "x": "states",
    "s": "states of signals",
}  # fmt: skip


def address(array: Floats) -> int:
    """Return where the numbers of an array lie."""
    if array.size and array.flags.writeable and array.flags.c_contiguous:
        return addressof(c_char.from_buffer(array.data))  # in a seventh of the time of ``array.ctypes.data``
    return array.ctypes.data


def as_array(group: str, value: ArrayLike) -> NDArray[Any]:
    """Return the numbers of a group as an array of any type.

    Raises
    ------
    CompileError
        If they make none.
    """
    try:
        return np.asarray(value)
    except (TypeError, ValueError, OverflowError) as error:  # lists of lists of different lengths
        raise CompileError(_type_problem(group, type(value).__name__)) from error


def _type_problem(group: str, kind: str) -> Problem:
    return Problem(
        "compile.argument_type", group, f"{WORDS[group]} are of type {kind}",
        "only arrays of real numbers are accepted", "give floats",
    )  # fmt: skip


def checked_threads(threads: int) -> int:
    """Return a number of threads.

    Raises
    ------
    CompileError
        If it is none.
    """
    if isinstance(threads, bool) or not isinstance(threads, int) or threads < 1:
        raise CompileError(
            Problem("compile.threads", "threads", f"{threads!r} is not a valid number of threads", "",
                    "give a whole number, 1 or greater, such as os.cpu_count()")
        )  # fmt: skip
    return threads


def checked_group(group: str, value: ArrayLike, names: tuple[str, ...]) -> Floats:
    """Return the numbers of a group as floats (..., n); of "t" also without the last axis.

    Raises
    ------
    CompileError
        If their number or type is wrong.
    """
    given = as_array(group, value)
    given = given[..., np.newaxis] if group == "t" else given
    if given.ndim == 0 or given.shape[-1] != len(names):
        raise CompileError(length_problem(group, names, given.shape))
    if given.size and given.dtype.kind not in "fiu":
        raise CompileError(_type_problem(group, str(given.dtype)))
    return np.require(given, np.float64, "A")


def with_signals(q: ArrayLike, s: ArrayLike, names: Items[tuple[str, ...]], *, reads_s: bool) -> Floats:
    """Return coordinates with the states of signals behind them, as native code reads them.

    Parameters
    ----------
    q : (..., n_q) or (..., n_q + n_s) array
        In the second case s is empty.
    s : (..., n_s) array
        Empty also where the function reads none of it.
    names : pair of tuple of str
        Of coordinates and of states.

    Raises
    ------
    CompileError
        If a number of values is wrong.
    """
    coordinates, states = names
    given, s = as_array("q", q), as_array("s", s)
    size = given.shape[-1] if given.ndim else -1
    if s.size == 0 and size == len(coordinates) + len(states):
        return checked_group("q", given, (*coordinates, *states))
    positions = checked_group("q", given, coordinates)
    if s.size == 0 and not reads_s:
        values = np.zeros(len(states))
    else:
        values = checked_group("s", s, states)
    batch = broadcast({"q": positions, "s": values})
    parts = [np.broadcast_to(part, (*batch, part.shape[-1])) for part in (positions, values)]
    return np.concatenate(parts, axis=-1)


def broadcast(given: Mapping[str, Floats]) -> tuple[int, ...]:
    """Return the batch axes of all groups together.

    Raises
    ------
    CompileError
        If they do not fit each other.
    """
    shapes = {shape for values in given.values() if (shape := values.shape[:-1])}
    if len(shapes) == 1:  # most batches
        return shapes.pop()
    try:
        return np.broadcast_shapes(*(values.shape[:-1] for values in given.values()))
    except ValueError as error:
        listed = ", ".join(f"{group} {values.shape}" for group, values in given.items() if values.size)
        raise CompileError(
            Problem("compile.batch_shapes", "", f"batch axes cannot be broadcast: {listed}", str(error),
                    "give leading axes of equal length, or of length 1")
        ) from error  # fmt: skip


def length_problem(group: str, names: tuple[str, ...], shape: tuple[int, ...]) -> Problem:
    """Return what to say about a wrong number of values."""
    listed = ", ".join(names) or "none"
    return Problem(
        "compile.argument_length", group,
        f"{WORDS[group]} have shape {shape}, but {len(names)} numbers are expected on the last axis", "",
        f"the order is ({listed})",
    )  # fmt: skip


def check_out(out: object, batch: tuple[int, ...], outputs: Items[Output]) -> None:
    """Refuse what cannot receive the result of a batch as it is.

    Raises
    ------
    CompileError
        Saying why it cannot.
    """
    if out is None:
        return
    fitting = "remove out=" if len(outputs) > 1 else f"give np.empty({batch + outputs[0].shape})"
    if len(outputs) > 1:
        what = f"there are {len(outputs)} results, and one array to receive them"
    elif not isinstance(out, np.ndarray):
        what = f"{type(out).__name__} is not an array"
    elif out.dtype != np.float64 or not out.dtype.isnative:
        what = f"its entries are of type {out.dtype}, not float64"
    elif out.shape != batch + outputs[0].shape:
        what = f"its shape is {out.shape}, that of the result {batch + outputs[0].shape}"
    elif not (out.flags.c_contiguous and out.flags.aligned and out.flags.writeable):
        what = "it is not contiguous, or not writeable"
    else:
        return
    raise CompileError(Problem("compile.out", "out", what, "", fitting))
