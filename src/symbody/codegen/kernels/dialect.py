"""What a language has to define for kernels to be written in it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from enum import Enum
from typing import Final

from symbody.codegen.kernels.tree import KernelTree, Type

PREFIX: Final = "symbody_"  # of the names of all kernels

Names = Mapping[str, str]


def no_names(tree: KernelTree) -> Names:
    """Return no names: parameters and variables keep theirs."""
    return {}


class Arrays(Enum):
    """How a language refers to a part of an array."""

    POINTERS = "a part is a value, like an array: a pointer or a view"
    OFFSETS = "each array is passed with the index at which it begins"
    ADDRESSES = "an array is passed by the entry at which it begins; local parts are offsets"
    COPIES = "arrays are values: a kernel returns those that it changes; local parts are places in them"


@dataclass(frozen=True, slots=True)
class StatementFormats:
    """How one language writes statements.

    Attributes
    ----------
    assign, store, perform, returns, returns_nothing, leave : format
        With ``name``, ``value``, and of an entry ``array``, ``index``, ``next``.
    count, count_down, repeat, choose, choose_next : format
        First lines of compound statements; with ``name``, ``start``, ``stop``, ``last`` (the last value
        reached), ``condition``.
    otherwise, close, end : str
        Lines between both branches, behind a compound statement, behind a kernel; none if empty.
    close_loop : str
        Behind a loop, if that is not `close`.
    """

    assign: str
    store: str
    perform: str
    returns: str
    returns_nothing: str
    leave: str
    count: str
    count_down: str
    repeat: str
    choose: str
    choose_next: str
    otherwise: str
    close: str
    end: str
    close_loop: str = ""


# Of C, and of languages that write statements as C does.
BRACES: Final = StatementFormats(
    assign="{name} = {value};",
    store="{array}[{index}] = {value};",
    perform="{value};",
    returns="return {value};",
    returns_nothing="return;",
    leave="break;",
    count="for ({name} = {start}; {name} < {stop}; {name}++) {{",
    count_down="for ({name} = {start}; {name} > {stop}; {name}--) {{",
    repeat="while ({condition}) {{",
    choose="if ({condition}) {{",
    choose_next="}} else if ({condition}) {{",
    otherwise="} else {",
    close="}",
    end="}",
)


@dataclass(frozen=True, slots=True)
class KernelDialect:
    """How one language writes kernels.

    Attributes
    ----------
    literal : callable
        Text of a number.
    head : callable
        Lines before the body of a kernel, declarations among them; it takes the names in this language.
    operators : mapping of operator to text
        Of ``+ - * / < .. and or neg``; what is missing is written as in Python.
    words : mapping of word to format
        Of the words of the language, conversions and ``not``; ``"max int"`` is that for integers.
    arrays : Arrays
    entry, part : format
        With ``array``, ``index`` (counted from 0) and ``next`` (from 1); for `part` where it begins, and
        ``last`` (from 1).
    statements : StatementFormats
    helpers : mapping of word to text
        What a word, or a type of parameters, needs in front of the kernels, where one uses it.
    continuation : str
        Ends a line that goes on.
    result : str
        Name of the result, where arrays are copies.
    rename : callable
        Names in this language, of those parameters and variables that change theirs.
    """

    literal: Callable[[float | int, Type], str]
    head: Callable[[KernelTree, Names], Iterator[str]]
    operators: Mapping[str, str]
    words: Mapping[str, str]
    arrays: Arrays
    entry: str
    part: str
    statements: StatementFormats
    helpers: Mapping[str, str] = field(default_factory=dict)
    continuation: str = ""
    result: str = ""
    rename: Callable[[KernelTree], Mapping[str, str]] = no_names


def offset_name(array: str) -> str:
    """Return the name of the index at which an array begins."""
    return f"{array}_0"


def size_name(array: str) -> str:
    """Return the name of the number of entries of a part, where arrays are copies."""
    return f"{array}_n"
