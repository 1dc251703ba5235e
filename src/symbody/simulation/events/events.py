"""`Event`: a moment when an expression passes zero, and what happens then."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal, NamedTuple

from symbody.arguments import checked_fields
from symbody.codegen.formation.names import Value
from symbody.equations.elimination.coupled_coordinates import NONE_COUPLED
from symbody.equations.equation_set import EquationSet
from symbody.errors import Problem, UsageError, nearest
from symbody.expr.language.formula import Formula
from symbody.expr.printing.text import to_text
from symbody.model.declarations.arguments import plain_value

Action = Literal["record", "stop"] | Mapping[str, Value]


class Occurrence(NamedTuple):
    """One event of a motion.

    Attributes
    ----------
    name : str
        Of the event.
    t : float
        When it happened [s].
    state : mapping of name to float
        Speeds and coordinates then, before the action.
    """

    name: str
    t: float
    state: Mapping[str, float]


class EventSide(NamedTuple):
    """Where the value of an event stands when a motion is interrupted.

    Attributes
    ----------
    side : float
        Its sign, 0 where it is zero or not known.
    has_happened : float
        1 if the event has happened there and its value has not left zero yet.
    largest : float
        The largest value so far.
    was : float
        The sign of the value where it was last on a side.
    done : float
        The direction in which the value goes on through a zero at which the event has happened, else 0.
    """

    side: float = 0.0
    has_happened: float = 0.0
    largest: float = 0.0
    was: float = 0.0
    done: float = 0.0


@checked_fields
@dataclass(frozen=True, slots=True)
class Event:
    """A moment when an expression passes zero.

    An event that sets values also happens where its value is zero at a start, or where a motion continues
    after an action, a sample or a jump, and leaves zero in the event's direction: the first rate that is not
    zero decides, of the first and second. So balls that touch hit each other. If the value is zero
    again after that action and goes the same way, as for a ball that lies on the floor, the motion ends as
    `Status.CHATTERING`. An event that records or stops, and one of direction 0 whose value had no sign yet,
    happens once its value has left zero.

    A value that touches zero from one side counts if `direction` is 0. Angles of cut joints that are not sums
    of angles of the tree are measured within half a turn; their jump between its ends does not count.

    Attributes
    ----------
    expression : str or number
        In t, coordinates, speeds, inputs and parameters, or any output's name.
    direction : int
        1 for values that rise through zero as the motion continues, -1 for those that fall, 0 for both.
    action : "record", "stop" or mapping of name to formula
        What follows: a note in ``run.events``; the end of the motion, which becomes its last sample; or new
        values of coordinates and speeds, all computed from the state before, for instance
        ``{"x_dot": "-e*x_dot"}``. They hold: closed loops are closed again by the least move of the other
        coordinates, then by the least kinetic energy of the change of the other speeds. Values that the
        constraints do not admit end the motion with `Status.UNMET_ACTION`. A substituted coordinate stands
        for the one it follows from.
    name : str, optional
        By default the expression.

    Raises
    ------
    UsageError
        If the direction or the action is not valid.

    Examples
    --------
    >>> import symbody as sb
    >>> rail = sb.Prismatic("rail", "ground", sb.Body("Ball", mass=1), axis="z", coordinate="z")
    >>> eqs = sb.form_equations(sb.Model("drop", [rail], gravity=(0, 0, -10), initial={"z": 5}))
    >>> run = sb.simulate(eqs, 3.0, events=sb.Event("z", direction=-1, action="stop"))
    >>> float(run.t[-1].round(6))
    1.0
    """

    expression: Value
    direction: int = 0
    action: Action = "record"
    name: str | None = field(default=None)

    def __post_init__(self) -> None:
        if self.direction not in (-1, 0, 1):
            raise _wrong(self, f"direction = {self.direction!r}", "give 1, -1 or 0")
        if not (self.action in ("record", "stop") if isinstance(self.action, str) else self.action):
            raise _wrong(
                self, f"action = {self.action!r}", "give 'record', 'stop' or a mapping of new values"
            )

    @property
    def label(self) -> str:
        """Its name, or what it watches."""
        return str(self.expression) if self.name is None else self.name

    @property
    def mapping(self) -> Mapping[str, Value]:
        """New values by name; empty if the event only records or stops."""
        return {} if isinstance(self.action, str) else self.action


@dataclass(frozen=True, slots=True)
class LevelEvent(Event):
    """A moment when an expression passes a number that follows from the motion so far.

    The expression stays the same from one to the next, and so does the code for it.

    Attributes
    ----------
    level : float
        The number.
    """

    level: float = 0.0


@dataclass(frozen=True, slots=True)
class ModeEnd(LevelEvent):
    """The end of a mode of a joint that sticks and slips, of a rope or of a stop: its value falls to zero."""


@dataclass(frozen=True, slots=True)
class GapEvent(LevelEvent):
    """The closing of a compliant gap: a step at whose end it is open again is taken again, shorter.

    Its force would be seen by none of the evaluations of such a step.
    """


@dataclass(frozen=True, slots=True)
class ModeChange:
    """An element that changes its mode.

    Attributes
    ----------
    t : float
        When [s].
    name : str
        The joint, rope or stop.
    mode : str
        From then on: "sticks", "slips forward", "slips backward"; "taut", "slack"; "closed", "open".
    """

    t: float
    name: str
    mode: str


def check_events(events: Event | Sequence[Event], eqs: EquationSet) -> tuple[Event, ...]:
    """Return events as a tuple.

    Raises
    ------
    UsageError
        If one of them is none, two share a name, or an action sets what is not a state.
    """
    checked = (events,) if isinstance(events, Event) else tuple(events)
    problems = [
        Problem("simulation.event", "events", f"{event!r} is not an event",
                fix="write sb.Event(expression, ...)")
        for event in checked if not isinstance(event, Event)
    ]  # fmt: skip
    if problems:
        raise UsageError(*problems)
    checked = tuple(_in_states(eqs, event) for event in checked)
    labels = [event.label for event in checked]
    problems = [
        Problem("simulation.event_name", f"event {label!r}", "another event has this name", "",
                "give each event its own name: sb.Event(..., name=...)")
        for k, label in enumerate(labels) if label in labels[:k]
    ]  # fmt: skip
    problems += [
        Problem("simulation.event_action", f"event {event.label!r}", f"{name!r} is not a state",
                "an action gives new values to coordinates and speeds", nearest(name, eqs.state_names))
        for event in checked for name in event.mapping if name not in eqs.state_names
    ]  # fmt: skip
    if problems:
        raise UsageError(*problems)
    return checked


def _in_states(eqs: EquationSet, event: Event) -> Event:
    """Return an event whose action sets what gives a substituted coordinate, in place of this or its rate."""
    coupled = eqs.formed.coupled if event.mapping else NONE_COUPLED
    action: dict[str, Value] = {}
    for name, value in event.mapping.items():
        coordinate = name.removesuffix("_dot")
        if coordinate not in coupled.leaders or name in eqs.state_names:
            action[name] = value
            continue
        leader, factor, rest = coupled.leaders[coordinate]
        less = "" if name.endswith("_dot") else f" - ({to_text(rest.graph, rest.index)})"
        text = Formula.from_value(plain_value(value), where=name).text
        target = leader + name.removeprefix(coordinate)
        action[target] = f"(({text}){less})/({to_text(factor.graph, factor.index)})"
    return replace(event, action=action) if event.mapping and coupled.leaders else event


def _wrong(event: Event, what: str, fix: str) -> UsageError:
    return UsageError(
        Problem("simulation.event", f"event {event.label!r}", f"{what} is not a valid choice", fix=fix)
    )
