"""Tokens to a postfix program, by operator precedence and without recursion.

Precedence is Python's: ``or``, ``and``, ``not``, comparisons, ``+ -``, ``* /``, signs, ``**``
(which groups to the right). ``deg`` behind a number binds most tightly: it is a part of the number. Faults
from which reading can go on are collected.
"""

from __future__ import annotations

from types import MappingProxyType
from typing import Final, NamedTuple, NoReturn

from symbody.errors import ExpressionError, Problem
from symbody.expr.language.caret import Source
from symbody.expr.language.checks import Value, check_operation, condition_problem
from symbody.expr.language.instructions import FOLDED, FUNCTIONS, Instruction
from symbody.expr.language.literals import read_number
from symbody.expr.language.syntax import (
    adjacent_problem,
    arguments_problem,
    comma_problem,
    is_decimal_comma,
    missing_problem,
    unknown_function_problem,
)
from symbody.expr.language.tokens import MAX_PROBLEMS, Token, tokenize

MAX_NESTING: Final = 200

_BINARY: Final = MappingProxyType(
    {
        "or": ("or", 1), "and": ("and", 2), "<": ("lt", 4), "<=": ("le", 4), ">": ("gt", 4), ">=": ("ge", 4),
        "==": ("eq", 4), "!=": ("ne", 4), "+": ("add", 5), "-": ("sub", 5), "*": ("mul", 6), "/": ("div", 6),
        "**": ("power", 8),
    }
)  # fmt: skip
_PREFIX: Final = MappingProxyType({"not": ("not", 3), "-": ("neg", 7), "+": ("pos", 7)})
_UNARY: Final = frozenset({"not", "neg", "pos"})
_LOWEST: Final = 1
_BRACKET: Final = 0


class _Pending(NamedTuple):
    """An operator or an open bracket that waits for what follows it."""

    name: str  # operation; function before the bracket; "" for a bare bracket
    precedence: int
    column: int  # of the operator or function
    opening: int = 0  # of a bracket: its own column
    base: int = 0  # of a bracket: number of values before it


def read_program(source: Source) -> tuple[Instruction, ...]:
    """Return the program of a text, which must be normalized.

    Raises
    ------
    ExpressionError
        With all problems found.
    """
    return _TokenReader(source).read_tokens()


