"""Motion of one frame relative to another: position, velocity, acceleration, orientation, angular motion."""

from __future__ import annotations

from collections.abc import Sequence

from symbody.equations.equations_of_motion import EquationsOfMotion
from symbody.errors import FormulationError, Problem
from symbody.expr.expression import Expr
from symbody.model.output_names import MOTION_WORDS
from symbody.spatial.vector import Vector, components, cross


def motion_vector(formed: EquationsOfMotion, kind: str, end: str, reference: str) -> Vector:
    """Return a vector of the motion of `end` relative to `reference`, time derivatives as seen from it.

    Parameters
    ----------
    kind : str
        "r" position of the origin, "v" and "vdot" its first and second rate, "w" and "wdot" angular velocity
        and its rate; with u' as symbols.
    """
    kinematics = formed.kinematics
    w = kinematics.angular_velocities
    if kind in ("w", "wdot"):
        turning = w[end].value - w[reference].value
        return turning if kind == "w" else kinematics.derivative(turning, reference)
    arm = kinematics.position(reference, end)
    if kind == "r":
        return arm
    velocity = kinematics.velocities[end].value - kinematics.velocities[reference].value
    velocity = velocity - cross(kinematics.tree, w[reference].value, arm)
    return velocity if kind == "v" else kinematics.derivative(velocity, reference)


def frame_motion_entries(
    formed: EquationsOfMotion, kind: str, end: str, reference: str = "ground", resolved_in: str = "ground"
) -> tuple[tuple[int, ...], list[Expr]]:
    """Return the shape and entries of a motion; "R" is the rotation matrix from `end` to `reference`.

    Raises FormulationError if the kind or a frame is unknown.
    """
    if kind not in MOTION_WORDS:
        what = f"{kind!r} is not a kind of motion"
        fix = f"write one of {', '.join(MOTION_WORDS)}"
        raise FormulationError(Problem("equations.unknown_motion", f"frame {kind}", what, "", fix))
    end, reference, resolved_in = (formed.frame(name) for name in (end, reference, resolved_in))
    tree = formed.kinematics.tree
    if kind == "R":
        return (3, 3), [entry for row in tree.matrix(reference, end) for entry in row]
    return (3,), list(components(tree, motion_vector(formed, kind, end, reference), resolved_in))


def frame_output(formed: EquationsOfMotion, words: Sequence[str]) -> tuple[tuple[int, ...], list[Expr]]:
    """Return the output "frame KIND END REF IN" or "frame R END IN"; with " x" or " xy" behind, one entry."""
    kind, *frames = filter(None, words)
    most, last, text = 2 if kind == "R" else 3, frames[-1:], " ".join(filter(None, words))
    scope, is_entry = formed.topology.output_scope, len(frames) > 1 and {*last[0]} <= {*"xyz"}
    has_entry = is_entry and (len(frames) > most or not scope.is_frame(last[0], may_be_entry=True))
    entry = frames.pop() if has_entry else ""
    if not 1 <= len(frames) <= most:
        what = f"{text!r} does not name a motion"
        why = "an output of motion is named by its kind and its frames"
        fix = 'write "frame r END REFERENCE RESOLVED_IN" or "frame R END REFERENCE"'
        raise FormulationError(Problem("equations.frame_words", f"frame {text}", what, why, fix))
    shape, values = frame_motion_entries(formed, kind, *frames)
    if not entry:
        return shape, values
    places = ["xyz".index(letter) for letter in entry]
    if len(places) != len(shape):
        what = f"{entry!r} is not an entry"
        why = f"this output has {len(shape)} ind{'ex' if len(shape) == 1 else 'ices'}"
        fix = 'end with "x" for a vector, "xy" for a matrix'
        raise FormulationError(Problem("equations.frame_entry", f"frame {text}", what, why, fix))
    return (), [values[places[0] if len(places) == 1 else 3 * places[0] + places[1]]]
