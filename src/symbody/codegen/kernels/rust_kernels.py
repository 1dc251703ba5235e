"""Kernels as Rust: arrays are slices of cells, so that parts of one scratch array can be written."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Final

from symbody.codegen.kernels.dialect import PREFIX, Arrays, KernelDialect, Names, StatementFormats
from symbody.codegen.kernels.tree import Count, KernelTree, Type, walk

_TYPES: Final = {Type.REAL: "f64", Type.INTEGER: "isize", Type.ARRAY: "&[std::cell::Cell<f64>]"}
_ZEROS: Final = {Type.REAL: "0.0", Type.INTEGER: "0", Type.ARRAY: "&[]"}


def _literal(value: float, kind: Type) -> str:
    if kind == Type.INTEGER or math.isfinite(value):
        return repr(value)
    return "f64::NAN" if math.isnan(value) else "f64::INFINITY" if value > 0 else "f64::NEG_INFINITY"


def _names(tree: KernelTree) -> Names:
    return {
        name: f"{name}_"
        for name in (*(p.name for p in tree.parameters), *tree.variables)
        if name in _RESERVED
    }


_RESERVED: Final = frozenset(
    "box do final fn impl in loop match mod move mut ref self type use where yield".split()
)


def _head(tree: KernelTree, names: Names) -> Iterator[str]:
    parameters = ", ".join(f"{names.get(p.name, p.name)}: {_TYPES[p.type]}" for p in tree.parameters)
    result = "" if tree.result is None else f" -> {_TYPES[tree.result]}"
    yield f"/// {tree.summary}"
    yield "#[allow(non_snake_case, unused_assignments, unused_parens)]"
    yield f"fn {PREFIX}{tree.name}({parameters}){result} {{"
    counters = _counters(tree)
    for name, kind in tree.variables.items():
        if name not in counters:
            yield f"    let mut {names.get(name, name)}: {_TYPES[kind]} = {_ZEROS[kind]};"


def _counters(tree: KernelTree) -> set[str]:
    """Return the counters of loops, which their loop declares."""
    return {node.name for node in walk(tree.body) if isinstance(node, Count)}


# The arguments one after the other, the solution and scratch, all in one array.
SADDLE_CALL: Final = """\
fn symbody_saddle(work: &mut [f64], n: usize, m: usize, first: usize, results: usize, scratch: usize) {
    let cells = std::cell::Cell::from_mut(work).as_slice_of_cells();
    let (jacobian, force, gamma) = (first + n * n, first + n * n + m * n, first + n * n + m * n + n);
    symbody_solve_saddle(
        n as isize, m as isize, &cells[first..], &cells[jacobian..], &cells[force..], &cells[gamma..],
        &cells[results..], &cells[scratch..],
    );
}
"""

RUST: Final = KernelDialect(
    literal=_literal,
    head=_head,
    operators={"and": "&&", "or": "||", "neg": "-"},
    words={
        "not": "!({0})", "abs": "({0}).abs()", "sqrt": "({0}).sqrt()",
        "min": "symbody_smaller({0}, {1})", "max": "symbody_larger({0}, {1})",
        "is_finite": "({0}).is_finite()",
        "exponent": "symbody_exponent({0})", "power_of_two": "symbody_power_of_two({0})",
        "half": "({0}).div_euclid(2)", "real": "(({0}) as f64)", "integer": "(({0}) as isize)",
    },
    arrays=Arrays.POINTERS,
    entry="{array}[({index}) as usize].get()",
    part="&{array}[({index}) as usize..]",
    statements=StatementFormats(
        assign="{name} = {value};",
        store="{array}[({index}) as usize].set({value});",
        perform="{value};",
        returns="return {value};",
        returns_nothing="return;",
        leave="break;",
        count="for {name} in {start}..{stop} {{",
        count_down="for {name} in (({stop}) + 1..({start}) + 1).rev() {{",
        repeat="while {condition} {{",
        choose="if {condition} {{",
        choose_next="}} else if {condition} {{",
        otherwise="} else {",
        close="}",
        end="}",
    ),
    helpers={
        "min": "fn symbody_smaller<T: PartialOrd>(a: T, b: T) -> T { if b < a { b } else { a } }\n",
        "max": "fn symbody_larger<T: PartialOrd>(a: T, b: T) -> T { if b > a { b } else { a } }\n",
        "exponent": """\
fn symbody_exponent(x: f64) -> isize {
    if !(x > 0.0 && x < f64::INFINITY) { return 0; }
    let e = ((x.to_bits() >> 52) & 0x7ff) as isize - 1022;
    if e < -1022 { -1022 } else { e }
}
""",
        "power_of_two": """\
fn symbody_power_of_two(e: isize) -> f64 { f64::from_bits(((e + 1023) as u64) << 52) }
""",
    },
    rename=_names,
)  # fmt: skip
