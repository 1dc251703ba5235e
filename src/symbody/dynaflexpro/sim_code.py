"""`BuildSimCode`: from a built model to the function or the source text that simulates it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from symbody.codegen.formation.names import Value
from symbody.codegen.formation.sequences import form_sequence
from symbody.codegen.function import CompiledFunction
from symbody.codegen.signature import source_text
from symbody.dynaflexpro.exports import ModelEquations
from symbody.errors import Problem, UsageError, nearest
from symbody.expr.sympy.sympy_writer import SympyEquation

# DynaFlexPro's languages; what is not a procedure of this process is source text.
_PROCEDURES: Final = ("PythonProc", "MapleProc")
_TEXTS: Final = {"C": "c", "Python": "python"}
_OPTIMIZE: Final = ("", "Optimize")

Procedure = Callable[..., NDArray[np.float64]]


def BuildSimCode(
    model: ModelEquations,
    outputs: Iterable[str],
    language: str = "PythonProc",
    optimize: str = "Optimize",
    parameters: Mapping[Any, Value] | Iterable[SympyEquation] = (),
) -> Procedure | str:
    """Return a function that computes the outputs, or its source text.

    Parameters
    ----------
    outputs : iterable of str
        ``{"Xdot"}``, or names that `compile` knows.
    language : str
        "PythonProc", called "MapleProc" in Maple: a compiled function ``pXdot(t, X, r=None)`` of the time
        and the states (speeds, then coordinates), for instance for ``solve_ivp``; inputs not given are 0.
        "C" or "Python": source text.
    optimize : str
        "Optimize" or "": common subexpressions are shared in any case.
    parameters : mapping or equations
        Values of parameters and inputs, ``{"m": 1, "F": "sin(t)"}`` or ``[Eq(m, 1)]``; they override the
        model's.

    Raises
    ------
    UsageError
        If a language or an option is unknown.
    CompileError
        If a parameter has no value, or a name is unknown.
    """
    _check(language, optimize)
    eqs = model.equations
    pairs = parameters.items() if isinstance(parameters, Mapping) else [item.args for item in parameters]
    given = {str(name).removesuffix("(t)"): _value(value) for name, value in pairs}
    inputs = {name: value for name, value in given.items() if name in eqs.input_names}
    values = {name: value for name, value in given.items() if name not in inputs}
    names_given = [outputs] if isinstance(outputs, str) else list(outputs)
    names = ["xdot" if name == "Xdot" else name for name in names_given]
    sequence, signature = form_sequence(eqs, names, values, (), inputs)
    if language in _TEXTS:
        return source_text(sequence, _TEXTS[language])
    function = CompiledFunction(sequence, signature)
    silent = np.zeros(len(signature.r))

    def procedure(t: ArrayLike, X: ArrayLike, r: ArrayLike | None = None) -> Any:
        return function.of_state(t, X, silent if r is None else r)

    procedure.__name__ = procedure.__qualname__ = f"p{names_given[0]}" if len(names_given) == 1 else "p"
    return procedure


def _value(value: Any) -> Value:
    return value if isinstance(value, int | float) else str(value)


def _check(language: str, optimize: str) -> None:
    problems = []
    if language not in (*_PROCEDURES, *_TEXTS):
        cure = nearest(language, (*_PROCEDURES, *_TEXTS))
        problems.append(
            Problem("dynaflexpro.language", "language", f"there is no language {language!r}", "", cure)
        )
    if optimize not in _OPTIMIZE:
        cure = nearest(optimize, _OPTIMIZE[1:])
        problems.append(Problem("dynaflexpro.optimize", "optimize", f"there is no {optimize!r}", "", cure))
    if problems:
        raise UsageError(*problems)
