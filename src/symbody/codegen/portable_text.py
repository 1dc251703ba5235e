"""Portable texts of a sequence: files in C, JavaScript and Python that give the same bits.

They hold the sequence as a kernel, with sine, cosine and the linear solver as kernels beside it; no operation
is fused. Machine code of the same kernel is `codegen.llvm.portable`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Final

from symbody.codegen.identifiers import quote_name
from symbody.codegen.kernels.c_kernels import PREAMBLE, C
from symbody.codegen.kernels.javascript_kernels import JAVASCRIPT
from symbody.codegen.kernels.python_kernels import PYTHON
from symbody.codegen.kernels.sequence_kernel import GROUPS, sequence_kernels
from symbody.codegen.kernels.text_writer import kernel_text
from symbody.errors import CompileError, Problem
from symbody.expr.sequences.folding import fold_constants
from symbody.expr.sequences.program import written_out
from symbody.expr.sequences.sequence import Sequence

KERNEL: Final = "portable"
Names = Mapping[str, tuple[str, ...]]

_C: Final = """\
#define f_WORK_SIZE {work}
int f_work_size(void);
int f({parameters});

int f_work_size(void)
{{
    return f_WORK_SIZE;
}}

int f({parameters})
{{
    return symbody_portable({arguments});
}}
"""
_JAVASCRIPT: Final = """\
const work = new Float64Array({work});

export function f(t, q, u, r = [], p = [], out = new Float64Array({results})) {{
    const status = symbody_portable([t], 0, q, 0, u, 0, r, 0, p, 0, work, 0, out, 0, work, 0);
    if (status !== 0) throw new Error(`linear system ${{status}} has no solution`);
    return out;
}}
"""
_PYTHON: Final = '''\
def f(t, q, u, r=(), p=()):
    """Return {results} numbers, one output after the other; ArithmeticError if there are none."""
    given = [[float(x) for x in group] for group in ([t], q, u, r, p)]
    out, work = [0.0] * {results}, [0.0] * {work}
    status = symbody_portable(*(x for group in given for x in (group, 0)), work, 0, out, 0, work, 0)
    if status:
        raise ArithmeticError("linear system " + str(status) + " has no solution")
    return out
'''


def portable_sequence(sequence: Sequence) -> Sequence:
    """Return a sequence as portable texts and machine code take it: every operation for every item."""
    return fold_constants(written_out(sequence))


def portable_text(sequence: Sequence, language: str, names: Names) -> str:
    """Return a sequence as text with a function f.

    Parameters
    ----------
    language : str
        "c", "javascript" or "python".
    names : mapping of group to names
        Of all arguments.

    Raises
    ------
    CompileError
        If there is no portable text in the language.
    """
    word = language.lower() if isinstance(language, str) else language
    if word not in _WRITERS:
        raise CompileError(
            Problem("compile.portable_language", "language",
                    f"there is no portable code in {language!r}",
                    "portable code is available in C, JavaScript and Python",
                    'write source("c"), or remove portable=True')
        )  # fmt: skip
    return _WRITERS[word](portable_sequence(sequence), names)


def _head(sequence: Sequence, names: Names, comment: str, first: str) -> Iterator[str]:
    """Yield a comment on what goes in and comes out."""
    yield f"{comment} {first}: {sequence.output_size} numbers in {sequence.operation_count} operations."
    yield f"{comment} Written by symbody; the same bits in C, JavaScript, Python and symbody's machine code,"
    yield f"{comment} except that tan, asin, acos, atan, atan2, sinh, cosh, tanh, exp, log and pow are those"
    yield f"{comment} of a language's own library."
    yield f"{comment} Arguments: place, name; states of signals stand behind the coordinates"
    for group in ("q", "u", "r", "p"):
        for place, name in enumerate(names[group]):
            yield f"{comment}   {group}[{place}]  {quote_name(name)}"
    yield f"{comment} Results: first place, shape, name; row-major"
    place = 0
    for output in sequence.outputs:
        shape = " x ".join(map(str, output.shape)) or "number"
        yield f"{comment}   [{place}]  {shape}  {quote_name(output.name)}"
        place += len(output.values)


def _c_text(sequence: Sequence, names: Names) -> str:
    kernels, work = sequence_kernels(sequence, KERNEL)
    given = ", ".join(f"const double *{group}" for group in GROUPS[:6])
    parameters = f"\n    {given},\n    double *out, double *work"
    head = [
        *_head(sequence, names, "//", f"int f({', '.join(GROUPS)})"),
        "// c is not read: it is for symbody's own calls. Returns 0, or k + 1 if linear system k has no",
        "// solution. Compile with -ffp-contract=off where a compiler does not know the lines below.",
    ]
    text = _C.format(work=work, parameters=parameters, arguments=", ".join(GROUPS))
    return "\n".join([*head, PREAMBLE, kernel_text(kernels, C), text])


def _javascript_text(sequence: Sequence, names: Names) -> str:
    kernels, work = sequence_kernels(sequence, KERNEL)
    head = [*_head(sequence, names, "//", "f(t, q, u, r = [], p = [], out)"), ""]
    text = _JAVASCRIPT.format(work=work, results=sequence.output_size)
    return "\n".join([*head, kernel_text(kernels, JAVASCRIPT), text])


def _python_text(sequence: Sequence, names: Names) -> str:
    kernels, work = sequence_kernels(sequence, KERNEL)
    head = [*_head(sequence, names, "#", "f(t, q, u, r=(), p=())"), "", "import math", ""]
    text = _PYTHON.format(work=work, results=sequence.output_size)
    return "\n".join([*head, kernel_text(kernels, PYTHON), text])


_WRITERS: Final[Mapping[str, Callable[[Sequence, Names], str]]] = {
    "c": _c_text, "javascript": _javascript_text, "python": _python_text,
}  # fmt: skip
