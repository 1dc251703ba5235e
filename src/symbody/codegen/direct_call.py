"""Calls of native code at a single point without Python in between: a fifth of a microsecond each.

The interpreter's lock is kept meanwhile, so one scratch serves all threads; functions that compute long are
not called this way. Elsewhere than on CPython of 64 bits with that lock there is no such call.
"""

from __future__ import annotations

import ctypes
import math
import sys
import sysconfig
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from symbody.codegen.llvm.direct import ARGUMENTS, NAME, SETTINGS, direct
from symbody.codegen.native_call import NativeCall
from symbody.single_flight import once

Floats = NDArray[np.float64]
_NOTHING: Final = np.zeros(0)

# About 100 us.
_LONGEST: Final = 400_000
# Numbers up to which copying an array is the fastest way to a new one.
_COPIED: Final = 1000
_FASTCALL: Final = 0x80
# Bytes before the fields of an object: how often it is used, and its type.
_HEAD: Final = 16


class MethodDefinition(ctypes.Structure):
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
    tail : NativeCall
        What is called.
    sizes : mapping of group to int
        Numbers in each group.
    shape : tuple of int
        Of the result.
    constants : (n_c,) array
        What `tail` reads as c, where there are no parameters p.
    head : NativeCall, optional
        Computes c from the parameters; it is called where p differs from that of the call before.
    values : (n,) array
        Parameters that `head` reads behind p.

    Attributes
    ----------
    call : callable or None
        None where there is no such call.
    """

    __slots__ = ("call",)

    def __init__(
        self,
        tail: NativeCall,
        sizes: Mapping[str, int],
        shape: tuple[int, ...],
        *,
        constants: Floats = _NOTHING,
        head: NativeCall | None = None,
        values: Floats = _NOTHING,
    ) -> None:
        self.call: Callable[..., Any] | None = None
        if not available() or tail.sequence.operation_count > _LONGEST:
            return
        parameters, is_current = np.concatenate([np.zeros(sizes["p"]), values]), np.zeros(1, dtype=np.int64)
        work = np.empty(
            tail.native.work_size if head is None else max(tail.native.work_size, head.native.work_size)
        )
        c = constants if head is None else np.zeros(head.sequence.output_size)
        make_result = np.empty(shape).copy if math.prod(shape) <= _COPIED else partial(np.empty, shape)
        entries = {
            "code": tail.native.address,
            "head": 0 if head is None else head.native.address,
            "constants": c.ctypes.data,
            "parameters": parameters.ctypes.data,
            "current": is_current.ctypes.data,
            "work": work.ctypes.data,
            "make_result": id(make_result),
            "time": 0,
            **_of_python(),
            **{f"size_{group}": sizes[group] for group in ARGUMENTS[1:]},
        }
        settings = np.array([entries[name] for name in SETTINGS], dtype=np.int64)
        method = MethodDefinition(NAME.encode(), direct().address, _FASTCALL, None)
        new = ctypes.pythonapi.PyCFunction_NewEx
        new.restype, new.argtypes = ctypes.py_object, (ctypes.c_void_p, ctypes.py_object, ctypes.py_object)
        # What stands for the module is freed last: the call itself keeps alive all that it reads by address.
        kept = (tail, head, work, c, parameters, is_current, make_result, method, direct())
        self.call = new(ctypes.addressof(method), settings, kept)


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
