"""Operations of forward dynamics of robots, and what each trick of the recursion saves.

The robots are those of the package example-robot-data, which has to be installed; a robot that is not found
is left out, and a note says so. All numbers of a robot are known when it is compiled.
"""

from __future__ import annotations

import sysconfig
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import Final

import symbody as sb
from benchmarks.table import Table, ratio_text, seconds_text
from benchmarks.timing import Settings, seconds
from symbody.codegen.formation.sequences import form_sequence
from symbody.expr.sequences.folding import fold_constants


@dataclass(frozen=True, slots=True)
class Robot:
    """A file below the folder of robots, whether its base floats, and the figures of the prototype."""

    path: str
    floating: bool
    plain: int
    best: int


ROBOTS: Final[Mapping[str, Robot]] = MappingProxyType(
    {
        "ur5": Robot("ur_description/urdf/ur5_robot.urdf", False, 888, 649),
        "panda": Robot("panda_description/urdf/panda.urdf", False, 2281, 1889),
        "anymal": Robot("anymal_b_simple_description/robots/anymal.urdf", True, 4758, 4151),
        "g1": Robot("g1_description/urdf/g1_29dof_rev_1_0.urdf", True, 12787, 10815),
        "talos": Robot("talos_data/robots/talos_full_v2.urdf", True, 16201, 13804),
    }
)

ROBOTS_FOLDER: Final = "cmeel.prefix/share/example-robot-data/robots"

TRICKS: Final[Mapping[str, sb.VirtualWork | sb.Recursive]] = MappingProxyType(
    {
        "virtual work": sb.VirtualWork(),
        "recursion": sb.Recursive(aligned=False, regrouped=False),
        "+ axes": sb.Recursive(regrouped=False),
        "+ base": sb.Recursive(),
        "composite": sb.Recursive("composite"),
        "articulated": sb.Recursive("articulated"),
    }
)

# Virtual work beyond this many speeds takes minutes.
_MOST: Final = 20


def tables(
    settings: Settings, robots: Mapping[str, Robot] = ROBOTS, folder: Path | None = None
) -> Iterator[Table]:
    """Yield the one table of robots."""
    where = folder if folder is not None else Path(sysconfig.get_path("purelib"), ROBOTS_FOLDER)
    rows, notes = [], ["operations of udot; in brackets beside the prototype's figure of the same kind"]
    for name, robot in robots.items():
        path = where / robot.path
        if path.is_file():
            rows.append(row(name, robot, unconstrained(sb.load_urdf(path, floating_base=robot.floating))))
        else:
            notes.append(f"{name} is not installed: {robot.path}")
    columns = ("robot", "speeds", *TRICKS, "bias", "form", "sequence")
    yield Table("robots", columns, tuple(rows), tuple(notes))


def row(name: str, robot: Robot, model: sb.Model) -> tuple[str, ...]:
    """Return the counts of one robot, and the time from the model to the sequence."""
    cells: list[str] = []
    speeds = 0
    for trick, formulation in TRICKS.items():
        if trick == "virtual work" and speeds_of(model) > _MOST:
            cells.append("")
            continue
        eqs = sb.form_equations(model, formulation)
        speeds = len(eqs.speed_names)
        reference = {"recursion": robot.plain, "+ base": robot.best}.get(trick)
        count = operations(eqs, ("udot",))
        cells.append(f"{count}{ratio_text(count, reference)}")
    made: list[sb.EquationSet] = []
    form = seconds(lambda: made.append(sb.form_equations(model)))
    line = seconds(partial(operations, made[0], ("udot",)))
    bias = operations(made[0], ("bias",))
    return (name, str(speeds), *cells, str(bias), seconds_text(form), seconds_text(line))


def unconstrained(model: sb.Model) -> sb.Model:
    """Return the tree alone: joints that mimic others move by themselves, as in the prototype."""
    elements = [element for element in model.elements if element not in model.constraints]
    return sb.Model(
        model.name,
        elements,
        gravity=model.gravity,
        parameters=model.parameters,
        inputs=model.inputs,
        ground=dict(model.ground.items()),
    )


def speeds_of(model: sb.Model) -> int:
    """Return the number of speeds of a tree."""
    return sum(len(joint.coordinates) for joint in model.joints)


def operations(eqs: sb.EquationSet, outputs: Sequence[str]) -> int:
    """Return the operations of outputs with the constants of the model computed before."""
    return fold_constants(form_sequence(eqs, outputs)[0]).operation_count
