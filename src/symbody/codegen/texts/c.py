"""C99 text of a sequence: one file that needs math.h and nothing else.

Every operation is one statement, in the order of the sequence, so the compiled text gives what IEEE
754 defines, bit for bit what `llvm` gives except for sin and cos, which come from the C library here.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import Final

from symbody.codegen.identifiers import assign_identifiers, quote_name
from symbody.codegen.kernels.c_kernels import PREAMBLE, C
from symbody.codegen.kernels.text_writer import saddle_text
from symbody.codegen.pieces import PIECE_SIZE, Piece, Plan, plan_pieces
from symbody.codegen.texts.layout import TextLayout
from symbody.codegen.texts.statements import Statements
from symbody.codegen.texts.text_dialect import Dialect, operation_formats
from symbody.errors import CompileError, Problem
from symbody.expr import opcodes as op
from symbody.expr.sequences.sequence import Input, Sequence

GROUPS: Final = ("t", "q", "u", "r", "p", "c")

_ARGUMENTS: Final = (*GROUPS, "out", "work")
_SIGNALS: Final = "s"  # the last argument, where a model has states of signals

_EXPRESSIONS: Final = operation_formats(
    "",
    {
        op.POW: "pow({0}, {1})",
        op.ABS: "fabs({0})",
        # x + 0 where x is neither positive nor negative: nan stays, -0 becomes 0.
        op.SIGN: "{0} > 0.0 ? 1.0 : {0} < 0.0 ? -1.0 : {0} + 0.0",
        # y + 0: the angle of a point on the negative x axis is pi, also where y is -0.
        op.ATAN2: "atan2({0} + 0.0, {1})",
        op.MIN: "{0} < {1} || {0} != {0} ? {0} : {1}",  # nan where either is, as for max
        op.MAX: "{1} < {0} || {0} != {0} ? {0} : {1}",
        op.SELECT: "{0} ? {1} : {2}",
        op.FMA: "fma({0}, {1}, {2})",
    },
)

_DIALECT: Final = Dialect(
    _EXPRESSIONS, "    {name} = {value};",
    definition="    const double {name} = {value};",
    condition="    const int {name} = {value};",
    has_time_array=True,
    truth="{0}", is_true="{0} != 0.0",
    kernel_call="    if (symbody_solve_saddle({n}, {m}, work + {M}, work + {J}, work + {F}, work + {gamma}, "
    "work + {solution}, work + {scratch}) && !status) status = {count};",
    is_interleaved=True,
)  # fmt: skip

# Keywords up to C23, functions called here, macros of math.h and of compilers, and what the text itself
# declares. Other functions of math.h may be hidden by a local variable.
_RESERVED: Final = frozenset(
    """
    alignas alignof asm auto bool break case char complex const constexpr continue default do double else enum
    extern false far float for fortran goto huge if imaginary inline int long main near nullptr register
    restrict return short signed sizeof static struct switch true typedef typeof union unsigned void volatile
    while errno i386 linux unix vax
    pow sin cos tan asin acos atan sinh cosh tanh exp log sqrt fabs floor atan2 fma
    NULL NAN INFINITY HUGE HUGE_VAL HUGE_VALF HUGE_VALL MAXFLOAT DOMAIN SING OVERFLOW UNDERFLOW PLOSS TLOSS
    X_TLOSS CONST FAR NEAR PASCAL TRUE FALSE IN OUT VOID
    t q u r p c out work status
    """.split()
)
_WORD: Final = re.compile(r"[A-Za-z_]\w*")
_RESERVED_FORM: Final = re.compile(r"z\d+(_\d+)?|(FP|M|MATH|SVID|symbody)_.*")


def generate(
    sequence: Sequence,
    name: str = "f",
    names: Mapping[str, str] | None = None,
    *,
    piece_size: int = PIECE_SIZE,
    has_signals: bool = False,
) -> str:
    """Return a C99 file with one function ``int name(t, q, u, r, p, c, out, work)``.

    Parameters
    ----------
    name : str
        Name of the function, and the beginning of all other names in the file.
    names : mapping of str to str, optional
        What inputs and outputs are to be called in the text instead of their own names.
    piece_size : int
        About how many operations go into one C function; results do not depend on it.
    has_signals : bool
        Whether states s of signals are one more argument, the last.

    Raises
    ------
    CompileError
        If `name` is not a C identifier, the sequence calls functions the user supplied, or a constant is
        beyond the doubles.
    """
    if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]{0,40}", name) or _is_reserved(name):
        raise CompileError(
            Problem("compile.name", "", f"{quote_name(name)} cannot be the name of a C function",
                    "not an identifier, longer than 41 letters, or taken", "choose another, such as 'f'")
        )  # fmt: skip
    plan = plan_pieces(sequence, piece_size)
    shown = {entry.name: entry.name for entry in sequence.inputs}
    shown |= {entry.name: entry.name for entry in sequence.outputs}
    shown |= names or {}
    labels = [shown[entry.name] for entry in sequence.inputs]
    arguments = (*_ARGUMENTS, _SIGNALS) if has_signals else _ARGUMENTS
    taken = {f"{name}_WORK_SIZE", *arguments}
    words = assign_identifiers(labels, lambda word: _is_reserved(word) or word in taken)
    layout = TextLayout(sequence, plan, name, {}, {}, tuple(words), ())
    kernel = saddle_text(C).split("\n") if plan.results else []
    head = [*_header(layout, arguments, shown), PREAMBLE, *kernel, *_interface(plan, name, arguments)]
    return "\n".join([*head, *_functions(layout, arguments)]) + "\n"


def _parameters(arguments: tuple[str, ...]) -> str:
    """Return the parameters of a function as C declares them."""
    kinds = {"out": "double *restrict ", "work": "double *restrict "}
    return ", ".join(f"{kinds.get(name, 'const double *')}{name}" for name in arguments)


def _is_reserved(word: str) -> bool:
    return word in _RESERVED or _RESERVED_FORM.fullmatch(word) is not None


def _header(layout: TextLayout, arguments: tuple[str, ...], shown: Mapping[str, str]) -> Iterator[str]:
    sequence, plan, name, words = layout.sequence, layout.plan, layout.name, layout.words
    yield "/*"
    yield f" * int {name}({', '.join(arguments)}) computes {sequence.output_size} numbers"
    yield f" * in {sequence.operation_count} operations. Written by symbody."
    yield " *"
    groups = "t, q, u, r, p and s" if _SIGNALS in arguments else "t, q, u, r and p"
    yield f" * Inputs: place, identifier, name; of {groups} what is not listed is not read"
    listed = sorted(zip(sequence.inputs, words, strict=True), key=lambda pair: _place(pair[0]))
    for entry, word in listed:
        yield f" *   {entry.group}[{entry.position}]  {word}  {quote_name(shown[entry.name])}"
    if all(entry.group != "c" for entry, _ in listed):
        yield " *   c is not read: it is for symbody's own calls; pass NULL"
    yield " * Outputs: first place, shape, name; row-major"
    place = 0
    for output in sequence.outputs:
        shape = " x ".join(str(size) for size in output.shape) or "scalar"
        yield f" *   out[{place}...]  {shape}  {quote_name(shown[output.name])}"
        place += len(output.values)
    yield " *"
    yield f" * work: {plan.work_size} doubles of the caller; out and work overlap nothing. Groups that are"
    yield " * not read may be NULL. Returns 0, or k + 1 if the linear system of kernel k has no solution;"
    yield " * what depends on it is NaN then."
    yield " */"


def _place(entry: Input) -> tuple[int, int]:
    """Return what inputs are listed by: t, q, u, r, p, c, s, and the places in each."""
    return (*GROUPS, _SIGNALS).index(entry.group), entry.position


def _interface(plan: Plan, name: str, arguments: tuple[str, ...]) -> Iterator[str]:
    yield f"#define {name}_WORK_SIZE {plan.work_size}"
    yield f"int {name}_work_size(void);"
    yield f"int {name}({_parameters(arguments)});"
    yield ""
    yield f"int {name}_work_size(void)"
    yield "{"
    yield f"    return {name}_WORK_SIZE;"
    yield "}"


def _functions(layout: TextLayout, arguments: tuple[str, ...]) -> Iterator[str]:
    name, pieces = layout.name, layout.plan.pieces
    if len(pieces) == 1:
        yield from _piece_function(layout, pieces[0], f"int {name}", arguments)
        return
    for k, piece in enumerate(pieces):
        yield from _piece_function(layout, piece, f"static int {name}_{k}", arguments)
    yield ""
    yield f"int {name}({_parameters(arguments)})"
    yield "{"
    yield "    int status = 0, next;"
    for k in range(len(pieces)):
        yield f"    next = {name}_{k}({', '.join(arguments)});"
        yield "    if (!status) status = next;"
    yield "    return status;"
    yield "}"


def _piece_function(layout: TextLayout, piece: Piece, head: str, arguments: tuple[str, ...]) -> Iterator[str]:
    targets = {place: f"out[{place}]" for place in range(layout.sequence.output_size)}
    body = Statements(layout, piece, _DIALECT, targets).lines()
    words = {word for line in body for word in _WORD.findall(line)}  # no input is called as an array is
    yield ""
    yield f"{head}({_parameters(arguments)})"
    yield "{"
    if "status" in words:
        yield "    int status = 0;"
    yield from body
    for array in arguments:
        if array not in words:
            yield f"    (void){array};"
    yield f"    return {'status' if 'status' in words else '0'};"
    yield "}"
