"""`generate_simulation`: a motion as a program that stands alone."""

from __future__ import annotations

import json
from collections.abc import Callable, Container, Iterable, Mapping, Sequence
from dataclasses import dataclass
from importlib.resources import files
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from symbody.arguments import checked_arguments, named_after
from symbody.codegen.formation.names import Value
from symbody.codegen.kernels.c_kernels import PREAMBLE, C
from symbody.codegen.kernels.dialect import KernelDialect
from symbody.codegen.kernels.featured import without_unused
from symbody.codegen.kernels.javascript_kernels import JAVASCRIPT
from symbody.codegen.kernels.python_kernels import PYTHON
from symbody.codegen.kernels.text_writer import kernel_text
from symbody.codegen.kernels.tree import KernelTree, Type
from symbody.equations.equation_set import EquationSet
from symbody.errors import Problem, UsageError
from symbody.kernels import block
from symbody.kernels.block import Run
from symbody.kernels.events.event_monitor import EventMonitor
from symbody.kernels.record_layout import exists
from symbody.kernels.samples.sample_hold import SampleHold
from symbody.simulation.events.events import Event, check_events
from symbody.simulation.inputs.input_laws import Law, input_laws, laws_of_tables
from symbody.simulation.methods.constraints import Baumgarte, Projection
from symbody.simulation.methods.explicit import Explicit
from symbody.simulation.methods.fixed_step import FixedStep
from symbody.simulation.methods.implicit.generalized_alpha import GeneralizedAlpha
from symbody.simulation.native.description import Floats
from symbody.simulation.programs.happenings import CLOSING, STEPS, Happenings, kernel_calls, make_happenings
from symbody.simulation.programs.motion_request import (
    MotionRequest,
    PosedMotion,
    pose_motion,
    reason_for_program,
    with_modes,
)
from symbody.simulation.programs.program_function import (
    PROJECTION,
    RIGHT_HAND_SIDE,
    implicit_array,
    motion_block,
    motion_functions,
)

_SAMPLES = 101


@named_after(3)
@checked_arguments
def generate_simulation(
    eqs: EquationSet, t_end: float | tuple[float, float], language: str = "c",
    initial: Mapping[str, Value] | None = None, guess: Mapping[str, Value] | None = None,
    parameters: Mapping[str, Value] | None = None, inputs: Mapping[str, Law] | None = None,
    times: ArrayLike | None = None, integrator: Explicit | FixedStep | GeneralizedAlpha | None = None,
    constraints: Projection | Baumgarte | None = None, events: Event | Sequence[Event] = (), *,
    rtol: float = 1e-8, atol: float | None = None,
    scales: Mapping[str, float] | None = None, max_steps: int = 1_000_000,
) -> str:  # fmt: skip
    """Return a program that computes a motion as `simulate` does, and needs nothing else.

    It holds the equations, the integrator with its projection, and the first state, and prints the samples:
    time, speeds, coordinates, work. Joints stick and slip, gaps close and open, as in `simulate`. Events are
    listed on the error output, name and time in each line. The
    programs in all languages print the same numbers to the last bit, as long as the equations use no function
    beyond sine, cosine, roots and whole powers, which languages compute in their own ways. They agree with
    `simulate` to the tolerance.

    Parameters
    ----------
    eqs : EquationSet
        The equations of the mechanism.
    t_end : float or (t0, t_end)
        End time [s], or both ends.
    language : str
        "c" for C99 (to be compiled with ``-ffp-contract=off``), "javascript" for Node and browsers, where
        ``simulate()`` returns the samples and what happened, or "python", without any package.
    initial, guess : mapping of name to number or formula, optional
        The first state, as for `simulate`.
    parameters, inputs : mapping, optional
        Values and laws that are written into the program, as for `simulate`.
    times : array, optional
        The samples; by default 101 from the first to the last time.
    integrator, constraints : optional
        ``Explicit(..)``, ``FixedStep(..)`` or, for stiff mechanisms without samples, dry friction and gaps,
        ``GeneralizedAlpha(..)``; ``Projection(..)`` or ``Baumgarte(..)``.
    events : Event or sequence of Event
        What is looked for, as for `simulate`.
    rtol, atol, scales, max_steps : optional
        Tolerances and the limit of steps, as for `simulate`.

    Returns
    -------
    str
        The text of the program.

    Raises
    ------
    UsageError
        An unknown language, or a motion that `simulate` computes in part by Python: inputs that are
        functions.
    CompileError, AssemblyError
        As `simulate`.

    Examples
    --------
    >>> import symbody as sb
    >>> rail = sb.Prismatic("rail", "ground", sb.Body("Cart", mass=2), axis="x", coordinate="x",
    ...                     force=sb.Drive(applied="F", stiffness=8))
    >>> model = sb.Model("oscillator", [rail], inputs=["F"], initial={"x": 0.1})
    >>> eqs = sb.form_equations(model)
    >>> program = sb.generate_simulation(eqs, 1.0, language="python")
    >>> "def simulate" in program
    True
    """
    if language not in LANGUAGES:
        fix = f"choose one of {', '.join(LANGUAGES)}"
        what = f"programs cannot be generated in {language!r}"
        raise UsageError(Problem("simulation.language", "language", what, "", fix))
    span = t_end if isinstance(t_end, tuple) else (0.0, t_end)
    watched = check_events(events, eqs)
    laws = input_laws(eqs.input_names, {**laws_of_tables(eqs), **(inputs or {})}, span)
    reason = reason_for_program(eqs, laws, integrator, constraints)
    if reason:
        fix = "give inputs as formulas, or use simulate"
        raise UsageError(
            Problem(
                "simulation.program", "", f"this motion cannot be generated as a program: {reason}", "", fix
            )
        )
    request = MotionRequest(
        initial or {}, parameters or {}, inputs or {}, integrator=integrator, constraints=constraints,
        rtol=rtol, atol=atol, span=span, last=span[1], is_pulled=False, guess=guess, scales=scales,
        max_steps=max_steps, times=np.linspace(*span, _SAMPLES) if times is None else times, events=watched,
    )  # fmt: skip
    motion = prepare_motion(with_modes(pose_motion(eqs, request, laws)))
    return program_text(motion, LANGUAGES[language], eqs.model.name)


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


