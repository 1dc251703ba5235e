"""What ``symbody simulate`` prints of a motion, as lines or as JSON."""

from __future__ import annotations

import json

from symbody.equations.equation_set import EquationSet
from symbody.simulation.results.trajectory import Trajectory


def motion_lines(eqs: EquationSet, motion: Trajectory) -> list[str]:
    """Return the notes, how the motion ended, and what it cost."""
    statistics = motion.statistics
    return [
        *(f"note: {note}" for note in (*eqs.notes, *motion.notes)),
        f"{motion.status.value}: t = {motion.t[0]:g} to {motion.t[-1]:g} s",
        f"{statistics.accepted} steps, {statistics.evaluations} evaluations, "
        f"{statistics.loop_seconds * 1e3:.2f} ms; energy drift {motion.energy_drift:.1e} J",
        *_loop_gaps(eqs, motion),
    ]


def _loop_gaps(eqs: EquationSet, motion: Trajectory) -> list[str]:
    """Return how far loops open on the way, as a share of lengths and in radians; nothing of trees."""
    if not eqs.multiplier_names:
        return []
    return [
        f"constraints: {len(eqs.multiplier_names)}, largest error {motion.constraint_violation.max():.1e}"
    ]


def motion_json(eqs: EquationSet, motion: Trajectory) -> str:
    """Return states and notes as JSON."""
    states = {name: motion[name].tolist() for name in eqs.state_names}
    entries = {"success": motion.success, "status": motion.status.name, "notes": [*eqs.notes, *motion.notes]}
    return json.dumps({**entries, "t": motion.t.tolist(), "states": states})
