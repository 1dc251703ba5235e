"""Kernels as machine code: compiled once on a computer, then read from its disk."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final

import llvmlite.binding as binding

from symbody.codegen.kernels.llvm_kernels import kernel_name, llvm_text
from symbody.codegen.kernels.reader import read_kernels, read_text
from symbody.codegen.llvm.machine import SMALL, environment, lanes, optimized_code, target_machine
from symbody.codegen.llvm.stored_module import Module, read_module, store_module, written_by

_LIBRARIES: Final[list[binding.ResourceTracker]] = []  # functions live as long as these


def load_kernels(module: str, names: Sequence[str]) -> Mapping[str, int]:
    """Return the addresses of kernels that one file holds or imports, valid as long as the process lives."""
    key = written_by() and b"\n".join([written_by(), module.encode(), *map(str.encode, names)])
    key = key and key + environment().encode()
    stored = read_module(key)
    if stored is None:
        code = optimized_code(llvm_text(read_kernels(module, *names), names, lanes=lanes()))
        stored = Module((code,), 0, ())
        store_module(key, stored)
    return _link(stored.codes[0], module, names)


def compile_kernels(text: str, file: str) -> Mapping[str, int]:
    """Return the addresses of all kernels of a text, valid as long as the process lives."""
    kernels = read_text(text, file)
    return _link(optimized_code(llvm_text(kernels, tuple(kernels), lanes=lanes())), file, tuple(kernels))


def _link(code: bytes, title: str, names: Sequence[str]) -> Mapping[str, int]:
    """Bring object code into memory."""
    builder = binding.JITLibraryBuilder().add_current_process().add_object_img(code)
    for name in names:
        builder.export_symbol(kernel_name(name))
    library = builder.link(binding.create_lljit_compiler(target_machine(), use_jit_link=SMALL), title)
    _LIBRARIES.append(library)
    return {name: int(library[kernel_name(name)]) for name in names}
