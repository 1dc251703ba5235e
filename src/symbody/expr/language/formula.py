"""`Formula`: an expression parsed and kept outside any graph, as the Model holds it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction
from functools import lru_cache
from importlib import import_module
from numbers import Rational, Real
from typing import Final, TypeAlias

from symbody.arguments import is_sympy, register_sympy_writer
from symbody.errors import ExpressionError, Problem
from symbody.expr.canonical import constant
from symbody.expr.graph import Constant, Graph
from symbody.expr.language.caret import Source, printable
from symbody.expr.language.grammar import read_program
from symbody.expr.language.instructions import Instruction
from symbody.expr.language.literals import MAX_DIGITS, fold
from symbody.expr.language.lowering import applied_node
from symbody.expr.language.tokens import is_name, normalize

_OF_ANGLES: Final = frozenset({"sin", "cos", "tan"})


@dataclass(frozen=True, slots=True)
class Formula:
    """An expression as text and as postfix program; hashable, and free of any graph.

    Made by `parse` or `Formula.of`, not by hand: the program is made from the text.

    Attributes
    ----------
    text : str
        As written, up to `symbody.expr.language.tokens.normalize`.
    program : tuple of Instruction
        Steps of a stack machine that leave one number.
    """

    text: str
    program: tuple[Instruction, ...]

    @classmethod
    def from_value(cls, value: FormulaLike, *, where: str = "", has_outputs: bool = False) -> Formula:
        """Return `value` as a formula: text is parsed, a number becomes its decimal text.

        A float has the value of its shortest text: up to 15 digits it is that exact decimal, as if it
        stood in a file; with 16 or 17 it stays a float. Where `has_outputs`, names in single quotes are
        outputs: ``'reaction A Fx' / m``.

        Raises
        ------
        ExpressionError
            For text that is not an expression, for bool, complex, NaN, infinity and other objects.
        """
        if isinstance(value, Formula):
            return value
        text = normalize(value if isinstance(value, str) else _numeral(value, where))
        if where or has_outputs:
            return cls(text, read_program(Source(text, where, has_outputs)))
        return _plain(text)

    def __str__(self) -> str:
        return self.text

    def __float__(self) -> float:
        """Return the number that this is; pi is the only name that may stand in it.

        Raises
        ------
        ExpressionError
            If other names or outputs stand in it, it divides by zero, or it is too large.
        """
        plain = self.constant()
        if plain is not None:
            return float(plain)
        others = [name for name in (*self.names, *self.outputs) if name != "pi"]
        if others:
            what = f"{self.text!r} is no number, because {', '.join(others)} may have any value"
            fix = "model.values() has the values of all parameters of a model"
            raise ExpressionError(Problem("expression.not_one_number", "float", what, "", fix))
        graph = Graph()
        root = build(self, graph, lambda name, column: graph.pi())
        exact = graph.number(root)
        if exact is not None:
            return float(exact)
        # Loaded where it is needed: few formulas are evaluated alone.
        value: float = import_module("symbody.expr.sequences.evaluate").value_of(graph, root)
        return value

    @property
    def names(self) -> tuple[str, ...]:
        """Distinct names, in the order of their first appearance."""
        return tuple(dict.fromkeys(str(step.payload) for step in self.program if step.kind == "name"))

    @property
    def outputs(self) -> tuple[str, ...]:
        """Distinct outputs that stand in quotes, in the order of their first appearance."""
        return tuple(dict.fromkeys(str(step.payload) for step in self.program if step.kind == "output"))

    @property
    def is_in_degrees(self) -> bool:
        """Whether this is an angle in degrees without a symbol: ``"30 deg"``, ``"pi + 2 deg"``."""
        if "deg" not in self.text or {*self.names} != {"pi"} or self.outputs:
            return False
        angles: list[bool] = []
        for step in self.program:
            if step.kind != "apply":
                angles.append(step.kind == "name" and not self.text.startswith("pi", step.column - 1))
            else:
                operands = angles[-step.arity :]
                del angles[-step.arity :]
                angles.append(any(operands) and step.payload not in _OF_ANGLES)
        return angles[0]

    @property
    def is_number(self) -> bool:
        """Whether this is a plain number, a sign or a quotient of two included."""
        return self.constant() is not None

    def constant(self) -> Constant | None:
        """Return the value of a plain number (a sign or a quotient included), else None."""
        values: list[Constant] = []
        for step in self.program:
            if step.kind in ("name", "output") or (
                step.kind == "apply" and step.payload not in ("neg", "div")
            ):
                return None
            if isinstance(step.payload, str):
                operands = values[-step.arity :]
                del values[-step.arity :]
                result = fold(step.payload, *operands)
                if result is None:
                    return None
                values.append(result)
            else:
                values.append(step.payload)
        return values[0]

    def rename(self, mapping: Mapping[str, str], outputs: Mapping[str, str] | None = None) -> Formula:
        """Return this with names replaced, all at once, in text and program; `outputs` are those in quotes.

        Raises
        ------
        ExpressionError
            If a new name cannot be written in an expression.
        """
        pieces: list[str] = []
        end = 0
        for step in self.program:
            old = str(step.payload)
            start = step.column - 1
            # The pi of an angle such as "30 deg" is not written as a name, and stays.
            if step.kind == "name" and old in mapping and self.text.startswith(old, start):
                pieces += (self.text[end:start], _name(mapping[old]))
                end = start + len(old)
            elif step.kind == "output" and outputs:
                pieces += (self.text[end:start], f"'{outputs.get(old, old)}'")
                end = start + len(old) + 2
        if not pieces:
            return self
        return type(self).from_value("".join((*pieces, self.text[end:])), has_outputs=bool(self.outputs))

    def problem(
        self, code: str, column: int, what: str, why: str = "", fix: str = "", where: str = ""
    ) -> Problem:
        """Return a problem with the text and a caret at `column`; for look-ups that find nothing."""
        return Source(self.text, where).problem(code, column, what, why, fix)


@lru_cache(maxsize=4096)
def _plain(text: str) -> Formula:
    """Return a formula; one that is read again, as names of coordinates are, is that of before."""
    return Formula(text, read_program(Source(text, "", False)))


# SymPy expressions, whose types are not known here, are taken too.
FormulaLike: TypeAlias = Formula | str | int | Fraction | float | Decimal


def build(
    formula: Formula,
    graph: Graph,
    lookup: Callable[[str, int], int],
    *,
    where: str = "",
    outputs: Callable[[str, int], int] | None = None,
) -> int:
    """Return the node of a formula in `graph`.

    Parameters
    ----------
    lookup : callable
        Takes a name and the column of its first appearance, returns a node of `graph`; called once
        for each name. ``pi`` and ``t`` are predefined; unknown names raise.
    where : str
        Object path for faults that only show once the names have values.
    outputs : callable, optional
        The same for names in quotes; by default `lookup`.

    Raises
    ------
    ExpressionError
        At a division by something that turns out to be zero.
    """
    nodes: dict[tuple[str, str], int] = {}
    look_up = {"name": lookup, "output": outputs or lookup}
    stack: list[int | ExpressionError] = []
    for step in formula.program:
        if not isinstance(step.payload, str):
            stack.append(constant(graph, step.payload))
        elif step.kind in look_up:
            name = step.kind, step.payload
            if name not in nodes:
                nodes[name] = look_up[step.kind](step.payload, step.column)
            stack.append(nodes[name])
        else:
            operands = stack[-step.arity :]
            del stack[-step.arity :]
            stack.append(_apply_step(formula, graph, step, operands, where))
    if isinstance(stack[0], ExpressionError):
        raise stack[0]
    return stack[0]


def _apply_step(
    formula: Formula, graph: Graph, step: Instruction, operands: list[int | ExpressionError], where: str
) -> int | ExpressionError:
    """Return the node of an operation, or what is wrong; a branch that is never taken may be wrong."""
    name, nodes = str(step.payload), [operand for operand in operands if isinstance(operand, int)]
    if name == "if" and isinstance(operands[0], int) and (decided := graph.number(operands[0])) is not None:
        return operands[1] if decided else operands[2]
    if len(nodes) < len(operands):
        return next(operand for operand in operands if isinstance(operand, ExpressionError))
    try:
        return applied_node(graph, name, nodes)
    except ExpressionError as error:  # the graph has the fault, the formula has the text
        problems = [
            formula.problem(p.code, step.column, p.what, p.why, p.fix, where=where) for p in error.problems
        ]
        return ExpressionError(*problems)


def _numeral(value: object, where: str) -> str:
    """Return the text of a number or of a SymPy expression, or raise."""
    why, fix = (
        "only finite real numbers and text can be expressions",
        "give a number, or the expression as text",
    )
    # NumPy and others register their numbers with the abstract classes; bool is an int by accident.
    if isinstance(value, Rational) and not isinstance(value, bool):
        exact = Fraction(int(value.numerator), int(value.denominator))
        if max(exact.numerator.bit_length(), exact.denominator.bit_length()) <= 4 * MAX_DIGITS:
            return str(exact)
        what = f"the number has more than {MAX_DIGITS} digits"
        raise ExpressionError(
            Problem("expression.number", where, what, "it exceeds what computers can represent", fix)
        )
    if isinstance(value, Real) and not isinstance(value, bool):
        value = float(value)
    if isinstance(value, float | Decimal):
        if Decimal(value).is_finite():
            return str(value)
        raise ExpressionError(
            Problem("expression.not_finite", where, f"{value} is not a finite number", why, fix)
        )
    if is_sympy(value):
        text = _write_sympy(value, where)
        return text
    what = f"{printable(repr(value))} of type {type(value).__name__} is not an expression"
    raise ExpressionError(Problem("expression.type", where, what, why, fix))


def _name(text: str) -> str:
    name = normalize(text)
    if is_name(name):
        return name
    raise ExpressionError(
        Problem(
            "expression.name",
            "",
            f"'{printable(text)}' cannot be written as a name in an expression",
            "names have letters, digits and _, begin with no digit, and are not if, and, or, not",
            "choose another name",
        )
    )


def _write_sympy(value: object, where: str = "") -> str:
    """Return a SymPy expression as text; SymPy is loaded by then, the reader only now."""
    text: str = import_module("symbody.expr.sympy.sympy_text").sympy_text(value, where)
    return text


register_sympy_writer(_write_sympy)
