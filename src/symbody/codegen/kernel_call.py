"""Calls of one kernel with the same addresses each time, as a builtin function of Python: 50 ns each.

The interpreter's lock is kept meanwhile. Elsewhere than on CPython of 64 bits with that lock there is no such
call.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from typing import Any, Final

import numpy as np

from symbody.codegen.direct_call import MethodDefinition, available
from symbody.codegen.llvm.machine import THOROUGH, environment, object_codes
from symbody.codegen.llvm.runtime import load
from symbody.codegen.llvm.stored_module import Module, read_module, store_module, written_by
from symbody.single_flight import once

NAME: Final = "symbody_kernel_call"
POINTERS: Final = 5
_WITHOUT_ARGUMENTS: Final = 0x4
# Where the address of an array's numbers stands in the array.
_DATA: Final = 16


def kernel_call(
    kernel: int, pointers: tuple[int, int, int, int, int], count: int
) -> Callable[[], int] | None:
    """Return a function that calls ``int64 kernel(void *, .., int64)``, five pointers; None without one.

    What lies at the addresses has to live as long as the function.
    """
    if not available():
        return None
    as_integer = ctypes.cast(ctypes.pythonapi.PyLong_FromLongLong, ctypes.c_void_p).value or 0
    settings = np.array([kernel, as_integer, *pointers, count], dtype=np.int64)
    definition = MethodDefinition(NAME.encode(), _entry().address, _WITHOUT_ARGUMENTS, None)
    new = ctypes.pythonapi.PyCFunction_NewEx
    new.restype, new.argtypes = ctypes.py_object, (ctypes.c_void_p, ctypes.py_object, ctypes.py_object)
    # What stands for the module is freed last.
    made: Callable[[], Any] = new(ctypes.addressof(definition), settings, (definition, _entry()))
    return made


class _Entry:
    """The function in memory: ``PyObject *(PyObject *settings, PyObject *)``."""

    def __init__(self) -> None:
        key = written_by() and written_by() + environment().encode() + NAME.encode()
        module = read_module(key)
        if module is None:
            module = Module(tuple(object_codes([_text()], THOROUGH)), 0, ())
            store_module(key, module)
        self._library = load(module, NAME)
        self.address = int(self._library[NAME])


@once
def _entry() -> _Entry:
    return _Entry()


def _text() -> str:
    """Return the function as LLVM text."""
    names = ["kernel", "integer", *(f"p{k}" for k in range(POINTERS))]
    lines = [
        f"define ptr @{NAME}(ptr %self, ptr %nothing) nounwind {{",
        f"%settings.at = getelementptr i8, ptr %self, i64 {_DATA}",
        "%settings = load ptr, ptr %settings.at",
    ]
    for k, name in enumerate([*names, "count"]):
        kind = "i64" if name == "count" else "ptr"
        lines.append(f"%{name}.at = getelementptr i8, ptr %settings, i64 {8 * k}")
        lines.append(f"%{name} = load {kind}, ptr %{name}.at")
    pointers = ", ".join(f"ptr %{name}" for name in names[2:])
    lines += [
        f"%code = call i64 %kernel({pointers}, i64 %count)",
        "%result = call ptr %integer(i64 %code)",
        "ret ptr %result",
        "}",
    ]
    return "\n".join(lines) + "\n"
