"""Calls of native code at a single point without Python in between: a fifth of a microsecond each.

The interpreter's lock is kept meanwhile, so one scratch serves all threads; functions that compute long are
not called this way. Elsewhere than on CPython of 64 bits with that lock there is no such call.
"""

from __future__ import annotations

import ctypes
import math
import sys
import sysconfig
from collections.abc import Callable
from functools import partial
from typing import Any, Final

import numpy as np

from symbody.codegen.llvm.direct import ARGUMENTS, NAME, SETTINGS, direct
from symbody.codegen.native_call import NativeCall
from symbody.single_flight import once

# About 100 us.
_LONGEST: Final = 400_000
# Numbers up to which copying an array is the fastest way to a new one.
_COPIED: Final = 1000
_FASTCALL: Final = 0x80
# Bytes before the fields of an object: how often it is used, and its type.
_HEAD: Final = 16


class _Method(ctypes.Structure):
    """PyMethodDef."""

    _fields_ = (
        ("name", ctypes.c_char_p),
        ("function", ctypes.c_void_p),
        ("flags", ctypes.c_int),
        ("doc", ctypes.c_char_p),
    )


class DirectCall:
    """``call(t, q, u, r, p)`` gives a new array, or None for what is not a point of float64 arrays.

    None is also given where the native code reports a status; the caller finds out which.

    Parameters
    ----------
    call : NativeCall
        What is called; it reads no constants that depend on parameters.
    sizes : mapping of group to int
        Numbers in each group.
    shape : tuple of int
        Of the result.

    Attributes
    ----------
    call : callable or None
        None where there is no such call.
    """

    __slots__ = ("call",)

    def __init__(self, native: NativeCall, sizes: dict[str, int], shape: tuple[int, ...]) -> None:
        self.call: Callable[..., Any] | None = None
        work = np.empty(native.native.work_size)
        make_result = np.empty(shape).copy if math.prod(shape) <= _COPIED else partial(np.empty, shape)
        if not available() or native.sequence.operation_count > _LONGEST:
            return
        known = {
            "code": native.native.address,
            "constants": 0,
            "work": work.ctypes.data,
            "make_result": id(make_result),
            "time": 0,
            **_of_python(),
            **{f"size_{group}": sizes[group] for group in ARGUMENTS[1:]},
        }
        settings = np.array([known[name] for name in SETTINGS], dtype=np.int64)
        method = _Method(NAME.encode(), direct().address, _FASTCALL, None)
        new = ctypes.pythonapi.PyCFunction_NewEx
        new.restype, new.argtypes = ctypes.py_object, (ctypes.c_void_p, ctypes.py_object, ctypes.py_object)
        # What stands for the module is freed last: the call itself keeps alive all that it reads by address.
        self.call = new(ctypes.addressof(method), settings, (native, work, make_result, method, direct()))


@once
def available() -> bool:
    """Return whether objects lie in memory here as the native code expects them."""
    return (
        sys.implementation.name == "cpython"
        and object.__basicsize__ == _HEAD
        and ctypes.sizeof(ctypes.c_void_p) == 8
        and not sysconfig.get_config_var("Py_GIL_DISABLED")
        and not sysconfig.get_config_var("Py_TRACE_REFS")
    )


@once
def _of_python() -> dict[str, int]:
    """Return addresses of objects that live as long as the interpreter, and of its functions."""
    objects = {
        "array_type": np.ndarray, "number_type": np.dtype(np.float64), "float_type": float,
        "float64_type": np.float64, "no_values": (), "none": None,
    }  # fmt: skip
    functions = {"call": "PyObject_CallNoArgs", "take": "Py_IncRef", "drop": "Py_DecRef"}
    found = {name: id(value) for name, value in objects.items()}
    for name, word in functions.items():
        found[name] = ctypes.cast(ctypes.pythonapi[word], ctypes.c_void_p).value or 0
    return found
