"""The names of a model: each unique in its namespace, each formula within the names of its place."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final, NamedTuple

from symbody.errors import Problem, nearest
from symbody.expr.language.formula import Formula
from symbody.model.constraint import ConstraintElement
from symbody.model.contacts.contact import BRISTLES_READ, Contact
from symbody.model.declarations.formula_site import FormulaSite, Scope
from symbody.model.element import Element
from symbody.model.joint import Joint
from symbody.model.naming import RESERVED_SYMBOLS
from symbody.model.signals.block import SignalBlock
from symbody.model.signals.signal import Signal
from symbody.model.tables.lookup import Lookup


class Meaning(NamedTuple):
    """What a symbol of the model is.

    Attributes
    ----------
    word : str
        ``"parameter"``, ``"input"``, ``"coordinate"``, ``"rate"``, ``"speed"``, ``"acceleration"``,
        ``"signal"`` or ``"signal rate"``.
    where : str
        The place that introduces it.
    """

    word: str
    where: str


# What the names in a formula may be, beside t and pi.
_WORDS: Final = MappingProxyType(
    {
        Scope.CONSTANT: ("parameter",),
        Scope.PRESCRIBED: ("parameter", "table"),
        Scope.ARGUMENT: ("parameter", "coordinate", "rate", "speed"),
        Scope.LOAD: (
            "parameter",
            "input",
            "coordinate",
            "rate",
            "speed",
            "signal",
            "table",
            "table of states",
        ),
        Scope.MOTION: ("parameter", "coordinate", "rate", "speed", "table"),
        Scope.POINT: ("parameter", "table"),
        Scope.SURFACE: ("parameter",),
        Scope.COORDINATE: ("coordinate",),
    }
)

# Letters for what they say of a point, whatever they are in the model.
_LETTERS: Final = MappingProxyType({Scope.POINT: ("x", "y", "z"), Scope.SURFACE: ("x", "y")})


@dataclass(frozen=True, slots=True)
class Symbols:
    """All symbols of a model but ``t`` and ``pi``."""

    meanings: Mapping[str, Meaning]

    def allows(self, name: str, scope: Scope) -> bool:
        """Return whether a formula may contain a name."""
        if name in RESERVED_SYMBOLS:
            return scope is not Scope.COORDINATE and (
                name == "pi" or scope not in (Scope.CONSTANT, Scope.SURFACE)
            )
        if name in _LETTERS.get(scope, ()):
            return True
        meaning = self.meanings.get(name)
        return meaning is not None and meaning.word in _WORDS[scope]

    def allowed_names(self, scope: Scope) -> list[str]:
        """Return all names a formula may contain."""
        local = _LETTERS.get(scope, ())
        return [name for name in (*local, *RESERVED_SYMBOLS, *self.meanings) if self.allows(name, scope)]


def collect_symbols(entries: Iterable[tuple[str, Meaning]]) -> tuple[Symbols, list[Problem]]:
    """Return the symbols, and a problem for each name that means two things."""
    found: dict[str, list[Meaning]] = {}
    for name, meaning in entries:
        found.setdefault(name, []).append(meaning)
    problems = [_duplicate(name, meanings) for name, meanings in found.items() if _is_clash(meanings)]
    return Symbols({name: meanings[0] for name, meanings in found.items()}), problems


def element_entries(element: Element, label: str) -> Iterator[tuple[str, Meaning]]:
    """Return what an element adds to the symbols, unless it is a table."""
    if isinstance(element, Joint):
        yield from joint_entries(element, label)
        yield from bristle_entries(element, label)
    elif isinstance(element, Contact):
        yield from bristle_entries(element, label)
    elif isinstance(element, ConstraintElement):
        for name in element.coordinates:
            yield from coordinate_entries(name, f"{label}, parameter")
    elif isinstance(element, Signal | SignalBlock):
        yield from signal_entries(element, element.signals, label)


def joint_entries(joint: Joint, label: str) -> Iterator[tuple[str, Meaning]]:
    """Return what a joint adds to the symbols: coordinates and speeds, their rates and accelerations."""
    given = joint.given_names
    for k, name in enumerate(joint.coordinates):
        path = "name" if given[k] is None else "coordinate" if len(given) == 1 else f"coordinates[{k}]"
        yield from coordinate_entries(name, f"{label}, {path}")
    for k, name in enumerate(joint.quasi_speed_names):
        path = "name" if joint.speed_names is None else f"speed_names[{k}]"
        yield name, Meaning("speed", f"{label}, {path}")
        yield f"{name}_dot", Meaning("acceleration", f"{label}, {path}")


def coordinate_entries(name: str, where: str) -> Iterator[tuple[str, Meaning]]:
    """Return a coordinate, its rate and its acceleration."""
    for suffix, word in (("", "coordinate"), ("_dot", "rate"), ("_ddot", "acceleration")):
        yield f"{name}{suffix}", Meaning(word, where)


def signal_entries(element: Element, signals: Sequence[Signal], label: str) -> Iterator[tuple[str, Meaning]]:
    """Return what an element adds to the symbols: names of its signals, rates of states, and its own name."""
    if element.name not in {signal.name for signal in signals}:  # a block with several outputs
        yield element.name, Meaning("block", f"{label}, name")
    for signal in signals:
        yield from _signal_names(signal, f"{label}, name")


def bristle_entries(element: Joint | Contact, label: str) -> Iterator[tuple[str, Meaning]]:
    """Return what the bristles of friction add to the symbols, with the slips and gaps that they read."""
    for signal in element.signals:
        yield from _signal_names(signal, f"{label}, name")
    for bristle in element.bristles if isinstance(element, Contact) else ():
        for word in BRISTLES_READ:
            yield f"{bristle}_{word}", Meaning(f"{word} of bristles", f"{label}, name")


def _signal_names(signal: Signal, where: str) -> Iterator[tuple[str, Meaning]]:
    yield signal.name, Meaning("signal", where)
    if signal.is_state:
        yield f"{signal.name}_dot", Meaning("signal rate", where)


def table_entries(table: Lookup, label: str, constants: AbstractSet[str]) -> Iterator[tuple[str, Meaning]]:
    """Return what a table adds to the symbols: its name, of time where its argument has `constants` alone."""
    is_of_time = {*table.argument.names} <= {"t", "pi", *constants}
    yield table.name, Meaning("table" if is_of_time else "table of states", f"{label}, name")


def scope_problems(label: str, sites: Iterable[FormulaSite], symbols: Symbols) -> list[Problem]:
    """Return a problem for each name that does not belong where it stands."""
    problems = []
    for site in sites:
        for name in site.formula.names:
            if name in site.local_names:
                if name in symbols.meanings and not symbols.meanings[name].where.startswith(f"{label}, "):
                    problems.append(
                        _shadow_problem(f"{label}, {site.path}", site, name, symbols.meanings[name])
                    )
            elif not symbols.allows(name, site.scope):
                problems.append(_scope_problem(f"{label}, {site.path}", site, name, symbols))
    return problems


def _shadow_problem(where: str, site: FormulaSite, name: str, meaning: Meaning) -> Problem:
    return site.formula.problem(
        "names.shadowed",
        _column(site.formula, name),
        f"{name!r} is a measured quantity of this element, and also a {meaning.word} of the model "
        f"({meaning.where})",
        f"here {' and '.join(site.local_names)} refer to quantities measured on the element",
        f"rename the {meaning.word}",
        where,
    )


def _scope_problem(where: str, site: FormulaSite, name: str, symbols: Symbols) -> Problem:
    column = _column(site.formula, name)
    meaning = symbols.meanings.get(name)
    is_coordinate = site.scope is Scope.COORDINATE
    takes = f"allowed here: {site.scope.value}" + ("" if is_coordinate else ", and pi")
    if meaning is not None or name in RESERVED_SYMBOLS:
        kind = "" if meaning is None else f"{_ARTICLES.get(meaning.word, 'a')} {meaning.word}"
        word = kind or RESERVED_SYMBOLS[name]
        cure = (
            "name a coordinate of a joint"
            if is_coordinate
            else _CURES.get(kind, "write the formula without it")
        )
        what = f"{name!r} is {word}, which is not allowed here"
        return site.formula.problem("names.not_here", column, what, takes, cure, where)
    cure = nearest(name, [*site.local_names, *symbols.allowed_names(site.scope)])
    defined = f'[parameters] {name} = .. in a file, parameters={{"{name}": ..}} in Python'
    defined += f', or inputs = ["{name}"]' if "inputs" in takes else ""
    fix = cure if is_coordinate else f"{cure} Or define it: {defined}"
    return site.formula.problem("names.unknown", column, f"there is no symbol {name!r}", takes, fix, where)


_ARTICLES = {"input": "an", "acceleration": "an"}
# What to do instead, for names whose place is elsewhere.
_CURES: Final = MappingProxyType(
    {
        "a signal": "write its formula instead, if that uses only the names allowed here: a signal may "
        "depend on states",
        "a block": "write the name of one of its numbered outputs: name_1, name_2, ..",
        "a signal rate": "write the formula of the rate, or define a signal for it: value = ..",
    }
)


def _column(formula: Formula, name: str) -> int:
    return next(step.column for step in formula.program if step.kind == "name" and step.payload == name)


def _is_clash(meanings: list[Meaning]) -> bool:
    """Return whether a name has several meanings, not only as rate of coordinates that clash themselves."""
    return len(meanings) > 1 and {meaning.word for meaning in meanings} not in ({"rate"}, {"acceleration"})


def _duplicate(name: str, meanings: list[Meaning]) -> Problem:
    places = "; ".join(dict.fromkeys(meaning.where for meaning in meanings))
    listed = ", ".join(f"{meaning.word} ({meaning.where})" for meaning in meanings)
    derived = any(meaning.word in ("rate", "acceleration", "signal rate") for meaning in meanings)
    made = "x_dot and x_ddot are defined for every coordinate x, w_dot for every speed or state w"
    why = made if derived else "every symbol has one meaning"
    what = f"the name {name!r} has {len(meanings)} meanings: {listed}"
    return Problem("names.duplicate", places, what, why, "rename all but one")
