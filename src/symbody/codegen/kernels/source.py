"""A file in the kernel language: its name, its constants, and faults at its lines."""

from __future__ import annotations

import ast
from dataclasses import dataclass, field
from typing import NoReturn

from symbody.codegen.kernels.tree import Literal, Type, Variable
from symbody.errors import Problem, SymbodyError
from symbody.kernels.record_layout import RecordLayout


class KernelError(SymbodyError):
    """A file of `symbody.kernels` that is outside the kernel language."""


@dataclass(frozen=True, slots=True)
class KernelSource:
    """A file by name, and the constants and records defined so far."""

    file: str
    constants: dict[str, Literal | Variable] = field(default_factory=dict)
    records: dict[str, type[RecordLayout]] = field(default_factory=dict)

    def refuse(self, node: ast.AST, what: str, fix: str) -> NoReturn:
        """Raise for a place in the file."""
        line = getattr(node, "lineno", 0)
        raise KernelError(Problem("kernel.outside_language", f"{self.file}:{line}", what, "", fix))

    def define_constant(self, node: ast.AnnAssign) -> None:
        """Enter ``NAME: Final = number``."""
        if not isinstance(node.target, ast.Name) or node.value is None:
            self.refuse(node, "not a constant", "write NAME: Final = number")
        value = self._number(node.value)
        self.constants[node.target.id] = Literal(value, Type.INTEGER if isinstance(value, int) else Type.REAL)

    def _number(self, node: ast.expr) -> float | int:
        match node:
            case ast.Constant(value=int() | float() as value) if not isinstance(value, bool):
                return value
            case ast.Name(id=name) if isinstance(known := self.constants.get(name), Literal):
                return known.value
            case ast.UnaryOp(op=ast.USub(), operand=operand):
                return -self._number(operand)
            case ast.BinOp(left=left, op=operator, right=right):
                return self._fold(node, operator, self._number(left), self._number(right))
        self.refuse(node, "a constant is made of numbers", "write numbers and + - * / **")

    def _fold(self, node: ast.expr, operator: ast.operator, a: float, b: float) -> float | int:
        match operator:
            case ast.Add():
                return a + b
            case ast.Sub():
                return a - b
            case ast.Mult():
                return a * b
            case ast.Div():
                return a / b
            case ast.Pow():
                return float(a**b) if isinstance(a, float) or b < 0 else int(a**b)
        self.refuse(node, "a constant is made of numbers", "write numbers and + - * / **")
