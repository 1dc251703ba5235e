"""Operands of `min` and `max` have no effects: in C and JavaScript, where `b > a ? b : a` stands, they happen twice."""

from __future__ import annotations

from pathlib import Path

import symbody.kernels
from symbody.codegen.kernels.reader import read_kernels
from symbody.codegen.kernels.tree import Apply, Call, KernelTree, walk

FOLDER = Path(symbody.kernels.__file__).parent
# Files that a program or a motion begins with, and with them all that they call.
ROOTS = {
    "motion_loop": ("begin_motion", "advance_motion"),
    "lane_stepping": ("step_all",),
    "many_motions": ("run_cases",),
    "impulse_machine": ("advance_impulses",),
    "stepping": ("step",),
    "given_steps": ("process_given", "break_off"),
    "noted_events": ("process_noted",),
}


def has_effects(call: Call, kernels: dict[str, KernelTree]) -> bool:
    return call.is_parameter or any(p.is_changed for p in kernels[call.kernel].parameters)


def test_operands_of_min_and_max_change_nothing() -> None:
    """A mode that was decided was not written down in programs, since the second call found nothing new."""
    kernels: dict[str, KernelTree] = {}
    for module, roots in ROOTS.items():
        kernels |= read_kernels(module, *roots)
    assert len(kernels) > 300
    found = [
        (name, node.operator, call.kernel)
        for name, kernel in kernels.items()
        for node in walk(kernel.body)
        if isinstance(node, Apply) and node.operator in ("min", "max")
        for call in walk(node.operands)
        if isinstance(call, Call) and has_effects(call, kernels)
    ]
    assert found == []
