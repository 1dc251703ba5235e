"""Kernels as machine code: compiled once on a computer, then read from its disk."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import Final

import llvmlite.binding as binding

from symbody.codegen.kernels.llvm_kernels import entry_name, entry_text, kernel_name, llvm_text
from symbody.codegen.kernels.reader import read_kernels, read_text
from symbody.codegen.kernels.tree import KernelTree
from symbody.codegen.llvm.machine import environment, lanes, light_code, optimized_code
from symbody.codegen.llvm.runtime import load
from symbody.codegen.llvm.stored_module import Module, read_module, store_module, written_by

_LIBRARIES: Final[list[binding.ResourceTracker]] = []  # functions live as long as these


def load_kernels(
    module: str, names: Sequence[str], *, light: bool = False, features: Collection[str] | None = None
) -> Mapping[str, int]:
    """Return the addresses of kernels that one file holds or imports, valid as long as the process lives.

    Those called once in a while are compiled in a third of the time with `light`; `features` is what the
    motion has whose loop they are.
    """
    words = [module, *names, *sorted(features or ())]
    key = written_by() and b"\n".join([written_by(), *map(str.encode, words)])
    key = key and key + environment().encode()
    stored = read_module(key)
    if stored is None:
        text = llvm_text(read_kernels(module, *names, features=features), names, lanes=lanes())
        stored = Module((light_code(text) if light else optimized_code(text),), 0, ())
        store_module(key, stored)
    return _addresses(stored, names)


def load_entries(module: str, names: Sequence[str]) -> Mapping[str, int]:
    """Return the addresses at which kernels of a file are called as functions of generated code are."""
    key = written_by() and b"\n".join([written_by(), b"entries", module.encode(), *map(str.encode, names)])
    key = key and key + environment().encode()
    stored = read_module(key)
    if stored is None:
        trees = read_kernels(module, *names)
        entries = "\n".join(entry_text(trees[name]) for name in names)
        stored = Module((optimized_code(f"{llvm_text(trees, (), lanes=lanes())}\n{entries}"),), 0, ())
        store_module(key, stored)
    library = load(stored, *map(entry_name, names))
    _LIBRARIES.append(library)
    return {name: int(library[entry_name(name)]) for name in names}


def compile_kernels(text: str, file: str) -> Mapping[str, int]:
    """Return the addresses of all kernels of a text, valid as long as the process lives."""
    return compile_trees(read_text(text, file))


def compile_trees(kernels: Mapping[str, KernelTree]) -> Mapping[str, int]:
    """Return the addresses of kernels, valid as long as the process lives."""
    code = optimized_code(llvm_text(kernels, tuple(kernels), lanes=lanes()))
    return _addresses(Module((code,), 0, ()), tuple(kernels))


def _addresses(module: Module, names: Sequence[str]) -> Mapping[str, int]:
    library = load(module, *map(kernel_name, names))
    _LIBRARIES.append(library)
    return {name: int(library[kernel_name(name)]) for name in names}
