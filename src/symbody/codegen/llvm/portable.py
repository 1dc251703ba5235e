"""Machine code of a sequence without fused operations: the bits of its portable texts.

The sequence is a kernel here, with sine, cosine and the linear solver as kernels beside it.
"""

from __future__ import annotations

from typing import Final

from symbody.codegen.kernels.llvm_kernels import kernel_name, llvm_text
from symbody.codegen.kernels.sequence_kernel import GROUPS, sequence_kernels
from symbody.codegen.llvm.entries import batch_function
from symbody.codegen.llvm.machine import light_code
from symbody.codegen.llvm.native import BATCH_NAME, NAME, NativeFunction
from symbody.codegen.llvm.runtime import load
from symbody.codegen.llvm.stored_module import Module, key_of, read_module, store_module
from symbody.codegen.lowering import constant_values, refuse_user_functions
from symbody.expr.deadline import begin
from symbody.expr.sequences.sequence import Sequence

_KERNEL: Final = "portable"
_POINTERS: Final = ", ".join(f"ptr %{group}" for group in GROUPS)


def compile_portable(sequence: Sequence) -> NativeFunction:
    """Compile a sequence, without programs for several items, for this processor.

    Raises
    ------
    CompileError
        If the sequence calls functions the user supplied, or a constant is beyond the doubles.
    """
    refuse_user_functions(sequence)
    constant_values(sequence)
    key = key_of(sequence)
    key = key and b"portable\n" + key
    module = read_module(key)
    if module is None:
        begin("object code")
        kernels, work_size = sequence_kernels(sequence, _KERNEL)
        text = llvm_text(kernels, [_KERNEL]) + _entry() + batch_function(BATCH_NAME, NAME)
        module = Module((light_code(text),), work_size, ())
        store_module(key, module)
    library = load(module, NAME, BATCH_NAME)
    addresses = library[NAME], library[BATCH_NAME]
    return NativeFunction(*addresses, module.work_size, sequence.operation_count, 1, "", library)


def _entry() -> str:
    """Return the function that all generated code is called by."""
    return (
        f"define i32 @{NAME}({_POINTERS}) nounwind {{\n"
        f"%status = call i64 @{kernel_name(_KERNEL)}({_POINTERS})\n"
        "%result = trunc i64 %status to i32\n"
        "ret i32 %result\n}\n"
    )
