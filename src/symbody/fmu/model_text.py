"""`model.h`: the kernels, functions, sizes and tables of one mechanism, which `core` computes with."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Final

import numpy as np

from symbody.codegen.kernels.c_kernels import PREAMBLE, C
from symbody.codegen.kernels.dialect import PREFIX
from symbody.codegen.kernels.reader import read_kernels
from symbody.codegen.kernels.text_writer import kernel_text
from symbody.codegen.kernels.tree import KernelTree, Type
from symbody.equations.solving.unilateral import unilateral_row
from symbody.fmu.program import FUNCTION, SPAN, FmuProgram
from symbody.fmu.variables import FmuVariable, held_states
from symbody.kernels import block, features
from symbody.kernels.block import Breakpoint, FunctionNumbers, Run, StateProjection
from symbody.kernels.configurations.assembly_problem import AssemblyProblem
from symbody.kernels.configurations.strike import STRUCK, TORN
from symbody.kernels.configurations.strike_problem import StrikeProblem
from symbody.kernels.events import event_monitor
from symbody.kernels.events.event_monitor import EventMonitor, MonitoredEvent
from symbody.kernels.implicit.implicit_block import ImplicitStep
from symbody.kernels.modes.mode_state import SETTLED
from symbody.kernels.modes.mode_switch import SHOCK, ModeSwitch, SwitchingElement
from symbody.kernels.record_layout import RecordLayout
from symbody.kernels.samples.sample_hold import SampleHold
from symbody.simulation.methods.constraints import residual_share
from symbody.simulation.native.description import Floats

# Constraints open by more than this share of their size are closed at the end of an importer's step.
OPEN: Final = 2e-7
_MECHANISM: Final = f"{PREFIX}{FUNCTION}"  # begins the names of its functions in C
_LAST_STEPS: Final = 8  # that stay where there is no room for more: zeros of events lie in them
_KERNELS: Final = (
    ("step_machine", ("begin", "advance")),
    ("dense_output", ("interpolate",)),
    ("projection", ("project",)),
    ("closing", ("close_state", "note_followers")),
    ("runge_kutta", ("call",)),
    ("solve_saddle", ("solve_saddle",)),
    ("sampling", ("take_samples", "is_due", "is_instant", "piece_end", "find_next")),
)
_EVENT_KERNELS: Final = (
    ("event_watch", ("look",)),
    ("event_location", ("compute_values",)),
    (
        "event_interruptions",
        ("values_before", "watch_behind", "rewind_events", "forget_steps", "end_with_state"),
    ),
    ("noted_events", ("look_at_sides", "note_events", "note_start", "process_noted")),
)
_MODE_KERNELS: Final = (
    ("mode_state", ("show_modes", "forget_modes", "note_rates")),
    ("switch_modes", ("settle_modes", "find_overlap", "slight_value")),
    ("end_of_shares", ("shares_hold",)),
    ("switching_motion", ("note_ends", "forget_ends", "watch_shares")),
)
_FEATURES: Final = frozenset(features.__annotations__)  # those that a motion may have
_STRIKE_KERNELS: Final = (("strike", ("strike",)),)
_IMPLICIT_KERNELS: Final = (("implicit_machine", ("begin_implicit", "advance_implicit")),)
_CODES: Final = ("RUNNING", "FINISHED", "COLLAPSED", "NOT_FINITE", "SINGULAR", "TOO_MANY")
_FOUND: Final = ("NOTHING_YET", "GOES_ON", "ENDS", "CHATTERS", "NO_ROOM", "FAILS", "SPOILS", "MISSES")
# What the names of the places of a record begin with.
_RECORDS: Final[Mapping[str, type[RecordLayout]]] = {
    "RUN": Run, "BREAK": Breakpoint, "NUMBERS": FunctionNumbers, "PROJECTOR": StateProjection,
    "W": EventMonitor, "E": MonitoredEvent, "Z": SampleHold, "S": ModeSwitch, "M": SwitchingElement,
}  # fmt: skip
# Functions whose numbers lie in a block: where that tells their place.
_INNER_NUMBERS: Final = {
    "motion": ("run", Run.layout["numbers"]),
    "assembly": ("closing", AssemblyProblem.fields["numbers"].place),
    "turn": ("implicit", ImplicitStep.layout["rate_numbers"]),
    "jacobian": ("implicit", ImplicitStep.layout["derivative_numbers"]),
    "strike": ("struck", StrikeProblem.fields["numbers"].place),
    "deciding": ("switch", ModeSwitch.fields["numbers"].place),
}
# Those whose numbers lie in a record of the run: where it tells of the record, and that of the numbers.
_RECORDS_OF_RUN: Final = {
    "projection": (Run.layout["projection"], StateProjection.layout["numbers"]),
    "gaps": (Run.layout["gaps"], EventMonitor.layout["numbers"]),
}
# What `sb_functions` holds in this order, by the name of its index.
_PURPOSES: Final = {
    "motion": "SB_MOTION", "slope": "SB_SLOPE", "output": "SB_OUTPUT", "derivatives": "SB_DERIVATIVES",
    "sensitivities": "SB_SENSITIVITIES", 
    "parameters": "SB_PARAMETERS", "sides": "SB_SIDES",
    "samples": "SB_SAMPLING", "periods": "SB_PERIODS",
}  # fmt: skip
_FUNCTION: Final = """
typedef struct {
    symbody_function call, values; /* values: what depends on parameters alone, or NULL */
    int numbers;                   /* where its numbers begin in the pool of an instance */
} SbFunction;
"""


def model_text(program: FmuProgram, variables: Sequence[FmuVariable], token: str) -> str:
    """Return the header of a mechanism."""
    kernels: dict[str, KernelTree] = {}
    modal, scales = program.modal.eqs, program.motion.integration.problem.scales
    rare = [
        *(_EVENT_KERNELS if program.watched_events else ()),
        *(_IMPLICIT_KERNELS if "jacobian" in program.functions else ()),
        *(_STRIKE_KERNELS if "strike" in program.functions else ()),
        *(_MODE_KERNELS if program.modal.modes else ()),
    ]
    parts = _FEATURES if "gaps" in program.functions else _FEATURES - {"GAPS"}
    for file, roots in (*_KERNELS, *rare):
        kernels |= read_kernels(file, *roots, features=parts)
    for function in program.functions.values():
        kernels |= function.kernels
    pool, places = _pool(program)
    filled = np.flatnonzero(pool)
    eqs, given = program.eqs, program.parameters
    free = [variable.initial == "exact" for variable in variables[1 : 1 + len(eqs.state_names)]]
    tables = [
        _table("int", "sb_places", map(str, filled)),
        _numbers("sb_values", pool[filled]),
        _numbers("sb_x", program.x0),
        _numbers("sb_nominal", program.nominal),
        _numbers("sb_p", given.values),
        _numbers("sb_scales", scales.constraints(modal)[: len(modal.formed.holonomic)]),
        _flags("sb_is_given", free),
        _flags("sb_is_held", held_states(program.eqs, free)),
        _flags("sb_is_fixed", [name in given.fixed for name in given.arguments]),
        _flags("sb_closes", program.closing_parameters),
        _flags("sb_is_floor", [condition.is_floor for condition in program.conditions]),
        _numbers("sb_jumps", (t for t, _ in program.jumps.times)),
        _numbers("sb_jump_margins", (margin for _, margin in program.jumps.times)),
        _table("char *const", "sb_names", (_string(variable.name) for variable in variables), "const "),
        _table("char *const", "sb_elements", map(_string, program.modal.names), "const "),
        _flags("sb_stops", _stops(program)),
        _functions(program, places),
    ]
    sizes = _sizes(program, pool, places) | {"SB_TOKEN": _string(token)}
    title = f"/* {_plain(eqs.model.name)}, written by symbody: what the C of the FMU computes with. */\n"
    head = "".join(f"#define {name} {value}\n" for name, value in sizes.items())
    return "\n".join([title, PREAMBLE, head, kernel_text(kernels, C), _FUNCTION, *tables])


def _pool(program: FmuProgram) -> tuple[Floats, Mapping[str, int]]:
    """Return the numbers of an instance at first, and where those of each function begin."""
    motion, watch, switch = program.block(), program.watch(), program.switch()
    blocks = {
        "run": motion, "closing": program.assembly(),
        "sampler": program.samples.block(len(program.eqs.speed_names)), "implicit": program.implicit(),
        "watch": watch, "struck": program.strike(), "switch": switch,
    }  # fmt: skip
    ends = np.cumsum([block.size for block in blocks.values()]).tolist()
    places: dict[str, int] = dict(zip(blocks, [0, *ends], strict=False))
    parts, size = list(blocks.values()), ends[-1]
    for name, function in program.functions.items():
        if name in _RECORDS_OF_RUN:
            record, numbers = _RECORDS_OF_RUN[name]
            begin = int(motion[record])
            places[name] = begin + int(motion[begin + numbers])
        elif name in _INNER_NUMBERS:
            block, place = _INNER_NUMBERS[name]
            places[name] = places[block] + int(blocks[block][place])
        else:
            places[name] = size
            parts.append(function.array)
            size += function.array.size
    if watch.size:  # numbers of functions lie before and behind it, as does what closes states
        for field, name in (("numbers", "indicators"), ("actions", "action"), ("closing", "closing")):
            if name in program.functions or (name in blocks and blocks[name].size):
                watch[EventMonitor.fields[field].place] = places[name] - places["watch"]
    if switch.size:  # what projects takes the same numbers as steps do
        switch[ModeSwitch.fields["projection"].place] = places["projection"] - places["switch"]
    scratch = max(function.values_size for function in program.functions.values())
    return np.concatenate([*parts, np.zeros(scratch + 1)]), places | {"scratch": size}


def _sizes(program: FmuProgram, pool: Floats, places: Mapping[str, int]) -> dict[str, str]:
    eqs, functions = program.eqs, program.functions
    n, n_r, scales = len(eqs.state_names), len(eqs.input_names), program.motion.integration.problem.scales
    output = functions["output"]
    rows = output.size + n if "derivatives" in functions else 0
    dense = Run(program.block()).method.dense_rows
    numbers = {
        "SB_X": n, "SB_U": len(eqs.speed_names), "SB_Q": len(eqs.coordinate_names),
        "SB_R": n_r, "SB_SAMPLED": len(program.samples.values), "SB_SAMPLER": places["sampler"],
        "SB_P": len(program.parameters.arguments),
        "SB_CALCULATED": len(program.parameters.calculated), "SB_CONSTRAINTS": output.sizes[0],
        "SB_OUTPUTS": output.size, "SB_SHOWN": output.size - output.sizes[0] + 1,
        "SB_EVENTS": len(program.events), "SB_CONDITIONS": len(program.conditions),
        "SB_ELEMENTS": len(program.modal.modes), "SB_SWITCH": places["switch"],
        "SB_WATCHED": program.indicator_count, "SB_HAPPENED": program.happened_room,
        "SB_SLOPES": rows * (n + n_r),
        "SB_HAS_DERIVATIVES": int(rows > 0), "SB_POOL": pool.size, "SB_PLACES": np.count_nonzero(pool),
        "SB_SCRATCH": places["scratch"], "SB_BLOCK": 0, "SB_ASSEMBLY": places["closing"],
        "SB_HELD": AssemblyProblem.fields["asked"].place, "SB_IS_CLOSED": int("assembly" in functions),
        "SB_PROJECTED": int(program.is_projected), "SB_IS_FIXED": int(program.motion.has_one_length),
        "SB_IS_IMPLICIT": int("jacobian" in functions), "SB_IMPLICIT": places["implicit"],
        "SB_WATCH": places["watch"], "SB_STRIKE": places["struck"],
        "SB_IS_STRUCK": int("strike" in functions),
        "SB_JUMPS": len(program.jumps.times), "SB_ARE_MORE_JUMPS": int(program.jumps.are_more),
        "SB_DENSE_ROWS": dense, "SB_STEPS": program.steps, "SB_LAST_STEPS": _LAST_STEPS,
    }  # fmt: skip
    indices = {
        word: list(functions).index(name) if name in functions else 0 for name, word in _PURPOSES.items()
    }
    numbers |= {"SB_FUNCTIONS": len(functions)} | indices
    numbers |= {f"SB_{name}": getattr(block, name) for name in _CODES}
    numbers |= {f"SB_{name}": getattr(event_monitor, name) for name in _FOUND}
    numbers |= {"SB_STRUCK": STRUCK, "SB_TORN": TORN, "SB_SHOCK": int(SHOCK)}
    for prefix, record in _RECORDS.items():
        numbers |= {
            f"SB_{prefix}_{name.replace('.', '_').upper()}": place for name, place in record.layout.items()
        }
    numbers["SB_RUN_BREAKS"] = Run.fields["breaks"].place
    numbers["SB_EVENT_SIZE"], numbers["SB_BREAK_SIZE"] = MonitoredEvent.size, Breakpoint.size
    numbers["SB_ELEMENT_SIZE"], numbers["SB_SETTLED"] = SwitchingElement.size, SETTLED
    texts = {
        "SB_SPAN": repr(SPAN), "SB_TIME_SCALE": repr(scales.time),
        "SB_CLOSED": repr(residual_share(program.motion.projection, None)),
        "SB_OPEN": repr(OPEN),
        "SB_PROJECTION": f"{_MECHANISM}{'projection' if program.is_projected else 'motion'}",
        "SB_GAP_FUNCTION": f"{_MECHANISM}{'gaps' if 'gaps' in functions else 'motion'}",
        "SB_WATCHED_FUNCTION": f"{_MECHANISM}{'indicators' if program.watched_events else 'motion'}",
        "SB_ACTION_FUNCTION": f"{_MECHANISM}{'action' if 'action' in functions else 'motion'}",
        "SB_SAMPLE_FUNCTION": f"{_MECHANISM}{'samples' if program.samples.values else 'motion'}",
        "SB_ASSEMBLY_FUNCTION": f"{_MECHANISM}{'assembly' if 'assembly' in functions else 'motion'}",
    }  # fmt: skip
    return {name: str(value) for name, value in numbers.items()} | texts


def _functions(program: FmuProgram, places: Mapping[str, int]) -> str:
    rows = []
    for name, function in program.functions.items():
        values = f"{PREFIX}{function.values}" if function.values else "NULL"
        rows.append(f"{{{_MECHANISM}{name}, {values}, {places[name]}}}")
    return _table("SbFunction", "sb_functions", rows)


def _numbers(name: str, values: Iterable[float]) -> str:
    return _table("double", name, (C.literal(float(value), Type.REAL) for value in values))


def _stops(program: FmuProgram) -> Iterator[bool]:
    """Yield which of the elements with modes are stops."""
    formed = program.modal.eqs.formed
    yield from (False for _ in program.modal.joints)
    yield from (unilateral_row(formed, name).sense > 0 for name in program.modal.gaps)


def _flags(name: str, values: Iterable[bool]) -> str:
    return _table("int", name, (str(int(value)) for value in values))


def _table(kind: str, name: str, items: Iterable[str], before: str = "") -> str:
    """Return a constant array; where there are no items one entry stands for them."""
    words = list(items) or ["0"]
    lines = (", ".join(words[k : k + 8]) for k in range(0, len(words), 8))
    constant = "" if kind.endswith("const") else "const "
    return f"static {before}{constant}{kind} {name}[] = {{\n    " + ",\n    ".join(lines) + "\n};\n"


def _string(text: str) -> str:
    """Return a literal of C in ASCII."""
    return json.dumps("".join(letter if letter.isascii() else "?" for letter in text))


def _plain(name: str) -> str:
    return "".join(letter if letter.isalnum() or letter in " _-.,:()" else "?" for letter in name)
