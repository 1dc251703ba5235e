"""`generate_code`: equations as source text of any language."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from symbody.arguments import checked_arguments, named_after
from symbody.codegen.formation.names import Value
from symbody.codegen.formation.sequences import form_sequence
from symbody.codegen.signature import source_text
from symbody.equations.equation_set import EquationSet
from symbody.simulation.programs.modelica_model import modelica_model


@named_after(3)
@checked_arguments
def generate_code(
    eqs: EquationSet,
    outputs: str | Iterable[str],
    language: str = "c",
    parameters: Mapping[str, Value] | None = None,
) -> str:
    """Return source text that computes the `outputs`.

    Parameters
    ----------
    eqs : EquationSet
        The equations of the mechanism.
    outputs : str or iterable of str
        Names of outputs, or expressions in them, as for `compile`; ``eqs.outputs()`` lists the names.
    language : str
        "c" for C99, "python" for a module that needs NumPy alone, "fortran" for Fortran 2008, "matlab"
        (or "octave"), "julia", "rust", "javascript" for an ES module, "jax", "casadi", or "modelica" for a
        model with states and their derivatives, of which the outputs may be none; each text explains itself
        at its head.
    parameters : mapping, optional
        Values to put in; an empty mapping puts in those of the model, None leaves every parameter an
        argument, in the order of ``eqs.parameters``.

    Returns
    -------
    str
        The text of one file with a function ``f`` of time, coordinates q, speeds u, inputs r and parameters
        p, in the orders of ``eqs.coordinate_names``, ``eqs.speed_names``, ``eqs.input_names`` and
        ``eqs.parameter_names``.

    Raises
    ------
    CompileError
        If the language or an output is unknown, or parameters have no value.
    UsageError, AssemblyError
        If a motion is not a Modelica model, or has no first state.

    Examples
    --------
    >>> import symbody as sb
    >>> rail = sb.Prismatic("rail", "ground", sb.Body("Cart", mass=2), axis="x", coordinate="x",
    ...                     force=sb.Drive(applied="F", stiffness=8))
    >>> model = sb.Model("oscillator", [rail], inputs=["F"], initial={"x": 0.1})
    >>> eqs = sb.form_equations(model)
    >>> text = sb.generate_code(eqs, "udot", language="python")
    >>> [line for line in text.splitlines() if line.startswith("def f")]
    ['def f(t, q, u, r=(), p=()):']
    """
    if isinstance(language, str) and language.lower() == "modelica":
        return modelica_model(eqs, (outputs,) if isinstance(outputs, str) else tuple(outputs), parameters)
    free = eqs.parameter_names if parameters is None else ()
    sequence, signature = form_sequence(eqs, outputs, parameters or {}, free)
    return source_text(sequence, language, signature)
