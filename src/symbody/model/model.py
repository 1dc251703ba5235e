"""`Model`: the description of a mechanism; frozen, complete, without mathematics of its own."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, fields, replace
from typing import Final, TypeVar, final

from symbody.arguments import checked_arguments
from symbody.errors import ModelError, Problem, nearest, number_in_words
from symbody.expr.graph import Constant
from symbody.expr.language.formula import Formula
from symbody.model.body import GROUND_FRAMES, Body
from symbody.model.checks import physics
from symbody.model.checks.signals import collect_signals
from symbody.model.checks.structure import collect_constraints, free_joints
from symbody.model.checks.validation import Draft, check_draft
from symbody.model.constraint import ConstraintElement
from symbody.model.contacts.contact import Contact
from symbody.model.contacts.contact_groups import expand_groups
from symbody.model.declarations.arguments import Arguments, Value, plain_value
from symbody.model.declarations.formula_site import Triple
from symbody.model.element import Element
from symbody.model.first_values import FirstValues, Initial, read_initial
from symbody.model.frame import Frame
from symbody.model.frame_index import element_labels, include_bodies
from symbody.model.frozen_mapping import FrozenMapping
from symbody.model.joint import Joint
from symbody.model.output_arguments import OutputScope, make_scope
from symbody.model.parameters import dependence_order, parameter_values, resolve
from symbody.model.parts.expansion import add_parts
from symbody.model.parts.include import Include
from symbody.model.shapes.shape import GROUND_SHAPES, BodyShape
from symbody.model.signals.signal import Signal
from symbody.model.tables.lookup import Lookup
from symbody.notebook import Displayed

E = TypeVar("E", bound=Element)

# Elements are kept in this order, as a file lists them; within a kind, in the order given.
KINDS: Final = (
    "body",
    "joint",
    "spring",
    "torsion_spring",
    "force",
    "torque",
    "contact",
    "constraint",
    "table",
    "signal",
    "block",
)


@final
@dataclass(frozen=True, slots=True, init=False, repr=False)
class Model(Displayed):
    """A mechanism: bodies, joints and forces by name, with parameters and inputs.

    Everything is copied in and checked at once; a Model that exists is free of contradictions.

    Parameters
    ----------
    name : str
        Title.
    elements : iterable of Element or Include
        Bodies, joints, forces; bodies given as objects in joints and forces need not be listed. Parts that
        are included come last. A contact between places with ``*`` stands for one of each pair.
    gravity : (3,) number or formula
        Acceleration of free fall in ground axes [m/s^2].
    parameters : mapping of name to number, formula or None
        Formulas may contain other parameters, in any order; None: declared without value.
    inputs : iterable of str
        Names of quantities given from outside while the mechanism moves.
    initial : mapping of coordinate, rate or speed to number, formula or Initial
        Initial values, in SI units and radians.
    ground : mapping of name to Frame
        Frames fixed on the ground.
    ground_shapes : iterable of Box, Cylinder, Sphere, Capsule, Cone or Mesh
        Shapes of the ground, placed relative to its origin.
    notes : iterable of str
        Remarks of a reader on what it assumed; they come before the model's own.

    Attributes
    ----------
    initial : mapping of name to Formula
        All initial values.
    held_initial : tuple of str
        Names of those that hold where loops are closed; the others are guesses.
    bodies, joints : tuple of Body, of Joint
        Those among `elements`.
    constraints : tuple of ConstraintElement
        Those among `elements`, and the stops that rigid limits of joints and the rigid play of gears are.
    signals : tuple of Signal
        Those among `elements`, and those that blocks consist of, without held values.
    held_signals : tuple of Signal
        Those with a sample time, in the order in which they are updated.
    tables : tuple of Lookup
        Those among `elements`.
    includes : tuple of Include
        The parts, whose elements stand among `elements`.
    notes : tuple of str
        What was assumed, and what is legal but unusual.

    Raises
    ------
    ModelError
        With all contradictions at once.

    Examples
    --------
    >>> from symbody.model import Body, Prismatic
    >>> slider = Prismatic("slider", "ground", Body("Mass", mass="m"), coordinate="x")
    >>> model = Model("oscillator", [slider], parameters={"m": 2})
    >>> [body.name for body in model.bodies]
    ['Mass']
    """

    name: str
    elements: tuple[Element, ...]
    gravity: Triple
    parameters: FrozenMapping[Formula | None]
    inputs: tuple[str, ...]
    initial: FirstValues
    ground: FrozenMapping[Frame]
    ground_shapes: tuple[BodyShape, ...]
    held_initial: tuple[str, ...] = field(init=False)
    bodies: tuple[Body, ...] = field(init=False, compare=False)
    joints: tuple[Joint, ...] = field(init=False, compare=False)
    constraints: tuple[ConstraintElement | Contact, ...] = field(init=False, compare=False)
    signals: tuple[Signal, ...] = field(init=False, compare=False)
    held_signals: tuple[Signal, ...] = field(init=False, compare=False)
    tables: tuple[Lookup, ...] = field(init=False, compare=False)
    includes: tuple[Include, ...] = field(init=False, compare=False)
    notes: tuple[str, ...] = field(init=False, compare=False)
    _bodies: Mapping[str, Body] = field(init=False, compare=False)
    _joints: Mapping[str, Joint] = field(init=False, compare=False)

    @checked_arguments
    def __init__(
        self,
        name: str,
        elements: Iterable[Element | Include] = (),
        gravity: Iterable[Value] = (0, 0, 0),
        parameters: Mapping[str, Value | None] | None = None,
        inputs: Iterable[str] = (),
        initial: Mapping[str, Value | Initial] | None = None,
        ground: Mapping[str, Frame] | None = None,
        notes: Iterable[str] = (),
        ground_shapes: Iterable[BodyShape] = (),
    ) -> None:
        arguments = Arguments("model")
        items = arguments.items(elements, "elements")
        includes = tuple(item for item in items if isinstance(item, Include))
        items = [item for item in items if not isinstance(item, Include)]
        draft = Draft(
            elements=_sort_by_kind(include_bodies(_elements(arguments, items))),
            gravity=arguments.triple(gravity, "gravity"),
            parameters=arguments.table(
                parameters or {},
                "parameters",
                lambda value, path: None if value is None else arguments.formula(value, path),
            ),
            inputs=tuple(
                arguments.symbol_name(item, f"inputs[{k}]")
                for k, item in enumerate(arguments.items(inputs, "inputs"))
            ),
            initial=read_initial(arguments, initial or {}),
            ground=GROUND_FRAMES.read(None, arguments, ground, "ground.frames"),
            ground_shapes=GROUND_SHAPES.read(None, arguments, ground_shapes, "ground.shape"),
        )
        draft = add_parts(draft, includes, arguments.problems)
        groups: list[str] = []
        elements = expand_groups(draft.elements, draft.ground, arguments.problems, groups)
        draft = replace(draft, elements=_sort_by_kind(elements))
        title = name if isinstance(name, str) else "?"
        if title != name:
            arguments.add("names.not_text", "name", f"{name!r} is not a name", "", "give a text")
        for parameter in draft.parameters:
            arguments.symbol_name(parameter, f"parameters.{parameter}")
        placed, remarks = check_draft(draft, arguments.problems)
        draft, signals = replace(draft, elements=placed), collect_signals(placed)
        values = {each.name: getattr(draft, each.name) for each in fields(draft)} | {
            "name": title,
            "held_initial": draft.initial.held,
            "bodies": draft.bodies,
            "joints": draft.joints,
            "constraints": tuple(collect_constraints(placed)),
            "signals": tuple(s for s in signals if not s.is_held),
            "held_signals": tuple(s for s in signals if s.is_held),
            "tables": tuple(e for e in placed if isinstance(e, Lookup)),
            "includes": includes,
            "notes": (*notes, *groups, *remarks),
            "_bodies": {body.name: body for body in draft.bodies},
            "_joints": {joint.name: joint for joint in draft.joints},
        }
        for word, value in values.items():
            object.__setattr__(self, word, value)

    def __repr__(self) -> str:
        sizes = f"{number_in_words(len(self.bodies), 'body')}, {number_in_words(len(self.joints), 'joint')}"
        return f"Model({self.name!r}: {sizes})"

    @property
    def free_joints(self) -> tuple[Joint, ...]:
        """For each body without a joint the free joint of its motion; it has the name of the body."""
        return tuple(free_joints(self.bodies, self.joints))

    @property
    def output_scope(self) -> OutputScope:
        """What names of outputs refer to: elements, with joints of bodies without one, and frames."""
        return make_scope((*self.elements, *self.free_joints, *self.constraints), self.bodies, self.ground)

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Names of the coordinates of all joints, in their order, then of those that constraints bring."""
        own = [name for condition in self.constraints for name in condition.coordinates]
        return (*(name for joint in self.joints for name in joint.coordinates), *own)

    @checked_arguments
    def body(self, name: str) -> Body:
        """Return the body called `name`; a ModelError if there is none."""
        return _find_named(self._bodies, "body", name)

    @checked_arguments
    def joint(self, name: str) -> Joint:
        """Return the joint called `name`; a ModelError if there is none."""
        return _find_named(self._joints, "joint", name)

    @checked_arguments
    def values(self, parameters: Mapping[str, Value] | None = None) -> dict[str, float]:
        """Return the value of every parameter as a number; what depends on others follows them.

        Parameters
        ----------
        parameters : mapping of name to number or formula, optional
            In place of the model's values, as in `simulate`.

        Returns
        -------
        dict of name to float
            In the order of `parameters`.

        Raises
        ------
        ModelError
            Listing all parameters without value, or all names that are not parameters.

        Examples
        --------
        >>> rod = Body("Rod", mass="m", inertia=(0, 0, "m*L^2/12"))
        >>> model = Model("rod", [rod], parameters={"L": "2*r", "r": 0.25, "m": 3})
        >>> model.values(), model.values({"r": 1})["L"]
        ({'L': 0.5, 'r': 0.25, 'm': 3.0}, 2.0)
        """
        found = resolve(self.parameters, parameters or {})
        return {name: float(found[name]) for name in self.parameters}

    def parameter_order(self, overrides: Mapping[str, Formula] | None = None) -> tuple[str, ...]:
        """Return the parameters, each after those that its formula, or the one in its place, contains."""
        return dependence_order({**self.parameters, **(overrides or {})})


