"""Outputs by name: the roots behind every word that compile, generate_code and results accept."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Final

from symbody.equations.formed import Formed
from symbody.equations.linear_solve import solve_positive_definite
from symbody.errors import ExpressionError, FormulationError, Problem, nearest
from symbody.expr.expression import Expr
from symbody.expr.language.formula import Formula
from symbody.expr.sequence import Roots


def output_roots(formed: Formed, name: str) -> Roots:
    """Return the roots of the output `name`.

    Reserved words come first, then "effort J", then symbols and expressions in them; parentheses
    reach a symbol that bears a reserved word's name.

    Raises
    ------
    FormulationError
        If the name means nothing, with the nearest names.
    """
    maker = _MAKERS.get(name)
    if maker is not None:
        return maker(formed)
    if name.startswith("effort "):
        return _effort(formed, name)
    try:
        formula = Formula.of(name)
        return _roots(name, (), [formed.names.expression(formula)])
    except (ExpressionError, FormulationError) as error:
        words = [*output_names(formed), *formed.names.symbols]
        raise FormulationError(
            Problem("equations.unknown_output", name, f"{name!r} is neither an output nor an expression",
                    error.problems[0].what, nearest(name, words))
        ) from error  # fmt: skip


def output_names(formed: Formed) -> tuple[str, ...]:
    """Return the reserved output names of these equations."""
    return (*_MAKERS, *(f"effort {joint}" for joint in formed.efforts))


def _effort(formed: Formed, name: str) -> Roots:
    joint = name.removeprefix("effort ").strip('" ')
    if joint not in formed.efforts:
        raise FormulationError(
            Problem("equations.unknown_effort", name, f"there is no driven joint coordinate {joint!r}", "",
                    nearest(joint, formed.efforts))
        )  # fmt: skip
    return _roots(name, (), [formed.efforts[joint]])


def _udot(formed: Formed) -> list[Expr]:
    return solve_positive_definite(formed.projection.mass_matrix, formed.projection.forcing)


def _qdot(formed: Formed) -> list[Expr]:
    rates = formed.kinematics.rates
    return [Expr(formed.graph, rates[q.index]) for q in formed.expressions(formed.q)]


def _roots(name: str, shape: tuple[int, ...], values: Sequence[Expr]) -> Roots:
    return Roots(name, shape, tuple(value.index for value in values))


def _vector(name: str, compute: Callable[[Formed], Sequence[Expr]]) -> Callable[[Formed], Roots]:
    def make(formed: Formed) -> Roots:
        values = compute(formed)
        return _roots(name, (len(values),), values)

    return make


def _scalar(name: str, compute: Callable[[Formed], Expr]) -> Callable[[Formed], Roots]:
    return lambda formed: _roots(name, (), [compute(formed)])


def _matrix(name: str, compute: Callable[[Formed], Sequence[Sequence[Expr]]]) -> Callable[[Formed], Roots]:
    def make(formed: Formed) -> Roots:
        rows = compute(formed)
        return _roots(name, (len(rows), len(formed.u)), [entry for row in rows for entry in row])

    return make


# Of a tree without constraints the last six are empty, but they exist, with their shapes.
_MAKERS: Final[dict[str, Callable[[Formed], Roots]]] = {
    "udot": _vector("udot", _udot),
    "qdot": _vector("qdot", _qdot),
    "xdot": _vector("xdot", lambda formed: [*_udot(formed), *_qdot(formed)]),
    "mass_matrix": _matrix("mass_matrix", lambda formed: formed.projection.mass_matrix),
    "forcing": _vector("forcing", lambda formed: formed.projection.forcing),
    "kinetic_energy": _scalar("kinetic_energy", lambda formed: formed.kinetic_energy),
    "potential_energy": _scalar("potential_energy", lambda formed: formed.potential_energy),
    "energy": _scalar("energy", lambda formed: formed.kinetic_energy + formed.potential_energy),
    "power": _scalar("power", lambda formed: formed.power),
    "lambda": _vector("lambda", lambda formed: []),
    "constraints": _vector("constraints", lambda formed: []),
    "velocity_constraints": _vector("velocity_constraints", lambda formed: []),
    "gamma": _vector("gamma", lambda formed: []),
    "jacobian": _matrix("jacobian", lambda formed: []),
}
