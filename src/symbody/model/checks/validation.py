"""Everything that makes a description a Model: all checks, all faults told at once."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from symbody.errors import ModelError, Problem
from symbody.expr.language.formula import Formula
from symbody.model.body import GROUND_FRAMES, Body
from symbody.model.checks.physics import check_element, check_initial, initial_problems
from symbody.model.checks.signals import collect_signals, loop_problems
from symbody.model.checks.structure import (
    coupling_problems,
    duplicate_elements,
    floating_problems,
    free_joints,
    one_body_problems,
    over_driven_problems,
)
from symbody.model.checks.symbols import (
    Meaning,
    collect_symbols,
    element_entries,
    joint_entries,
    scope_problems,
    table_entries,
)
from symbody.model.constraints.couplings import JointCoupling
from symbody.model.declarations.element_fields import Connection
from symbody.model.declarations.formula_site import FormulaSite, Scope, Triple, component_sites
from symbody.model.element import Element
from symbody.model.first_values import FirstValues
from symbody.model.frame import Frame
from symbody.model.frame_index import element_labels, frame_index, resolve_frames
from symbody.model.frozen_mapping import FrozenMapping
from symbody.model.joint import Joint
from symbody.model.numeric_checks import NumericChecks
from symbody.model.parameters import cycle_problems, parameter_values
from symbody.model.shapes.shape import BodyShape
from symbody.model.tables.lookup import Lookup


@dataclass(frozen=True, slots=True)
class Draft:
    """The parts of a model before they are checked against each other; see `Model`."""

    elements: tuple[Element, ...]
    gravity: Triple
    parameters: FrozenMapping[Formula | None]
    inputs: tuple[str, ...]
    initial: FirstValues
    ground: FrozenMapping[Frame]
    ground_shapes: tuple[BodyShape, ...]

    @property
    def bodies(self) -> tuple[Body, ...]:
        """The bodies."""
        return tuple(element for element in self.elements if isinstance(element, Body))

    @property
    def joints(self) -> tuple[Joint, ...]:
        """The joints."""
        return tuple(element for element in self.elements if isinstance(element, Joint))

    @property
    def free_joints(self) -> list[Joint]:
        """For each body without joint the one that stands for its motion."""
        return free_joints(self.bodies, self.joints)


def check_draft(draft: Draft, earlier: Iterable[Problem]) -> tuple[tuple[Element, ...], tuple[str, ...]]:
    """Return elements with addresses looked up, and remarks; a ModelError has `earlier` faults too."""
    problems = list(earlier)
    labels = element_labels(draft.elements)
    problems += duplicate_elements(draft.elements, labels)
    placed, unknown = resolve_frames(draft.elements, frame_index(draft.bodies, draft.ground), labels)
    problems += unknown
    draft = replace(draft, elements=tuple(placed))
    elements = dict(zip(labels.values(), placed, strict=True))
    joints = {label: element for label, element in elements.items() if isinstance(element, Joint)}
    if not unknown:
        problems += one_body_problems({k: x for k, x in elements.items() if isinstance(x, Connection)})
        problems += floating_problems(draft.bodies, joints.values())
        problems += over_driven_problems({k: j for k, j in joints.items() if j.start.body != j.end.body})
    couplings = {label: x for label, x in elements.items() if isinstance(x, JointCoupling)}
    problems += coupling_problems(couplings, (*joints.values(), *draft.free_joints))
    problems += _name_problems(draft, elements)
    check = _check_numbers(draft, elements)
    problems += check.problems
    if problems:
        raise ModelError(*problems)
    return draft.elements, (*_assumptions(draft), *check.notes)


def _name_problems(draft: Draft, elements: Mapping[str, Element]) -> list[Problem]:
    symbols, problems = collect_symbols(_symbol_entries(draft, elements))
    problems += cycle_problems(draft.parameters)
    problems += scope_problems("model", _model_sites(draft), symbols)
    for label, element in elements.items():
        problems += scope_problems(label, element.formula_sites(), symbols)
        if isinstance(element, Body):
            problems += scope_problems(label, element.shape_formula_sites(), symbols)
    problems += loop_problems(collect_signals(draft.elements))
    problems += _law_problems(draft, elements)
    problems += initial_problems(draft.initial, symbols, draft.joints)
    return problems + _degree_problems(draft, elements)


def _law_problems(draft: Draft, elements: Mapping[str, Element]) -> list[Problem]:
    """Return a problem for each table that cannot be the law of the input of its name."""
    problems = []
    for label, table in elements.items():
        if isinstance(table, Lookup) and table.name in draft.inputs:
            wrong = {"argument": table.argument.text != "t", "outside": table.outside != "hold"}
            problems += [
                Problem("table.law", f"{label}, {key}",
                        f"{key} = {str(getattr(table, key))!r} in a table that defines an input",
                        "a table with the name of an input defines this input as a function of time and "
                        "holds its first and last value", f"leave {key} out, or rename the table")
                for key, is_wrong in wrong.items() if is_wrong
            ]  # fmt: skip
    return problems


def _symbol_entries(draft: Draft, elements: Mapping[str, Element]) -> Iterator[tuple[str, Meaning]]:
    for name in draft.parameters:
        yield name, Meaning("parameter", f"model, parameters.{name}")
    for k, name in enumerate(draft.inputs):
        yield name, Meaning("input", f"model, inputs[{k}]")
    for label, element in elements.items():
        yield from element_entries(element, label)
        if isinstance(element, Lookup) and element.name not in draft.inputs:
            yield from table_entries(element, label, draft.parameters.keys())
    for joint in draft.free_joints:
        yield from joint_entries(joint, f"body {joint.name}")


def _model_sites(draft: Draft) -> Iterator[FormulaSite]:
    yield from component_sites("gravity", draft.gravity, Scope.CONSTANT)
    for name, formula in draft.parameters.items():
        if formula is not None:
            yield FormulaSite(f"parameters.{name}", formula, Scope.CONSTANT)
    for name, formula in draft.initial.items():
        yield FormulaSite(f"initial.{name}", formula, Scope.CONSTANT)
    for name, frame in draft.ground.items():
        yield from frame.formula_sites(f"ground.frames.{name}")
    for k, shape in enumerate(draft.ground_shapes):
        yield from shape.formula_sites(f"ground.shape[{k}]")


def _degree_problems(draft: Draft, elements: Mapping[str, Element]) -> list[Problem]:
    """Return a problem for each value in degrees that is not an angle."""
    angles: set[str] = set()
    others: set[str] = set()
    values = [(f"model, initial.{name}", name, formula) for name, formula in draft.initial.items()]
    for label, element in elements.items():
        if isinstance(element, Joint):
            angles.update(element.angle_coordinates)
            others.update(element.coordinates, element.quasi_speed_names)
            others.update(f"{name}_dot" for name in element.coordinates)
            for path, name, drive in element.drives_with_paths():
                values.append((f"{label}, {path}", name, drive.free))
            for path, name, limits in element.limits_with_paths():
                values += [(f"{label}, {path}", name, end) for end in limits.ends]
            for name, formula in element.motion.items():
                values.append((f"{label}, {element.coordinate_path('motion', name)}", name, formula))
    return [
        Problem(
            "model.not_an_angle",
            where,
            f"{formula} belongs to {name}, which is not an angle",
            "deg is allowed for angles only",
            "write the value in SI units",
        )
        for where, name, formula in values
        if name in others - angles and formula.is_in_degrees
    ]


def _check_numbers(draft: Draft, elements: Mapping[str, Element]) -> NumericChecks:
    values, problems = parameter_values(draft.parameters)
    check = NumericChecks(values)
    check.problems += problems
    check.values(draft.gravity, "model, gravity")
    GROUND_FRAMES.check_numbers(check, None, draft.ground, "model, ground.frames")
    _check_shapes(check, draft.ground_shapes, "model, ground.shape")
    check_initial(check, draft.initial, (*draft.joints, *draft.free_joints))
    for label, element in elements.items():
        check_element(check, element, label)
        if isinstance(element, Body):
            _check_shapes(check, element.shapes, f"{label}, shape")
    return check


def _assumptions(draft: Draft) -> list[str]:
    notes = [
        f"body {joint.name} has no joint and moves freely, with coordinates {joint.coordinates[0]} "
        f"to {joint.coordinates[-1]}"
        for joint in draft.free_joints
    ]
    if all(component.constant() == 0 for component in draft.gravity):
        notes.append("gravity is zero")
    moving = [joint for joint in (*draft.joints, *draft.free_joints) if joint.coordinates]
    if moving and all(joint.motions.keys() >= set(joint.coordinates) for joint in moving):
        notes.append(
            "every coordinate is prescribed: only reactions and driving forces remain to be computed"
        )
    return notes


def _check_shapes(check: NumericChecks, shapes: Sequence[BodyShape], where: str) -> None:
    for k, shape in enumerate(shapes):
        shape.check_numbers(check, f"{where}[{k}]")
