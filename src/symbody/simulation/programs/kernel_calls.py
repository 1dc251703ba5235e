"""The calls of kernels in programs, by what happens on the way of a motion."""

from __future__ import annotations

from collections.abc import Iterable

from symbody.codegen.kernels.dialect import PREFIX
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
    made, f, e = happens.functions, RIGHT_HAND_SIDE, EVENTS
    watched, sampled = "events" in happens.kinds, "samples" in happens.kinds
    acting = [e, ACTIONS if ACTIONS in made else e, closing if CLOSING in made else e] * watched
    sampling, monitor, happened = [SAMPLES] * sampled, ["monitor"] * watched, ["happened"] * watched
    held, recorded, record = (
        ["held", "sampling"] * sampled,
        ["recorded"] * sampled,
        ["times", "t", "x", "breaks"],
    )

    def call(kernel: str, functions: Iterable[str], arrays: Iterable[str], *numbers: object) -> str:
        words = [f"{PREFIX}{name}" for name in functions]
        words += [argument.format(array) for array in arrays]
        return f"{PREFIX}{kernel}({', '.join([*words, *map(str, numbers)])})"

    is_implicit = bool(happens.implicit.size)
    method, kept = [TURN, DERIVATIVES] * is_implicit, ["implicit"] * is_implicit
    everything = ["block", *kept, *monitor, *held, *record, "pieces", *happened, *recorded]
    passing = ["block", *kept, *monitor, "jumps", *record, *["pieces"] * watched]
    common = {
        "FORGET": call("forget_steps", [], ["block", "monitor", "breaks", "pieces"], LAST_STEPS),
        "SHOW": call("show_watch", [], ["monitor", "held"]),
        "NOTE": call("values_before", [e], ["block", "monitor"]),
        "REWIND_EVENTS": call("rewind_events", [], ["monitor", "happened"], "time"),
        "REWIND_SAMPLES": call("rewind_samples", [], ["held", "recorded"], "time"),
        "BOUND": call("end_before_jump", [], ["block", "jumps"]),
    }
    if "modes" in happens.kinds:
        sampling, modes = [SAMPLES if SAMPLES in made else e], [DECIDING, FITTING]
        searched, written = ["block", "monitor", *held], ["recorded", "decided"]
        return common | {
            "BEGIN": call(
                happens.first_kernel, [f, *sampling, *modes], [*searched, "modes", *record, *written]
            ),
            "ADVANCE": call(
                happens.loop_kernel, [f, projection, *acting, *sampling, *modes],
                [*searched, "modes", *record, "pieces", "happened", *written], trials,
            ),
            "PASS": call(
                happens.jump_kernel, [f, STRIKE, e, *modes],
                [*searched, "jumps", "modes", *record, "pieces", "decided"],
            ),
            "WATCH": call("watch_switching", [e], ["block", "monitor", "held", "modes"]),
            "FORGET_ROWS": call("forget_rows", [], ["modes", "decided"]),
            "REWIND_MODES": call("rewind_modes", [], ["modes", "decided"], "time"),
            "FORGET_MODES": call("forget_modes", [], ["modes"]),
        }  # fmt: skip
    return common | {
        "BEGIN": call(happens.first_kernel, [f, *sampling], ["block", *kept, *held, *record, *recorded]),
        "ADVANCE": call(
            happens.loop_kernel, [f, *method, projection, *acting, *sampling], everything, trials
        ),
        "PASS": call(happens.jump_kernel, [f, STRIKE, *[e] * watched], passing),
        "WATCH": call("watch_again", [e], ["block", "monitor"]),
    }
