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
from symbody.codegen.texts.layout import Language, TextLayout, TextWriter
from symbody.codegen.texts.statements import Statements
from symbody.codegen.texts.text_dialect import Dialect, entries, operation_formats
from symbody.expr import opcodes as op

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

_EXPRESSIONS: Final = operation_formats(
    "",
    {
        op.POW: "{0} ** {1}",
        # x + 0 where x is neither positive nor negative: nan stays, -0 becomes 0.
        op.SIGN: "merge(1.0_dp, merge(-1.0_dp, {0} + 0.0_dp, {0} < 0.0_dp), {0} > 0.0_dp)",
        # The standard's floor gives an integer, which overflows.
        op.FLOOR: "aint({0}) - merge(1.0_dp, 0.0_dp, {0} < aint({0}))",
        # y + 0: the angle of a point on the negative x axis is pi, also where y is -0.
        op.ATAN2: "atan2({0} + 0.0_dp, {1})",
        op.MIN: "merge({0}, {1}, {0} < {1} .or. {0} /= {0})",  # nan where either is, as for max
        op.MAX: "merge({0}, {1}, {1} < {0} .or. {0} /= {0})",
        op.AND: "{0} .and. {1}",
        op.OR: "{0} .or. {1}",
        op.NOT: ".not. {0}",
        op.SELECT: "merge({1}, {2}, {0})",
        op.FMA: "({0} * {1}) + {2}",  # only Fortran 2018 has one
    },
)


_DIALECT: Final = Dialect(
    _EXPRESSIONS, "    {name} = {value}", number="{0}_dp", entry="{array}({k})", first=1, is_held=True,
    truth="merge(1.0_dp, 0.0_dp, {0})", is_true="abs({0}) > 0.0_dp",
    kernel_call="    call symbody_saddle({n}, {m}, work({M}), work({J}), work({F}), work({gamma}), "
    "work({solution}))",
)  # fmt: skip


def _text(layout: TextLayout) -> str:
    """Return a Fortran module ``symbody_name`` with one subroutine ``name(t, q, u, r, p, results...)``."""
    parts = [*_head(layout), *_functions(layout)]
    if layout.plan.results:
        parts += ["", *saddle_text(FORTRAN, SADDLE_CALL).rstrip("\n").split("\n")]
    parts.append(f"end module symbody_{layout.name}")
    return "\n".join(line for part in parts for line in break_line(part)) + "\n"


generate: Final = TextWriter(_LANGUAGE, _text, PIECE_SIZE)


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
    yield from (f"! {line}".rstrip() for line in layout.heading(_DIALECT.entry_text, call))
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
    pieces = [Statements(layout, piece, _DIALECT, layout.targets(entries)) for piece in layout.plan.pieces]
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
