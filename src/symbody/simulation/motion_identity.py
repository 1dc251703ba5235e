"""`motion_digest`: what a motion follows from, as a hash; stores and saved states serve no other motion."""

from __future__ import annotations

import platform
import sys
from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass
from decimal import Decimal
from enum import Enum
from fractions import Fraction
from hashlib import sha256
from types import BuiltinFunctionType, CodeType, FunctionType, ModuleType
from typing import Final

import numpy as np

import symbody
from symbody.arguments import is_sympy
from symbody.equations.equation_set import EquationSet
from symbody.expr.language.formula import Formula
from symbody.model.first_values import FirstValues
from symbody.simulation.inputs.fmu_input import FmuInput

_PLAIN: Final = (bool, int, float, str, bytes, Fraction, Decimal, type(None))
_OURS: Final = "symbody."


class NoIdentityError(Exception):
    """Something has no content that could be compared, as an object of a user's class."""


def motion_digest(
    eqs: EquationSet, laws: Mapping[str, object], *others: object, key: str | None = None
) -> str:
    """Return a hash of equations, laws of inputs and all else that a motion follows from.

    The release of symbody is part of it, and what of the machine decides bits: processor and C library, which
    compute sines. A Python function counts by its code, its defaults, and the closure values and globals that
    it reads: numbers, texts, tuples, arrays, libraries and such functions.

    Parameters
    ----------
    key : str, optional
        What stands for laws without content, as functions that read objects of a user's class.

    Raises
    ------
    NoIdentityError
        If something has no content that could be compared, and no key.
    """
    machine = platform.machine(), sys.platform, platform.libc_ver()
    known = {name: law if key is None or not missing_content(law) else (key,) for name, law in laws.items()}
    return _content_hash(symbody.__version__, machine, eqs, known, *others)


def missing_content(law: object) -> str:
    """Return what in a law cannot be compared, empty if all can."""
    try:
        _content_hash(law)
    except NoIdentityError as error:
        return str(error)
    return ""


def _content_hash(*values: object) -> str:
    digest = sha256()
    for piece in _pieces(values, set()):
        digest.update(len(piece).to_bytes(8, "little") + piece)
    return digest.hexdigest()


def _pieces(value: object, inside: set[int]) -> Iterator[bytes]:
    """Yield what a value consists of, each piece preceded by what it is; `inside` are functions around it."""
    kind = type(value)
    yield f"{kind.__module__}.{kind.__qualname__}".encode()
    if isinstance(value, Formula):
        yield value.text.encode()
    elif kind in _PLAIN or is_sympy(value):
        yield repr(value).encode()
    elif isinstance(value, np.ndarray | np.generic):
        array = np.ascontiguousarray(value)
        if array.dtype.hasobject:
            raise NoIdentityError(kind.__name__)
        yield f"{array.dtype.str}{array.shape}".encode()
        yield array.tobytes()
    elif isinstance(value, Enum):
        yield value.name.encode()
    elif isinstance(value, EquationSet):
        yield from _equation_pieces(value, inside)
    elif isinstance(value, FunctionType):
        yield from _function_pieces(value, inside)
    elif isinstance(value, ModuleType):
        yield _library(value).encode()
    elif isinstance(value, BuiltinFunctionType | np.ufunc):
        yield f"{getattr(value, '__module__', '')}.{value.__name__}".encode()
    else:
        yield from _items(value, inside)


def _library(module: ModuleType) -> str:
    """Return the name and release of a library; modules of users may change, and are not looked at."""
    library = module.__name__.partition(".")[0]
    version = getattr(sys.modules.get(library), "__version__", "")
    if not version and library not in sys.stdlib_module_names:
        raise NoIdentityError(f"module {module.__name__}")
    return f"{module.__name__} {version}"


def _items(value: object, inside: set[int]) -> Iterator[bytes]:
    """Yield what a collection, or an object of this package, consists of."""
    if isinstance(value, tuple | list):
        parts: list[object] = list(value)
    elif isinstance(value, Mapping):
        parts = [part for pair in sorted(value.items(), key=lambda pair: repr(pair[0])) for part in pair]
        if isinstance(value, FirstValues):
            parts.append(sorted(value.held))
    elif isinstance(value, set | frozenset):
        parts = sorted(value, key=repr)
    elif is_dataclass(value) and type(value).__module__.startswith(_OURS):
        parts = [getattr(value, each.name) for each in fields(value) if not each.name.startswith("_")]
        if isinstance(value, FmuInput):
            yield _file_hash(value)
    else:
        raise NoIdentityError(type(value).__name__)
    yield str(len(parts)).encode()
    for part in parts:
        yield from _pieces(part, inside)


def _file_hash(fmu: FmuInput) -> bytes:
    try:
        with open(fmu.path, "rb") as file:
            return sha256(file.read()).digest()
    except OSError as error:
        raise NoIdentityError(f"{fmu.path!r} ({error.strerror or error})") from error


def _equation_pieces(eqs: EquationSet, inside: set[int]) -> Iterator[bytes]:
    """Yield the model, and the structure of the rates: formulation, tree and substitutions show in it."""
    graph = eqs.formed.graph
    nodes = [node for name in ("xdot", "power") for node in eqs.roots(name).nodes]
    yield repr([graph.hashes[node] for node in nodes]).encode()
    yield from _pieces((eqs.state_names, eqs.input_names, eqs.multiplier_names), inside)
    yield from _pieces(eqs.model, inside)


def _function_pieces(function: FunctionType, inside: set[int]) -> Iterator[bytes]:
    if id(function) in inside:  # it calls itself
        return
    inside = {*inside, id(function)}
    code = function.__code__
    yield from _code_pieces(code, inside)
    yield from _pieces((function.__defaults__, function.__kwdefaults__), inside)
    for cell in function.__closure__ or ():
        yield from _pieces(cell.cell_contents, inside)
    read = {name: function.__globals__[name] for name in _names_in(code) if name in function.__globals__}
    yield from _pieces(read, inside)


def _code_pieces(code: CodeType, inside: set[int]) -> Iterator[bytes]:
    yield code.co_code
    yield from _pieces((code.co_names, code.co_varnames, code.co_argcount), inside)
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _code_pieces(constant, inside)
        else:
            yield from _pieces(constant, inside)


def _names_in(code: CodeType) -> set[str]:
    inner = (constant for constant in code.co_consts if isinstance(constant, CodeType))
    return {*code.co_names}.union(*map(_names_in, inner))
