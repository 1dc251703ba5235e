"""The calls of kernels in programs, by what happens on the way of a motion."""

from __future__ import annotations

from collections.abc import Iterable

from symbody.codegen.kernels.dialect import PREFIX
from symbody.codegen.kernels.featured import without_unused
from symbody.codegen.kernels.tree import Type
from symbody.simulation.programs.happenings import (
    ACTIONS,
    CLOSING,
    DECIDING,
    EVENTS,
    FITTING,
    LAST_STEPS,
    SAMPLES,
    STRIKE,
    Happenings,
)
from symbody.simulation.programs.program_function import DERIVATIVES, RIGHT_HAND_SIDE, TURN


def kernel_calls(
    happens: Happenings, projection: str, closing: str, argument: str, trials: int
) -> dict[str, str]:
    """Return the calls of the kernels of a motion by what they do.

    Parameters
    ----------
    projection, closing : str
        The functions that project, and that close states where events act.
    argument : str
        Format of an array as an argument.
    """
    made = happens.functions
    functions = {
        "f": RIGHT_HAND_SIDE, "k": TURN, "j": DERIVATIVES, "g": projection, "e": EVENTS,
        "a": ACTIONS if ACTIONS in made else EVENTS, "c": closing if CLOSING in made else EVENTS,
        "h": SAMPLES, "s": STRIKE, "d": DECIDING, "w": FITTING,
    }  # fmt: skip
    arrays = {"run": "block", "Q": "sampling", "H": "happened", "Y": "recorded", "Z": "decided"}

    def call(kernel: str, arguments: Iterable[str], *numbers: object) -> str:
        words = [
            f"{PREFIX}{functions[name]}" if name in functions else argument.format(arrays.get(name, name))
            for name in arguments
        ]
        return f"{PREFIX}{kernel}({', '.join([*words, *map(str, numbers)])})"

    def whole(kernel: str, *numbers: object) -> str:
        parameters = without_unused(happens.loop_kernels(kernel))[kernel].parameters
        return call(kernel, [p.name for p in parameters if p.type != Type.INTEGER], *numbers)

    calls = {
        "BEGIN": whole("begin_motion"),
        "ADVANCE": whole("advance_motion", trials),
        "FORGET": call("forget_steps", ["run", "monitor", "breaks", "pieces"], LAST_STEPS),
        "NOTE": call("values_before", ["e", "run", "monitor"]),
        "REWIND_EVENTS": call("rewind_events", ["monitor", "H"], "time"),
        "REWIND_SAMPLES": call("rewind_samples", ["held", "Y"], "time"),
        "BOUND": call("end_before_jump", ["run", "jumps"]),
        "FORGET_ROWS": call("forget_rows", ["modes", "Z"]),
        "REWIND_MODES": call("rewind_modes", ["modes", "Z"], "time"),
        "FORGET_MODES": call("forget_modes", ["modes"]),
    }
    return calls | ({"WATCH": whole("watch_anew")} if "events" in happens.kinds else {})