def resolve_parameters(model: Model, overrides: Mapping[str, Value] | None = None) -> dict[str, Constant]:
    """Return the value of every parameter: exact where its formula is, a float otherwise.

    Raises ModelError listing all parameters without value, or all names that are not parameters.

    Parameters
    ----------
    overrides : mapping of name to number or formula
        Take the place of the model's values; what depends on them follows.
    """
    return resolve(model.parameters, overrides or {})


def value_problems(model: Model, given: Mapping[str, Value], free: Iterable[str] = ()) -> list[Problem]:
    """Return what is impossible about elements with other values, as in a file.

    Values of `free` parameters are not known. Names that are none of the model are not judged.
    """
    changed: dict[str, Formula | None] = dict(model.parameters)
    changed |= {
        name: Formula.from_value(plain_value(value), where=name)
        for name, value in given.items()
        if name in changed
    }
    changed |= dict.fromkeys(free)
    own = set(given)
    for name in dependence_order(changed):
        formula = changed[name]
        if formula is not None and not own.isdisjoint(formula.names):
            own.add(name)
    labels = element_labels(model.elements)
    return physics.value_problems(
        {labels[k]: element for k, element in enumerate(model.elements)}, parameter_values(changed)[0], own
    )


def _elements(arguments: Arguments, items: Iterable[object]) -> list[Element]:
    for k, item in enumerate(items):
        if not isinstance(item, Element):
            what = f"{item!r} is not a part of a mechanism"
            fix = "give bodies, joints, forces and other elements"
            arguments.add("model.not_an_element", f"elements[{k}]", what, "", fix)
    return [item for item in items if isinstance(item, Element)]


def _sort_by_kind(elements: Iterable[Element]) -> tuple[Element, ...]:
    return tuple(sorted(elements, key=lambda element: KINDS.index(element.kind)))


def _find_named(elements: Mapping[str, E], kind: str, name: str) -> E:
    element = elements.get(name)
    if element is None:
        what = f"the model has no {kind} {name!r}"
        fix = nearest(name, list(elements))
        raise ModelError(Problem("model.unknown_element", f"{kind} {name}", what, "", fix))
    return element
