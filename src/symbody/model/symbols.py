"""The names of a model: each unique in its namespace, each formula within the names of its place."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import NamedTuple

from symbody.errors import Problem, nearest
from symbody.expr.language.formula import Formula
from symbody.model.joint import Joint
from symbody.model.naming import RESERVED_SYMBOLS
from symbody.model.uses import Scope, Use


class Meaning(NamedTuple):
    """What a symbol of the model is.

    Attributes
    ----------
    word : str
        ``"parameter"``, ``"input"``, ``"coordinate"``, ``"rate"``, ``"speed"`` or ``"acceleration"``.
    where : str
        The place that introduces it.
    """

    word: str
    where: str


@dataclass(frozen=True, slots=True)
class Symbols:
    """All symbols of a model but ``t`` and ``pi``."""

    meanings: Mapping[str, Meaning]

    def allows(self, name: str, scope: Scope) -> bool:
        """Return whether a formula may contain a name."""
        if name in RESERVED_SYMBOLS:
            return name == "pi" or scope is not Scope.CONSTANT
        meaning = self.meanings.get(name)
        if meaning is None:
            return False
        return meaning.word != "acceleration" if scope is Scope.LOAD else meaning.word == "parameter"

    def allowed(self, scope: Scope) -> list[str]:
        """Return all names a formula may contain."""
        return [name for name in (*RESERVED_SYMBOLS, *self.meanings) if self.allows(name, scope)]


def collect_symbols(entries: Iterable[tuple[str, Meaning]]) -> tuple[Symbols, list[Problem]]:
    """Return the symbols, and a problem for each name that means two things."""
    found: dict[str, list[Meaning]] = {}
    for name, meaning in entries:
        found.setdefault(name, []).append(meaning)
    problems = [_duplicate(name, meanings) for name, meanings in found.items() if _is_clash(meanings)]
    return Symbols({name: meanings[0] for name, meanings in found.items()}), problems


def joint_entries(joint: Joint, label: str) -> Iterator[tuple[str, Meaning]]:
    """Return what a joint adds to the symbols: coordinates and speeds, their rates and accelerations."""
    given = joint.names_given
    for k, name in enumerate(joint.coordinates):
        path = "name" if given[k] is None else "coordinate" if len(given) == 1 else f"coordinates[{k}]"
        for suffix, word in (("", "coordinate"), ("_dot", "rate"), ("_ddot", "acceleration")):
            yield f"{name}{suffix}", Meaning(word, f"{label}, {path}")
    for k, name in enumerate(joint.quasi_speed_names):
        path = "name" if joint.speed_names is None else f"speed_names[{k}]"
        yield name, Meaning("speed", f"{label}, {path}")
        yield f"{name}_dot", Meaning("acceleration", f"{label}, {path}")


def scope_problems(label: str, uses: Iterable[Use], symbols: Symbols) -> list[Problem]:
    """Return a problem for each name that does not belong where it stands."""
    return [
        _misplaced(f"{label}, {use.path}", use, name, symbols)
        for use in uses
        for name in use.formula.names
        if not symbols.allows(name, use.scope)
    ]


def _misplaced(where: str, use: Use, name: str, symbols: Symbols) -> Problem:
    column = _column(use.formula, name)
    meaning = symbols.meanings.get(name)
    if meaning is not None or name == "t":
        word = "time" if meaning is None else f"{_ARTICLES.get(meaning.word, 'a')} {meaning.word}"
        return use.formula.problem(
            "names.not_here",
            column,
            f"{name!r} is {word}, which cannot stand here",
            f"this place takes {use.scope.value}, and pi",
            "write the formula without it",
            where,
        )
    cure = nearest(name, symbols.allowed(use.scope))
    return use.formula.problem(
        "names.unknown",
        column,
        f"there is no symbol {name!r}",
        f"this place takes {use.scope.value}, and pi",
        f"{cure} Or define it: [parameters] {name} = ..",
        where,
    )


_ARTICLES = {"input": "an", "acceleration": "an"}


def _column(formula: Formula, name: str) -> int:
    return next(step.column for step in formula.program if step.kind == "name" and step.payload == name)


def _is_clash(meanings: list[Meaning]) -> bool:
    """Return whether a name has several meanings, not only as rate of coordinates that clash themselves."""
    return len(meanings) > 1 and {meaning.word for meaning in meanings} not in ({"rate"}, {"acceleration"})


def _duplicate(name: str, meanings: list[Meaning]) -> Problem:
    places = "; ".join(dict.fromkeys(meaning.where for meaning in meanings))
    listed = ", ".join(f"{meaning.word} ({meaning.where})" for meaning in meanings)
    derived = any(meaning.word in ("rate", "acceleration") for meaning in meanings)
    made = "x_dot and x_ddot are made for every coordinate x, w_dot for every speed w"
    why = made if derived else "every symbol has one meaning"
    return Problem(
        "names.duplicate",
        places,
        f"the name {name!r} stands for {len(meanings)} things: {listed}",
        why,
        "rename all but one",
    )