@dataclass(frozen=True, slots=True, eq=False)
class PreparedMotion:
    """A motion that can be computed without symbody.

    Attributes
    ----------
    kernels : mapping of name to KernelTree
        The integrator, the right-hand side and what projects, each behind those that it calls.
    block : array
        The run at its beginning, see `symbody.kernels.block`.
    times : array
        The samples [s].
    names : tuple of str
        Of the states; the last one is the work.
    happenings : Happenings
        What happens on the way.
    """

    kernels: Mapping[str, KernelTree]
    block: Floats
    times: Floats
    names: tuple[str, ...]
    happenings: Happenings

    @property
    def is_projected(self) -> bool:
        """Whether states are moved onto constraints."""
        return bool(exists(Run(self.block).projection))


def prepare_motion(motion: PosedMotion) -> PreparedMotion:
    """Return a motion as kernels and numbers, portable to the bit."""
    functions = motion_functions(motion)
    block = motion_block(motion, functions)
    happenings = make_happenings(motion, block, implicit_array(motion, functions))
    kernels = without_unused(happenings.kernels)
    for function in (functions | dict(happenings.functions)).values():
        kernels |= function.kernels
    times = np.asarray(motion.integration.times, dtype=np.float64)
    room = Run(block).room
    room.times, room.samples = times.size, times.size + happenings.more_samples
    room.keep_dense, room.steps = float(bool(happenings.steps)), happenings.steps
    return PreparedMotion(kernels, block, times, (*motion.eqs.state_names, "work"), happenings)


def program_text(motion: PreparedMotion, language: ProgramLanguage, title: str) -> str:
    """Return the program of a motion."""
    happens = motion.happenings
    projection = PROJECTION if motion.is_projected else RIGHT_HAND_SIDE
    calls = kernel_calls(happens, projection, CLOSING, language.argument, _TRIALS)
    words = {**_sizes(motion), **_arrays(motion, language), **calls}
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
        "DECIDED": STEPS * (3 + len(happens.others) + len(motion.names)), "EVENT_COUNT": count,
        "ROOM_PLACE": EventMonitor.layout["happened_room"], "HAPPENED_PLACE": EventMonitor.layout["happened"],
        "CULPRIT_PLACE": EventMonitor.layout["culprit"], "RECORDED_PLACE": SampleHold.layout["recorded"],
        **{name: getattr(block, name) for name in codes},
    }  # fmt: skip
    return {name: str(number) for name, number in numbers.items()}


def _arrays(motion: PreparedMotion, language: ProgramLanguage) -> dict[str, str]:
    happens = motion.happenings
    places = np.flatnonzero(motion.block)
    words = {
        "PLACES": _list(language, map(str, places)),
        "VALUES": _numbers(language, motion.block[places]),
        "TIMES": _numbers(language, motion.times),
        "HEADER": json.dumps(",".join(["t", *(_plain(name) for name in motion.names)])),
        "EVENTS": _list(language, map(language.text, happens.labels)),
    }
    for name, array in happens.arrays.items():
        words[name.upper()], words[f"{name.upper()}_SIZE"] = _numbers(language, array), str(array.size)
    return words


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