class _TokenReader:
    """Reads one text; made for it and dropped."""

    __slots__ = (
        "_brackets",
        "_callee",
        "_foreign",
        "_pending",
        "_problems",
        "_program",
        "_source",
        "_tokens",
        "_values",
    )

    def __init__(self, source: Source) -> None:
        self._source = source
        self._tokens, self._foreign = tokenize(source)
        self._problems: list[Problem] = []
        self._program: list[Instruction] = []
        self._values: list[Value] = []  # what is known of each value on the machine's stack
        self._pending: list[_Pending] = []
        self._brackets: list[int] = []  # places of the open brackets in _pending
        self._callee: Token | None = None  # a function whose bracket comes next

    def read_tokens(self) -> tuple[Instruction, ...]:
        tokens = self._tokens
        wants_operand = True
        for k, token in enumerate(tokens):
            if token.kind == "bad":
                self._stop()
            following = tokens[min(k + 1, len(tokens) - 1)]
            if wants_operand:
                wants_operand = self._operand(token, following)
            else:
                wants_operand = self._operator(tokens[k - 1], token, following)
        for fault in self._values[-1].faults:
            self._report(fault)
        if self._problems:
            self._stop()
        if self._values[-1].is_condition:
            self._stop(condition_problem(self._source, self._values[-1].column))
        return tuple(self._program)

    def _operand(self, token: Token, following: Token) -> bool:
        """Take a token where an operand must begin; return whether one must still begin."""
        if token.kind == "number":
            self._number(token)
        elif token.text == "(":
            self._open(token)
            return True
        elif (token.kind == "name" or token.text == "if") and following.text == "(":
            self._callee = token
            return True
        elif token.kind in ("name", "output"):
            self._push(Instruction(token.kind, token.text, token.start + 1), Value(token.start + 1))
        elif token.text in _PREFIX:
            self._wait(*_PREFIX[token.text], token)
            return True
        else:
            self._stop(missing_problem(self._source, token, self._call_before(token)))
        return False

    def _operator(self, previous: Token, token: Token, following: Token) -> bool:
        """Take a token after an operand; return whether an operand must begin after it."""
        if token.text in _BINARY:
            name, precedence = _BINARY[token.text]
            self._reduce(precedence + (name == "power"))
            self._wait(name, precedence, token)
            return True
        if token.text == ")":
            self._close(token)
            return False
        if token.text == ",":
            self._comma(previous, token, following)
            return True
        if token.kind == "end":
            self._end()
            return False
        if token.text == "deg" and previous.kind == "number":
            self._convert_degrees(token)
            return False
        self._report(adjacent_problem(self._source, previous, token, following))
        if token.kind == "operator" and token.text != "(":
            self._stop()  # a keyword: what follows it is another language
        self._reduce(_BINARY["*"][1])
        self._wait(*_BINARY["*"], token)
        return self._operand(token, following)

    def _number(self, token: Token) -> None:
        column = token.start + 1
        try:
            value = read_number(token.text)
        except OverflowError as fault:
            why, fix = (
                "a typo, or an unsuitable unit",
                "correct the digits or the exponent, or choose another unit",
            )
            self._report(self._source.problem("expression.number", column, str(fault), why, fix))
            value = 1
        self._push(Instruction("number", value, column), Value(column, False, value))

    def _convert_degrees(self, token: Token) -> None:
        """Multiply the number before ``deg`` by pi/180."""
        column = token.start + 1
        self._push(Instruction("name", "pi", column), Value(column))
        self._apply("mul", column, 2)
        self._push(Instruction("number", 180, column), Value(column, False, 180))
        self._apply("div", column, 2)

    def _open(self, token: Token) -> None:
        name, column = "", token.start + 1
        if self._callee is not None:
            name, column = self._callee.text, self._callee.start + 1
            if name not in FUNCTIONS:
                self._report(unknown_function_problem(self._source, self._callee))
            self._callee = None
        self._brackets.append(len(self._pending))
        self._pending.append(_Pending(name, _BRACKET, column, token.start + 1, len(self._values)))
        self._check_nesting(len(self._brackets), "brackets", token)

    def _close(self, token: Token) -> None:
        self._reduce(_LOWEST)
        if not self._brackets:
            fix = "delete it, or add an opening bracket before it"
            self._report(
                self._source.problem(
                    "expression.bracket",
                    token.start + 1,
                    "this closing bracket has no opening bracket",
                    "a '(' is missing",
                    fix,
                )
            )
            return
        self._brackets.pop()
        bracket = self._pending.pop()
        if bracket.name:
            self._call(bracket)

    def _call(self, bracket: _Pending) -> None:
        """Apply a function to the values that came since its bracket opened."""
        name, column, count = bracket.name, bracket.column, len(self._values) - bracket.base
        problem = arguments_problem(self._source, name, column, count)
        if problem is not None:
            self._report(problem)
        if problem is not None or name not in FUNCTIONS:
            faults = tuple(fault for value in self._values[bracket.base :] for fault in value.faults)
            self._values[bracket.base :] = [Value(column, faults=faults)]
        elif name in FOLDED:
            for _ in range(count - 1):
                self._apply(name, column, 2)
        else:
            self._apply(name, column, count)

    def _comma(self, previous: Token, token: Token, following: Token) -> None:
        self._reduce(_LOWEST)
        name = self._pending[-1].name if self._pending else ""
        is_decimal = is_decimal_comma(previous, token, following)
        if name and not (is_decimal and FUNCTIONS.get(name) == (1, 1)):
            return
        self._report(comma_problem(self._source, previous, token, following))
        self._wait(*_BINARY["+"], token)  # read on as if the two were one number

    def _end(self) -> None:
        self._reduce(_LOWEST)
        if self._brackets:
            column = self._pending[self._brackets[-1]].opening
            what = "this bracket is never closed"
            self._stop(
                self._source.problem(
                    "expression.bracket", column, what, "a ')' is missing", "close it with )"
                )
            )

    def _reduce(self, precedence: int) -> None:
        """Apply the waiting operators that bind at least as strongly as `precedence`."""
        while self._pending and self._pending[-1].precedence >= precedence:
            name, _, column, *_ = self._pending.pop()
            self._apply(name, column, 1 if name in _UNARY else 2)

    def _apply(self, name: str, column: int, arity: int) -> None:
        operands = self._values[-arity:]
        del self._values[-arity:]
        value, problem = check_operation(self._source, name, column, operands)
        if problem is not None:
            self._report(problem)
        self._values.append(value)
        if name != "pos":
            self._program.append(Instruction("apply", name, column, arity))

    def _push(self, instruction: Instruction, value: Value) -> None:
        self._program.append(instruction)
        self._values.append(value)

    def _wait(self, name: str, precedence: int, token: Token) -> None:
        self._pending.append(_Pending(name, precedence, token.start + 1))
        run = len(self._pending) - (self._brackets[-1] + 1 if self._brackets else 0)
        self._check_nesting(run, "signs or powers in a row", token)

    def _check_nesting(self, depth: int, what: str, token: Token) -> None:
        if depth > MAX_NESTING:
            self._stop(
                self._source.problem(
                    "expression.nesting",
                    token.start + 1,
                    f"there are more than {MAX_NESTING} {what} inside each other",
                    "the expression was probably generated by a program",
                    "define inner parts as parameters and use their names",
                )
            )

    def _call_before(self, token: Token) -> str:
        """Return the function whose bracket `token` follows at once, or ``""``."""
        last = self._pending[-1] if self._pending else None
        return last.name if last is not None and last.precedence == _BRACKET else ""

    def _report(self, problem: Problem) -> None:
        self._problems.append(problem)
        if len(self._problems) >= MAX_PROBLEMS:
            self._stop()

    def _stop(self, *last: Problem) -> NoReturn:
        raise ExpressionError(*self._problems, *last, *self._foreign)
