"""`compile`: from equations and outputs asked for to functions.

The only file of this folder that imports EquationSet.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Final

from symbody.arguments import checked_arguments, named_after
from symbody.codegen.formation.bound_function import bound_function
from symbody.codegen.formation.names import Value, offer_argument
from symbody.codegen.formation.sequences import form_sequence
from symbody.codegen.function import CompiledFunction
from symbody.equations.equation_set import EquationSet
from symbody.errors import CompileError
from symbody.expr.deadline import in_time

_LESS: Final = "compile fewer outputs at a time, or compile faster with quick=True"


@named_after(3)
@checked_arguments
def compile(
    eqs: EquationSet,
    outputs: str | Iterable[str],
    parameters: Mapping[str, Value] | None = None,
    free: Iterable[str] = (),
    *,
    quick: bool = False,
    lanes: bool | None = None,
    specialize: bool = False,
    portable: bool = False,
    time_limit: float | None = None,
) -> CompiledFunction:
    """Return a native function ``f(t, q, u, r=(), p=(), *, s=(), out=None, threads=1)`` of the `outputs`.

    Parameters
    ----------
    eqs : EquationSet
        The equations of the mechanism.
    outputs : str or iterable of str
        Output names, for instance ``"udot"`` or ``["mass_matrix", "forcing"]``, or expressions. For
        ``"inverse_dynamics"`` the inputs are followed by the accelerations, ``eqs.acceleration_names``.
    parameters : mapping of name to number or formula
        Overrides values of the model; parameters that are formulas of others follow.
    free : iterable of str
        Parameters that stay arguments; they form p in this order.
    quick : bool
        Compile in less than half the time for calls that take 1.5 to 3 times as long; it pays below about
        100,000 evaluations. Results do not depend on it, nor on `lanes`.
    lanes : bool, optional
        Whether batches are computed several points at once. True compiles that at the first batch, None when
        300,000 points have been asked for, False never.
    specialize : bool
        Put the values of parameters into the code, for up to 15 % less time a call. By default they are
        arguments of it that the function keeps, so that functions with other values share the code: it is
        compiled once, and once more for each choice of parameters that are exactly 0.
    portable : bool
        Fuse no operation: ``source`` in "c", "javascript" and "python" then gives the same bits as this
        function, on every computer. Values of parameters are put into the code; there are no lanes.
    time_limit : float, optional
        Seconds after which this ends with an error that names the stage; outputs whose formulas were found
        stay with `eqs`, so that the next call continues from there. By default there is no limit.

    Returns
    -------
    CompiledFunction
        Called with t, q (n_q,) and u (n_u,) in the order of ``eqs.coordinate_names`` and ``eqs.speed_names``,
        the inputs r of ``eqs.inputs`` and the values p of `free`, in SI units. One output comes as an array
        of its own shape, several as a tuple of them; arguments (B, n) give results (B, ...).
        ``f.of_state(t, x, r, p)`` takes the states x = (u, q), as solvers do.

    Raises
    ------
    CompileError
        If parameters have no value, listing all of them, or names are unknown.
    TimeLimitError
        When time is up.

    Examples
    --------
    >>> import symbody as sb
    >>> rail = sb.Prismatic("rail", "ground", sb.Body("Cart", mass=2), axis="x", coordinate="x",
    ...                     force=sb.Drive(applied="F", stiffness=8))
    >>> model = sb.Model("oscillator", [rail], inputs=["F"], initial={"x": 0.1})
    >>> eqs = sb.form_equations(model)
    >>> f = sb.compile(eqs, "udot")
    >>> f(0.0, q=[0.1], u=[0.0], r=[2.0])
    array([0.6])
    >>> f.of_state(0.0, [0.0, 0.1], [2.0])
    array([0.6])
    """

    def make_function() -> CompiledFunction:
        try:
            if specialize or portable:
                formed = form_sequence(eqs, outputs, parameters, free)
                return CompiledFunction(*formed, quick=quick, lanes=lanes, portable=portable)
            return bound_function(eqs, outputs, parameters, free, quick=quick, lanes=lanes)
        except CompileError as error:
            raise CompileError(*map(offer_argument, error.problems)) from error

    return in_time(time_limit, "compiling", _LESS, make_function)
