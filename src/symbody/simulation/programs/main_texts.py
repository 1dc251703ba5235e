"""What stands around the kernels of a program: the numbers it begins with, and the loop that calls them."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np

from symbody.codegen.kernels.c_kernels import PREAMBLE, C
from symbody.codegen.kernels.dialect import KernelDialect
from symbody.codegen.kernels.javascript_kernels import JAVASCRIPT
from symbody.codegen.kernels.python_kernels import PYTHON
from symbody.codegen.kernels.text_writer import kernel_text
from symbody.codegen.kernels.tree import Type
from symbody.kernels.block import Run
from symbody.simulation.programs.prepared_motion import PROJECTION, RIGHT_HAND_SIDE, PreparedMotion

_TRIALS: Final = 1000  # steps of one call


@dataclass(frozen=True, slots=True)
class ProgramLanguage:
    """A language of whole programs.

    Attributes
    ----------
    dialect : KernelDialect
    head, main : str
        Before and behind the kernels; ``@NAME@`` stands for numbers and names of the motion.
    comment : str
        Format of a comment of one line.
    array : str
        Format of a list of numbers.
    """

    dialect: KernelDialect
    head: str
    main: str
    comment: str
    array: str


_C_MAIN: Final = """
static const int places[] = @PLACES@;
static const double values[] = @VALUES@;
static const double times[] = @TIMES@;
static double block[@SIZE@], t[@SAMPLES@], x[@SAMPLES@ * @N@], nothing[1], none[1];

/* Computes the motion and returns its code: 2 where the end was reached. Samples lie in t and x by rows. */
static int simulate(int *samples)
{
    int k, code;
    for (k = 0; k < @SIZE@; k++) block[k] = 0.0;
    for (k = 0; k < @PLACE_COUNT@; k++) block[places[k]] = values[k];
    code = symbody_begin(symbody_right_hand_side, block, times, t, x, nothing);
    while (code == 0)
        code = symbody_advance(
            symbody_right_hand_side, symbody_@PROJECTION@, block, times, t, x, nothing, none, @TRIALS@);
    *samples = (int)block[@COUNT_PLACE@];
    return code;
}

int main(void)
{
    int k, i, samples, code = simulate(&samples);
    puts(@HEADER@);
    for (k = 0; k < samples; k++) {
        printf("%.17g", t[k]);
        for (i = 0; i < @N@; i++) printf(",%.17g", x[k * @N@ + i]);
        puts("");
    }
    return code == 2 ? 0 : 1;
}
"""
_JAVASCRIPT_MAIN: Final = """
const places = @PLACES@;
const values = @VALUES@;
const times = Float64Array.from(@TIMES@);
const header = @HEADER@;

// Computes the motion: code 2 where the end was reached, and rows of time and states.
function simulate() {
    const block = new Float64Array(@SIZE@), none = new Float64Array(1);
    const t = new Float64Array(@SAMPLES@), x = new Float64Array(@SAMPLES@ * @N@);
    places.forEach((place, k) => { block[place] = values[k]; });
    let code = symbody_begin(symbody_right_hand_side, block, 0, times, 0, t, 0, x, 0, none, 0);
    const f = symbody_right_hand_side, g = symbody_@PROJECTION@;
    while (code === 0)
        code = symbody_advance(f, g, block, 0, times, 0, t, 0, x, 0, none, 0, none, 0, @TRIALS@);
    const rows = [];
    for (let k = 0; k < block[@COUNT_PLACE@]; k++) rows.push([t[k], ...x.subarray(k * @N@, (k + 1) * @N@)]);
    return { code, rows };
}

if (typeof process !== "undefined" && typeof module !== "undefined" && require.main === module) {
    const { code, rows } = simulate();
    console.log([header, ...rows.map((row) => row.join(","))].join("\\n"));
    process.exitCode = code === 2 ? 0 : 1;
} else if (typeof module !== "undefined") module.exports = { simulate, header };
"""
_PYTHON_MAIN: Final = """
PLACES = @PLACES@
VALUES = @VALUES@
TIMES = @TIMES@
HEADER = @HEADER@


def simulate():
    \"\"\"Return a code, 2 where the end was reached, and rows of time and states.\"\"\"
    block = [0.0] * @SIZE@
    for place, value in zip(PLACES, VALUES):
        block[place] = value
    t, x, none = [0.0] * @SAMPLES@, [0.0] * (@SAMPLES@ * @N@), [0.0]
    code = symbody_begin(symbody_right_hand_side, block, 0, TIMES, 0, t, 0, x, 0, none, 0)
    f, g = symbody_right_hand_side, symbody_@PROJECTION@
    while code == 0:
        code = symbody_advance(f, g, block, 0, TIMES, 0, t, 0, x, 0, none, 0, none, 0, @TRIALS@)
    return code, [[t[k], *x[k * @N@ : (k + 1) * @N@]] for k in range(int(block[@COUNT_PLACE@]))]


if __name__ == "__main__":
    code, rows = simulate()
    print(HEADER)
    for row in rows:
        print(*map(repr, row), sep=",")
    raise SystemExit(0 if code == 2 else 1)
"""

LANGUAGES: Final[Mapping[str, ProgramLanguage]] = {
    "c": ProgramLanguage(C, f"{PREAMBLE}#include <stdio.h>\n\n", _C_MAIN, "/* {} */", "{{{}}}"),
    "javascript": ProgramLanguage(JAVASCRIPT, '"use strict";\n\n', _JAVASCRIPT_MAIN, "// {}", "[{}]"),
    "python": ProgramLanguage(PYTHON, "import math\n\n\n", _PYTHON_MAIN, "# {}", "[{}]"),
}


def program_text(motion: PreparedMotion, language: ProgramLanguage, title: str) -> str:
    """Return the program of a motion."""
    dialect = language.dialect
    places = np.flatnonzero(motion.block)
    words = {
        "PLACES": _list(language, map(str, places)),
        "VALUES": _numbers(language, motion.block[places]),
        "TIMES": _numbers(language, motion.times),
        "HEADER": json.dumps(",".join(["t", *(_plain(name) for name in motion.names)])),
        "SIZE": str(motion.block.size),
        "SAMPLES": str(motion.times.size),
        "N": str(len(motion.names)),
        "PLACE_COUNT": str(places.size),
        "COUNT_PLACE": str(Run.layout["counts.samples"]),
        "PROJECTION": PROJECTION if motion.is_projected else RIGHT_HAND_SIDE,
        "TRIALS": str(_TRIALS),
    }
    main = language.main
    for name, text in words.items():
        main = main.replace(f"@{name}@", text)
    comments = [
        f"{title}: a whole simulation, written by symbody; it needs nothing else.",
        "It prints the samples as lines of numbers: " + ", ".join(["t", *map(_plain, motion.names)]),
    ]
    head = "".join(language.comment.format(_plain(text)) + "\n" for text in comments)
    return head + language.head + kernel_text(motion.kernels, dialect) + main


def _plain(name: str) -> str:
    """Return a name without what would end a comment or a line."""
    return "".join(letter if letter.isalnum() or letter in " _-.,:()'^" else "?" for letter in name)


def _numbers(language: ProgramLanguage, values: Iterable[float]) -> str:
    return _list(language, (language.dialect.literal(float(value), Type.REAL) for value in values))


def _list(language: ProgramLanguage, items: Iterable[str]) -> str:
    """Return a list, some numbers a line."""
    words = list(items)
    lines = (", ".join(words[k : k + 8]) for k in range(0, len(words), 8))
    return language.array.format("\n    " + ",\n    ".join(lines) + "\n")
