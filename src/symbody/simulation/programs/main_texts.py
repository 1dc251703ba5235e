"""What stands around the kernels of a program: the numbers it begins with, and the loop that calls them."""

from __future__ import annotations

import json
from collections.abc import Callable, Container, Iterable, Mapping
from dataclasses import dataclass
from importlib.resources import files
from typing import Final

import numpy as np

from symbody.codegen.kernels.c_kernels import PREAMBLE, C
from symbody.codegen.kernels.dialect import KernelDialect
from symbody.codegen.kernels.javascript_kernels import JAVASCRIPT
from symbody.codegen.kernels.python_kernels import PYTHON
from symbody.codegen.kernels.text_writer import kernel_text
from symbody.codegen.kernels.tree import Type
from symbody.kernels import block
from symbody.kernels.block import Run
from symbody.kernels.events.event_monitor import EventMonitor
from symbody.kernels.samples.sample_hold import SampleHold
from symbody.simulation.programs.happenings import CLOSING, STEPS
from symbody.simulation.programs.kernel_calls import kernel_calls
from symbody.simulation.programs.prepared_motion import PreparedMotion
from symbody.simulation.programs.program_function import PROJECTION, RIGHT_HAND_SIDE

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
    argument : str
        Format of an array as an argument.
    text : callable
        A text as the language writes it.
    equals, either : str
        Operators of conditions.
    """

    dialect: KernelDialect
    head: str
    main: str
    comment: str
    array: str
    argument: str
    text: Callable[[str], str]
    equals: str
    either: str

    @property
    def success(self) -> tuple[str, str]:
        """When a motion has ended as it should: without events, and with some."""
        reached = f"code {self.equals} {block.FINISHED}"
        return reached, f"{reached} {self.either} code {self.equals} {block.STOPPED}"


def _read(file: str) -> str:
    """Return what stands behind the kernels.

    Lines that begin with "%events ", "%samples ", "%jumps " belong to motions with such, "%eventless " to
    those without events, "%switching " to those with modes, "%implicit " to those by an implicit method.
    """
    return "\n" + (files(__package__) / file).read_text(encoding="utf-8")


def _c_string(text: str) -> str:
    """Return a text as C writes it, whatever is in it."""
    plain = (chr(b) if 32 <= b < 127 and chr(b) not in '"\\?' else f"\\{b:03o}" for b in text.encode("utf-8"))
    return f'"{"".join(plain)}"'


_C_HEAD: Final = f"{PREAMBLE}#include <stdio.h>\n%events #include <stdlib.h>\n\n"
LANGUAGES: Final[Mapping[str, ProgramLanguage]] = {
    "c": ProgramLanguage(C, _C_HEAD, _read("program.c"), "/* {} */", "{{{}}}", "{}", _c_string, "==", "||"),
    "javascript": ProgramLanguage(
        JAVASCRIPT,
        '"use strict";\n\n',
        _read("program.js"),
        "// {}",
        "[{}]",
        "{}, 0",
        json.dumps,
        "===",
        "||",
    ),
    "python": ProgramLanguage(
        PYTHON,
        "import math\n%events import sys\n\n\n",
        _read("program.py.txt"),
        "# {}",
        "[{}]",
        "{}, 0",
        json.dumps,
        "==",
        "or",
    ),
}


def program_text(motion: PreparedMotion, language: ProgramLanguage, title: str) -> str:
    """Return the program of a motion."""
    happens = motion.happenings
    words = {**_sizes(motion), **_arrays(motion, language), **_calls(motion, language)}
    words["STOPS"] = f", {block.STOPPED} where an event stopped the motion" if happens.labels else ""
    words["SUCCESS"] = language.success[bool(happens.labels)]
    kinds = {*happens.kinds}
    if "modes" in kinds:
        kinds.add("switching")
    kinds.add("" if "events" in kinds else "eventless")
    kinds.add("implicit" if happens.implicit.size else "")
    main = _lines_of(language.main, kinds)
    for name, text in words.items():
        main = main.replace(f"@{name}@", text)
    comments = [
        f"{title}: a whole simulation, written by symbody; it needs nothing else.",
        "It prints the samples as lines of numbers: " + ", ".join(["t", *map(_plain, motion.names)]),
        *["Events are listed on the error output."] * bool(happens.events),
    ]
    head = "".join(language.comment.format(_plain(text)) + "\n" for text in comments)
    return head + _lines_of(language.head, kinds) + kernel_text(motion.kernels, language.dialect) + main


def _lines_of(text: str, kinds: Container[str]) -> str:
    """Return a text with the lines of some kinds, and those of none."""
    lines = []
    for line in text.split("\n"):
        kind, _, rest = line.partition(" ") if line.startswith("%") else ("", "", line)
        if not kind or kind[1:] in kinds:
            lines.append(rest)
    return "\n".join(lines)


def _sizes(motion: PreparedMotion) -> dict[str, str]:
    """Return sizes, places and codes of a program."""
    run, happens = Run(motion.block), motion.happenings
    rows = run.method.dense_rows * run.states
    count = len(happens.events)
    codes = [name for name in vars(block) if isinstance(getattr(block, name), int)]
    numbers = {
        "SIZE": motion.block.size, "SAMPLES": run.room.samples, "N": len(motion.names),
        "PLACE_COUNT": np.count_nonzero(motion.block), "COUNT_PLACE": Run.layout["counts.samples"],
        "BREAKS": happens.steps + 2, "PIECES": (happens.steps + 1) * rows,
        "FIRST_ROOM": 64 + 8 * len(happens.labels),
        "RECORDED": STEPS * (len(happens.held) + 1), "TRIALS": _TRIALS,
        "DECIDED": STEPS * (3 + len(happens.ends) + len(motion.names)), "EVENT_COUNT": count,
        "ROOM_PLACE": EventMonitor.layout["happened_room"], "HAPPENED_PLACE": EventMonitor.layout["happened"],
        "CULPRIT_PLACE": EventMonitor.layout["culprit"], "RECORDED_PLACE": SampleHold.layout["recorded"],
        **{name: getattr(block, name) for name in codes},
    }  # fmt: skip
    return {name: str(number) for name, number in numbers.items()}


def _arrays(motion: PreparedMotion, language: ProgramLanguage) -> dict[str, str]:
    """Return the numbers with which a program begins."""
    happens = motion.happenings
    places = np.flatnonzero(motion.block)
    words = {
        "PLACES": _list(language, map(str, places)),
        "VALUES": _numbers(language, motion.block[places]),
        "TIMES": _numbers(language, motion.times),
        "HEADER": json.dumps(",".join(["t", *(_plain(name) for name in motion.names)])),
        "EVENTS": _list(language, map(language.text, happens.labels)),
    }
    arrays = {
        "MONITOR": happens.monitor,
        "HELD": happens.hold,
        "SAMPLING": happens.sampling,
        "JUMPS": happens.jumps,
        "MODES": happens.modes,
        "IMPLICIT": happens.implicit,
    }
    for name, array in arrays.items():
        words[name], words[f"{name}_SIZE"] = _numbers(language, array), str(array.size)
    return words


def _calls(motion: PreparedMotion, language: ProgramLanguage) -> dict[str, str]:
    """Return the calls of kernels in a program."""
    projection = PROJECTION if motion.is_projected else RIGHT_HAND_SIDE
    return kernel_calls(motion.happenings, projection, CLOSING, language.argument, _TRIALS)


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
