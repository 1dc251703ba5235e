"""Reads the files of `symbody.kernels` as trees, and refuses what is outside the language.

The files are source of this package; they are parsed, not executed. `docs/kernels.md` defines the language.
"""

from __future__ import annotations

import ast
from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from functools import cache
from graphlib import CycleError, TopologicalSorter
from importlib import import_module, resources
from types import MappingProxyType
from typing import Final

from symbody.codegen.kernels.featured import with_features
from symbody.codegen.kernels.functions import FunctionReader, read_signature
from symbody.codegen.kernels.source import KernelSource
from symbody.codegen.kernels.tree import (
    KernelTree,
    Literal,
    Type,
    Variable,
    called_kernels,
    changed_arrays,
    effects_of,
)
from symbody.kernels.record_layout import RecordLayout

PACKAGE: Final = "symbody.kernels"
FEATURES: Final = f"{PACKAGE}.features"
LANGUAGE: Final = (f"{PACKAGE}.language", f"{PACKAGE}.record_layout")


def read_kernels(
    module: str, *roots: str, features: Collection[str] | None = None
) -> Mapping[str, KernelTree]:
    """Return kernels of one file and those that they call, each behind the kernels that it calls.

    Parameters
    ----------
    module : str
        Name of a file below `symbody.kernels`, without folder and suffix.
    *roots : str
        The kernels; by default the one that is called like the file.
    features : collection of str, optional
        What the motion has, names in `kernels.features`; by default no kernel asks for any.

    Raises
    ------
    KernelError
        If something is outside the language: file, line, cure.
    """
    content = _read(_modules()[module])
    if features is not None:
        return with_features(content.kernels, roots or [module], features)
    needed, waiting = set[str](), list(roots or [module])
    while waiting:
        name = waiting.pop()
        if name not in needed:
            needed.add(name)
            waiting.extend(content.calls[name])
    return {name: tree for name, tree in content.kernels.items() if name in needed}


def read_text(text: str, file: str) -> Mapping[str, KernelTree]:
    """Return the kernels of a text and of the files it imports, each behind those that it calls."""
    return _content(ast.parse(text), file).kernels


@dataclass(frozen=True, slots=True)
class _Content:
    """The kernels of a file and of those that it imports, and the names of the kernels that each calls."""

    kernels: Mapping[str, KernelTree]
    calls: Mapping[str, Collection[str]]


def _content(syntax: ast.Module, file: str) -> _Content:
    source = KernelSource(file)
    kernels: dict[str, KernelTree] = {}
    calls: dict[str, Collection[str]] = {}
    definitions: list[ast.FunctionDef] = []
    for node in syntax.body:
        if isinstance(node, ast.ImportFrom):
            imported = _import(source, node)
            twice = [name for name, tree in imported.kernels.items() if kernels.get(name, tree) is not tree]
            if twice:
                source.refuse(node, f"two kernels are called {', '.join(twice)}", "give one another name")
            kernels |= imported.kernels
            calls |= imported.calls
        elif isinstance(node, ast.AnnAssign):
            source.define_constant(node)
        elif isinstance(node, ast.FunctionDef):
            definitions.append(node)
        elif not _is_docstring(node) and not isinstance(node, ast.ClassDef):
            source.refuse(
                node, "a kernel file contains only imports, constants, records and functions", "remove it"
            )
    signatures = {name: (tuple(tree.parameters), tree.result) for name, tree in kernels.items()}
    signatures |= {node.name: read_signature(source, node) for node in definitions}
    own = {node.name: FunctionReader(source, signatures, node).read() for node in definitions}
    effects = {name: effects_of(tree.body) for name, tree in own.items()}
    own_calls = {name: called_kernels(parts) for name, parts in effects.items()}
    for name in _order_by_calls(source, own_calls):
        kernels[name] = _mark_changes(own[name], changed_arrays(effects[name], kernels))
    return _Content(MappingProxyType(kernels), MappingProxyType(calls | own_calls))


@cache
def _modules() -> Mapping[str, str]:
    """Return the kernel files by their names without folder."""
    home = resources.files(PACKAGE)
    names = [file.name for file in home.iterdir()]
    names += [
        f"{folder.name}.{file.name}"
        for folder in home.iterdir()
        if folder.is_dir()
        for file in folder.iterdir()
    ]
    paths = [name.removesuffix(".py") for name in names if name.endswith(".py")]
    return MappingProxyType({path.rpartition(".")[2]: f"{PACKAGE}.{path}" for path in paths})


@cache
def _read(module: str) -> _Content:
    return _content(_syntax(module), _file(module))


@cache
def _constants(module: str) -> Mapping[str, Literal | Variable]:
    source = KernelSource(_file(module))
    for node in _syntax(module).body:
        if isinstance(node, ast.AnnAssign):
            source.define_constant(node)
        elif isinstance(node, ast.ImportFrom) and _is_kernel_file(node.module or ""):
            others = _constants(node.module or "")
            source.constants.update({a.name: others[a.name] for a in node.names if a.name in others})
    return source.constants


@cache
def _records(module: str) -> Mapping[str, type[RecordLayout]]:
    """Return the records of a file: its classes, which know their layout."""
    names = [node.name for node in _syntax(module).body if isinstance(node, ast.ClassDef)]
    return {name: getattr(import_module(module), name) for name in names}


def _is_kernel_file(module: str) -> bool:
    return module.startswith(f"{PACKAGE}.") and module not in LANGUAGE


def _file(module: str) -> str:
    return f"{module.removeprefix('symbody.').replace('.', '/')}.py"


@cache
def _syntax(module: str) -> ast.Module:
    file = resources.files(PACKAGE).joinpath(*_file(module).split("/")[1:])
    return ast.parse(file.read_text(encoding="utf-8"))


def _import(source: KernelSource, node: ast.ImportFrom) -> _Content:
    module = node.module or ""
    if module in {*LANGUAGE, "__future__", "typing"}:
        return _Content({}, {})
    if not _is_kernel_file(module):
        source.refuse(node, f"kernels import nothing from {module}", f"import from {PACKAGE} alone")
    content, constants, records = _read(module), _constants(module), _records(module)
    for alias in node.names:
        if module == FEATURES:
            source.constants[alias.name] = Variable(alias.name, Type.INTEGER)
        elif alias.name in constants:
            source.constants[alias.name] = constants[alias.name]
        elif alias.name in records:
            source.records[alias.name] = records[alias.name]
        elif alias.name not in content.kernels:
            source.refuse(node, f"{module} has no kernel {alias.name}", "correct the name")
    return content


def _is_docstring(node: ast.stmt) -> bool:
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)


def _order_by_calls(source: KernelSource, calls: Mapping[str, Collection[str]]) -> list[str]:
    """Return the names of kernels, each behind those of the same file that it calls."""
    inside = {name: sorted(called for called in names if called in calls) for name, names in calls.items()}
    try:
        return list(TopologicalSorter(inside).static_order())
    except CycleError as error:
        source.refuse(ast.Pass(), f"kernels call each other in a circle: {error.args[1]}", "break it")


def _mark_changes(tree: KernelTree, changed: Collection[str]) -> KernelTree:
    """Mark the parameters into which a kernel, or one that it calls, stores."""
    parameters = tuple(
        replace(p, is_changed=p.type == Type.ARRAY and p.name in changed) for p in tree.parameters
    )
    arrays = {local for local, kind in tree.variables.items() if kind == Type.ARRAY}
    return replace(tree, parameters=parameters, read_only=frozenset(arrays - set(changed)))
