"""Everything that makes a description a Model: all checks, all faults told at once."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from symbody.errors import ModelError, Problem, nearest
from symbody.expr.language.formula import Formula
from symbody.model.body import Body
from symbody.model.checker import Checker
from symbody.model.element import Element
from symbody.model.forces import SpringDamper
from symbody.model.frame import Frame
from symbody.model.joint import Joint
from symbody.model.lookup import element_labels, places_of, with_places
from symbody.model.parameters import cycle_problems, known_values
from symbody.model.physics import check_body, check_coefficients, check_frames, check_joint
from symbody.model.structure import duplicate_elements, floating_problems, free_bodies, joint_problems
from symbody.model.symbols import Meaning, Symbols, collect_symbols, joint_entries, scope_problems
from symbody.model.table import Table
from symbody.model.uses import Scope, Triple, Use, triple_uses


@dataclass(frozen=True, slots=True)
class Draft:
    """The parts of a model before they are checked against each other; see `Model`."""

    elements: tuple[Element, ...]
    gravity: Triple
    parameters: Table[Formula | None]
    inputs: tuple[str, ...]
    initial: Table[Formula]
    ground: Table[Frame]

    @property
    def bodies(self) -> tuple[Body, ...]:
        """The bodies."""
        return tuple(element for element in self.elements if isinstance(element, Body))


def checked(draft: Draft, earlier: Iterable[Problem]) -> tuple[tuple[Element, ...], tuple[str, ...]]:
    """Return the elements with their addresses looked up, and remarks.

    Raises
    ------
    ModelError
        With the `earlier` problems and all that are found.
    """
    problems = list(earlier)
    labels = element_labels(draft.elements)
    problems += duplicate_elements(draft.elements, labels)
    placed, unknown = with_places(draft.elements, places_of(draft.bodies, draft.ground), labels)
    problems += unknown
    joints = {labels[k]: element for k, element in enumerate(placed) if isinstance(element, Joint)}
    if not unknown:
        problems += joint_problems(joints)
        problems += floating_problems(draft.bodies, joints.values())
    problems += _name_problems(draft, list(labels.values()))
    check = _numbers(draft, labels.values())
    problems += check.problems
    if problems:
        raise ModelError(*problems)
    return tuple(placed), (*_assumptions(draft, list(joints.values())), *check.notes)


def _name_problems(draft: Draft, labels: Sequence[str]) -> list[Problem]:
    """Return what is wrong with symbols and with the names in formulas."""
    symbols, problems = collect_symbols(_symbol_entries(draft, labels))
    problems += cycle_problems(draft.parameters)
    problems += scope_problems("model", _model_uses(draft), symbols)
    for label, element in zip(labels, draft.elements, strict=True):
        problems += scope_problems(label, element.uses(), symbols)
    return problems + _initial_problems(draft, symbols) + _degree_problems(draft, labels)


def _symbol_entries(draft: Draft, labels: Sequence[str]) -> Iterator[tuple[str, Meaning]]:
    for name in draft.parameters:
        yield name, Meaning("parameter", f"model, parameters.{name}")
    for k, name in enumerate(draft.inputs):
        yield name, Meaning("input", f"model, inputs[{k}]")
    for label, element in zip(labels, draft.elements, strict=True):
        if isinstance(element, Joint):
            yield from joint_entries(element, label)


def _model_uses(draft: Draft) -> Iterator[Use]:
    """Return where the formulas of the model itself stand."""
    yield from triple_uses("gravity", draft.gravity, Scope.CONSTANT)
    for name, formula in draft.parameters.items():
        if formula is not None:
            yield Use(f"parameters.{name}", formula, Scope.CONSTANT)
    for name, formula in draft.initial.items():
        yield Use(f"initial.{name}", formula, Scope.CONSTANT)
    for name, frame in draft.ground.items():
        yield from frame.uses(f"ground.frames.{name}")


def _initial_problems(draft: Draft, symbols: Symbols) -> list[Problem]:
    """Return a problem for each initial value of what has none."""
    known = [name for name, meaning in symbols.meanings.items() if meaning.word in ("coordinate", "rate")]
    return [
        Problem(
            "initial.unknown",
            f"model, initial.{name}",
            f"there is no coordinate or rate {name!r}",
            "initial values belong to coordinates and their rates, x and x_dot",
            nearest(name, known),
        )
        for name in draft.initial
        if name not in known
    ]


def _degree_problems(draft: Draft, labels: Sequence[str]) -> list[Problem]:
    """Return a problem for each value in degrees that is no angle."""
    angles: set[str] = set()
    others: set[str] = set()
    values = {f"model, initial.{name}": (name, formula) for name, formula in draft.initial.items()}
    for label, joint in zip(labels, draft.elements, strict=True):
        if isinstance(joint, Joint):
            angles.update(joint.rotation_coordinates)
            others.update(joint.coordinates)
            others.update(f"{name}_dot" for name in joint.coordinates)
            for name, drive in joint.drives.items():
                values[f"{label}, force"] = (name, drive.free)
    return [
        Problem(
            "model.not_an_angle",
            where,
            f"{formula} belongs to {name}, which is no angle",
            "deg is understood for angles alone",
            "write the value in SI units",
        )
        for where, (name, formula) in values.items()
        if name in others - angles and formula.text.endswith("deg") and "deg" not in formula.names
    ]


def _numbers(draft: Draft, labels: Iterable[str]) -> Checker:
    """Return what the values of the parameters say."""
    values, problems = known_values(draft.parameters)
    check = Checker(values)
    check.problems += problems
    check.values(draft.gravity, "model, gravity")
    check_frames(check, draft.ground, "model, ground.frames")
    for name, formula in draft.initial.items():
        check.value(formula, f"model, initial.{name}")
    for label, element in zip(labels, draft.elements, strict=True):
        if isinstance(element, Body):
            check_body(check, element, label)
        elif isinstance(element, Joint):
            check_joint(check, element, label)
        elif isinstance(element, SpringDamper):
            check_coefficients(check, element, label)
    return check


def _assumptions(draft: Draft, joints: Sequence[Joint]) -> list[str]:
    """Return what was assumed because it was left out."""
    notes = [f"body {name} has no joint and moves freely" for name in free_bodies(draft.bodies, joints)]
    if all(component.constant() == 0 for component in draft.gravity):
        notes.append("gravity is zero")
    for joint in joints:
        if not joint.has_named_coordinates:
            names = ", ".join(joint.coordinates)
            notes.append(f"joint {joint.name}: coordinates without a name of their own are called {names}")
    return notes
