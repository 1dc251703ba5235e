"""Fortran 2008 text of a sequence: one module that needs nothing else and that C can call too.

Every operation is one statement, in the order of the sequence; long functions are cut into pieces as in C,
because compilers take more than linear time on one long function.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Final

from symbody.codegen.kernels.fortran_kernels import FORTRAN, SADDLE_CALL
from symbody.codegen.kernels.text_writer import saddle_text
from symbody.codegen.pieces import PIECE_SIZE
from symbody.codegen.texts.layout import Arguments, Language, TextLayout
from symbody.codegen.texts.statements import Dialect, Statements
from symbody.expr import opcodes as op
from symbody.expr.sequence import Sequence

WIDTH: Final = 132  # what a line of the standard holds

# Fortran has no reserved words, but a variable hides the function of its name; statements stay readable.
_LANGUAGE: Final = Language(
    "Fortran",
    frozenset(
        """
        abstract allocatable allocate assign assignment associate asynchronous backspace bind block blockdata
        call case character class close codimension common complex concurrent contains contiguous continue
        critical cycle data deallocate default deferred dimension do double doubleprecision elemental else
        elseif elsewhere end enddo endfile endif entry enum enumerator equivalence error exit extends external
        final flush forall format function generic go goto if implicit import impure in include inout inquire
        integer intent interface intrinsic is kind len lock logical memory module namelist none non_intrinsic
        non_overridable nopass nullify only open operator optional out parameter pass pause pointer precision
        print private procedure program protected public pure read real recursive result return rewind save
        select sequence stop subroutine submodule sync target then to type unlock use value volatile wait
        where while write
        sin cos tan asin acos atan sinh cosh tanh exp log sqrt abs aint atan2 merge
        ieee_arithmetic ieee_value ieee_quiet_nan iso_c_binding c_double
        dp t q u r p c work
        """.split()
    ),
    any_case=True,
)

_EXPRESSIONS: Final = {
    op.NEG: "-{0}",
    op.ADD: "{0} + {1}",
    op.SUB: "{0} - {1}",
    op.MUL: "{0} * {1}",
    op.DIV: "{0} / {1}",
    op.POW: "{0} ** {1}",
    op.SIN: "sin({0})",
    op.COS: "cos({0})",
    op.TAN: "tan({0})",
    op.ASIN: "asin({0})",
    op.ACOS: "acos({0})",
    op.ATAN: "atan({0})",
    op.SINH: "sinh({0})",
    op.COSH: "cosh({0})",
    op.TANH: "tanh({0})",
    op.EXP: "exp({0})",
    op.LOG: "log({0})",
    op.SQRT: "sqrt({0})",
    op.ABS: "abs({0})",
    # x + 0 where x is neither positive nor negative: nan stays, -0 becomes 0.
    op.SIGN: "merge(1.0_dp, merge(-1.0_dp, {0} + 0.0_dp, {0} < 0.0_dp), {0} > 0.0_dp)",
    # The standard's floor gives an integer, which overflows.
    op.FLOOR: "aint({0}) - merge(1.0_dp, 0.0_dp, {0} < aint({0}))",
    # y + 0: the angle of a point on the negative x axis is pi, also where y is -0.
    op.ATAN2: "atan2({0} + 0.0_dp, {1})",
    op.MIN: "merge({0}, {1}, {0} < {1})",  # the second where either is nan, as for max
    op.MAX: "merge({0}, {1}, {1} < {0})",
    op.LT: "{0} < {1}",
    op.LE: "{0} <= {1}",
    op.EQ: "{0} == {1}",
    op.AND: "{0} .and. {1}",
    op.OR: "{0} .or. {1}",
    op.NOT: ".not. {0}",
    op.SELECT: "merge({1}, {2}, {0})",
    op.FMA: "({0} * {1}) + {2}",  # only Fortran 2018 has one
}


def _number(value: float) -> str:
    text = f"{value!r}_dp"  # the shortest that reads back as the same double
    return f"({text})" if text.startswith("-") else text


def _entry(array: str, k: int) -> str:
    return "t" if array == "t" else f"{array}({k + 1})"


def _target(word: str, indices: tuple[int, ...]) -> str:
    return f"{word}({', '.join(str(k + 1) for k in indices)})" if indices else word


_DIALECT: Final = Dialect(
    _EXPRESSIONS, "    {name} = {value}", _number, _entry, is_held=True,
    truth="merge(1.0_dp, 0.0_dp, {0})", is_true="abs({0}) > 0.0_dp",
    kernel_call="    call symbody_saddle({n}, {m}, {M}, {J}, {F}, {gamma}, {solution})",
)  # fmt: skip


def generate(
    sequence: Sequence,
    name: str = "f",
    arguments: Arguments | None = None,
    *,
    piece_size: int = PIECE_SIZE,
) -> str:
    """Return a Fortran module ``symbody_name`` with one subroutine ``name(t, q, u, r, p, results...)``.

    Parameters
    ----------
    name : str
        Name of the subroutine, and of its C binding in lower case.
    arguments : mapping of group to names, optional
        All arguments in order, for those that the sequence does not read.
    piece_size : int
        About how many operations go into one subroutine; results do not depend on it.

    Raises
    ------
    CompileError
        If `name` cannot name a subroutine, the sequence calls functions the user supplied, or a constant is
        beyond the doubles.
    """
    layout = TextLayout.for_sequence(sequence, name, _LANGUAGE, arguments, piece_size)
    parts = [*_head(layout), *_functions(layout)]
    if layout.plan.results:
        parts += ["", *saddle_text(FORTRAN, SADDLE_CALL).rstrip("\n").split("\n")]
    parts.append(f"end module symbody_{name}")
    return "\n".join(line for part in parts for line in break_line(part)) + "\n"


def break_line(line: str) -> list[str]:
    """Return `line` broken at blanks, so that no part is longer than the standard allows.

    >>> [len(part) for part in break_line("    x = " + " + ".join(["y" * 60] * 3))]
    [72, 131]
    """
    is_comment = line.lstrip().startswith("!")
    indent = line[: len(line) - len(line.lstrip())] + ("!   " if is_comment else "    ")
    parts = []
    while len(line) > WIDTH:
        cut = line.rfind(" ", len(indent), WIDTH - 2)
        cut = WIDTH - 2 if cut < 0 else cut  # only a name in a comment is that long
        parts.append(line[:cut] + ("" if is_comment else " &"))
        line = indent + line[cut:].lstrip()
    return [*parts, line]


def _head(layout: TextLayout) -> Iterator[str]:
    call = f"call {layout.name}({', '.join(_dummies(layout))})"
    yield from (f"! {line}".rstrip() for line in layout.heading(_entry, call))
    yield f"! In C: void {layout.name.lower()}(double *t, ...), everything by address, matrices by columns."
    yield f"module symbody_{layout.name}"
    yield "    use, intrinsic :: iso_c_binding, only: dp => c_double"
    if layout.plan.results:
        yield "    use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan, ieee_positive_inf"
    yield "    implicit none"
    yield "    private"
    yield f"    public :: {layout.name}"
    yield "contains"


def _dummies(layout: TextLayout) -> list[str]:
    return [*layout.sizes, *layout.results]


def _functions(layout: TextLayout) -> Iterator[str]:
    """Yield the subroutine, and before it its pieces if there are several.

    Recursive: compilers keep large arrays of other subroutines in one place for all threads.
    """
    pieces = [Statements(layout, piece, _DIALECT, layout.targets(_target)) for piece in layout.plan.pieces]
    bodies = [piece.lines() for piece in pieces]
    inner = ", ".join([*_dummies(layout), "work"])
    # One more: a kernel without rows has arguments of size 0 behind the others.
    work = f"    real(dp){{}} :: work({layout.plan.scratch + 1})"
    yield f"recursive subroutine {layout.name}({', '.join(_dummies(layout))}) &"
    yield f'    bind(c, name="{layout.name.lower()}")'
    yield from _arguments(layout)
    if len(pieces) > 1 or any("work(" in line for line in bodies[0]):
        yield work.format("")
    if len(pieces) == 1:
        yield from _variables(pieces[0])
        yield from bodies[0]
        yield f"end subroutine {layout.name}"
        return
    yield from (f"    call symbody_piece_{k}({inner})" for k in range(len(pieces)))
    yield f"end subroutine {layout.name}"
    for k, (piece, body) in enumerate(zip(pieces, bodies, strict=True)):
        yield ""
        yield f"subroutine symbody_piece_{k}({inner})"
        yield from _arguments(layout, "inout")
        yield work.format(", intent(inout)")
        yield from _variables(piece)
        yield from body
        yield f"end subroutine symbody_piece_{k}"


def _arguments(layout: TextLayout, way: str = "out") -> Iterator[str]:
    for group, size in layout.sizes.items():
        yield f"    real(dp), intent(in) :: {group}" + ("" if group == "t" else f"({size})")
    for output, word in zip(layout.sequence.outputs, layout.results, strict=True):
        shape = f"({', '.join(str(size) for size in output.shape)})" if output.shape else ""
        yield f"    real(dp), intent({way}) :: {word}{shape}"


def _variables(piece: Statements) -> Iterator[str]:
    yield from _declare("real(dp)", piece.reals)
    yield from _declare("logical", piece.conditions)


def _declare(kind: str, names: Iterable[str]) -> Iterator[str]:
    line = ""
    for name in names:
        if line and len(line) + len(name) + 2 > WIDTH:
            yield line
            line = ""
        line = f"{line}, {name}" if line else f"    {kind} :: {name}"
    yield from [line] if line else []
