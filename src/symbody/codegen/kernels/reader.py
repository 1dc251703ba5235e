"""Reads the files of `symbody.kernels` as trees, and refuses what is outside the language.

The files are source of this package; they are parsed, not executed. `docs/kernels.md` defines the language.
"""

from __future__ import annotations

import ast
from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from graphlib import CycleError, TopologicalSorter
from importlib import resources
from types import MappingProxyType
from typing import Final

from symbody.codegen.kernels.functions import FunctionReader, read_signature
from symbody.codegen.kernels.source import KernelSource
from symbody.codegen.kernels.tree import KernelTree, Literal, Type, called_kernels, changed_arrays

PACKAGE: Final = "symbody.kernels"
LANGUAGE: Final = f"{PACKAGE}.language"


def read_kernels(module: str, *roots: str) -> Mapping[str, KernelTree]:
    """Return kernels of one file and those that they call, each behind the kernels that it calls.

    Parameters
    ----------
    module : str
        File name in `symbody.kernels` without suffix.
    *roots : str
        The kernels; by default the one that is called like the file.

    Raises
    ------
    KernelError
        If something is outside the language: file, line, cure.
    """
    kernels = _read(f"{PACKAGE}.{module}")
    needed, waiting = set[str](), list(roots or [module])
    while waiting:
        name = waiting.pop()
        if name not in needed:
            needed.add(name)
            waiting.extend(called_kernels(kernels[name].body))
    return {name: tree for name, tree in kernels.items() if name in needed}


def read_text(text: str, file: str) -> Mapping[str, KernelTree]:
    """Return the kernels of a text and of the files it imports, each behind those that it calls."""
    source = KernelSource(file)
    kernels: dict[str, KernelTree] = {}
    definitions: list[ast.FunctionDef] = []
    for node in ast.parse(text).body:
        if isinstance(node, ast.ImportFrom):
            kernels |= _import(source, node)
        elif isinstance(node, ast.AnnAssign):
            source.define_constant(node)
        elif isinstance(node, ast.FunctionDef):
            definitions.append(node)
        elif not _is_docstring(node):
            source.refuse(node, "only imports, constants and functions stand in a kernel file", "remove it")
    signatures = {name: (tuple(tree.parameters), tree.result) for name, tree in kernels.items()}
    signatures |= {node.name: read_signature(source, node) for node in definitions}
    own = {node.name: FunctionReader(source, signatures, node).read() for node in definitions}
    return MappingProxyType(_mark_changes(kernels, _sort_by_calls(source, own)))


@cache
def _read(module: str) -> Mapping[str, KernelTree]:
    return read_text(_text(module), _file(module))


@cache
def _constants(module: str) -> Mapping[str, Literal]:
    source = KernelSource(_file(module))
    for node in ast.parse(_text(module)).body:
        if isinstance(node, ast.AnnAssign):
            source.define_constant(node)
        elif isinstance(node, ast.ImportFrom) and _is_kernel_file(node.module or ""):
            others = _constants(node.module or "")
            source.constants.update({a.name: others[a.name] for a in node.names if a.name in others})
    return source.constants


def _is_kernel_file(module: str) -> bool:
    return module.startswith(f"{PACKAGE}.") and module != LANGUAGE


def _file(module: str) -> str:
    return f"kernels/{module.removeprefix(PACKAGE + '.')}.py"


def _text(module: str) -> str:
    return (resources.files(PACKAGE) / f"{module.removeprefix(PACKAGE + '.')}.py").read_text(encoding="utf-8")


def _import(source: KernelSource, node: ast.ImportFrom) -> Mapping[str, KernelTree]:
    module = node.module or ""
    if module in {LANGUAGE, "__future__", "typing"}:
        return {}
    if not _is_kernel_file(module):
        source.refuse(node, f"kernels import nothing from {module}", f"import from {PACKAGE} alone")
    kernels, constants = _read(module), _constants(module)
    for alias in node.names:
        if alias.name in constants:
            source.constants[alias.name] = constants[alias.name]
        elif alias.name not in kernels:
            source.refuse(node, f"{module} has no kernel {alias.name}", "correct the name")
    return kernels


def _is_docstring(node: ast.stmt) -> bool:
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)


def _sort_by_calls(source: KernelSource, kernels: Mapping[str, KernelTree]) -> dict[str, KernelTree]:
    calls = {name: sorted(called_kernels(tree.body) & kernels.keys()) for name, tree in kernels.items()}
    try:
        order = list(TopologicalSorter(calls).static_order())
    except CycleError as error:
        source.refuse(ast.Pass(), f"kernels call each other in a circle: {error.args[1]}", "break it")
    return {name: kernels[name] for name in order}


def _mark_changes(
    imported: Mapping[str, KernelTree], kernels: Mapping[str, KernelTree]
) -> dict[str, KernelTree]:
    """Mark the parameters into which a kernel, or one that it calls, stores; imported ones have marks."""
    marked = dict(imported)
    for name, tree in kernels.items():
        changed = changed_arrays(tree.body, marked)
        parameters = tuple(
            replace(p, is_changed=p.type == Type.ARRAY and p.name in changed) for p in tree.parameters
        )
        arrays = {local for local, kind in tree.variables.items() if kind == Type.ARRAY}
        marked[name] = replace(tree, parameters=parameters, read_only=frozenset(arrays - changed))
    return marked
