"""The model of the data that are edited, and as much of it as can be drawn where it is incomplete."""

from __future__ import annotations

import json
import re
from collections import OrderedDict
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from threading import Lock
from typing import Any, Final, Generic, TypeVar

from symbody.builder.page_problems import PageProblem, page_problems, pointer_parts, value_at
from symbody.builder.task_failure import TaskFailure
from symbody.errors import SymbodyError
from symbody.formats.native import from_data
from symbody.model.model import KINDS, Model

Value = TypeVar("Value")
Data = dict[str, Any]

_UNKNOWN: Final = re.compile(r"there is no .*?'([^']+)'")
_RATE: Final = re.compile(r"_d?dot$")
_NAME: Final = re.compile(r"\w+")
_IDENTITY: Final = frozenset({"name", "type", "between", "on", "reaction_on"})  # an entry is nothing without
_ROUNDS: Final = 40  # faults that are taken out of an incomplete model one after the other


class Latest(Generic[Value]):
    """The last few values that were made, by what they were made from."""

    def __init__(self, most: int) -> None:
        self._most = most
        self._values: OrderedDict[str, Value] = OrderedDict()
        self._lock = Lock()
        self.count = 0  # of values that were made

    def get(self, key: str, make: Callable[[], Value]) -> Value:
        """Return the value of a key, made if it is not there."""
        with self._lock:
            if key in self._values:
                self._values.move_to_end(key)
                return self._values[key]
        value = make()
        with self._lock:
            self.count += 1
            self._values[key] = value
            while len(self._values) > self._most:
                self._values.popitem(last=False)
        return value


_MODELS: Final[Latest[Model]] = Latest(4)


@dataclass(frozen=True, slots=True)
class ReadModel:
    """A model under construction.

    Attributes
    ----------
    model : Model or None
        None where not even a part of it can be read.
    problems : list of dict
        Why it is not complete; what they concern is not in `model`.
    """

    model: Model | None
    problems: list[PageProblem]


def model_key(data: Mapping[str, Any], folder: str) -> str:
    """Return what tells a mechanism from all others; the layout of its diagram is not part of it."""
    content = {name: value for name, value in data.items() if name != "layout"}
    return json.dumps([folder, content], sort_keys=True)


def complete_model(data: Mapping[str, Any], folder: str) -> Model:
    """Return the model of data.

    Raises
    ------
    TaskFailure
        With all problems, if they are none.
    """
    try:
        return _MODELS.get(model_key(data, folder), lambda: from_data(data, folder=folder))
    except SymbodyError as error:
        raise TaskFailure(page_problems(error.problems, data)) from None


def read_model(data: Data, folder: str) -> ReadModel:
    """Return the model of data, without what is wrong with it."""
    problems: list[PageProblem] = []
    places: dict[str, list[int]] = {
        kind: list(range(len(data[kind]))) for kind in KINDS if isinstance(data.get(kind), list)
    }
    usable = {key: value for key, value in data.items() if key != "layout"}
    gone: set[str] = set()  # words of what was left out: that they are unknown is not a further fault
    filled: dict[str, bool] = {}  # places whose values have stand-ins; whether the field was left out since
    for _ in range(_ROUNDS):
        try:
            return ReadModel(from_data(usable, folder=folder), problems)
        except SymbodyError as error:
            faults = page_problems(error.problems, usable)
        for fault in faults:
            placed = {**fault, "pointer": _original(fault["pointer"], places)}
            placed["repair"] = fault["repair"] if placed["pointer"] == fault["pointer"] else None
            is_old = any(_is_same(placed, other) for other in problems)
            if not (is_old or _follows(fault, gone) or _is_of_stand_in(placed["pointer"], filled)):
                problems.append(placed)
        smaller = _leave_out(usable, faults, places, filled)
        if smaller is None:
            return ReadModel(None, problems)
        gone |= _words([entry for kind in places for entry in usable[kind] if entry not in smaller[kind]])
        usable = smaller
    return ReadModel(None, problems)


def _follows(fault: PageProblem, gone: set[str]) -> bool:
    """Return whether something is unknown only because the element that brings it was left out."""
    match = _UNKNOWN.search(str(fault["what"]))
    return match is not None and _RATE.sub("", match.group(1)) in gone


def _words(value: Any) -> set[str]:
    """Return all names in a part of a model."""
    if isinstance(value, Mapping):
        parts = [_words(each) for each in (*value.keys(), *value.values())]
    elif isinstance(value, list):
        parts = [_words(each) for each in value]
    else:
        parts = [set(_NAME.findall(value))] if isinstance(value, str) else []
    return set[str]().union(*parts)


def _is_same(fault: PageProblem, other: PageProblem) -> bool:
    return (fault["code"], fault["pointer"]) == (other["code"], other["pointer"])


def _original(pointer: str, places: Mapping[str, list[int]]) -> str:
    """Return a pointer into the whole data, of one into what is left of them."""
    parts = pointer_parts(pointer)
    if len(parts) > 1 and parts[0] in places and parts[1].isdecimal():
        kept = places[parts[0]]
        if int(parts[1]) < len(kept):
            return "/".join(["", parts[0], str(kept[int(parts[1])]), *pointer.split("/")[3:]])
    return pointer


def _is_of_stand_in(pointer: str, filled: Mapping[str, bool]) -> bool:
    """Return whether a fault concerns a stand-in: in its place, around it, or within it."""
    return any(
        f"{pointer}/".startswith(f"{place}/") or f"{place}/".startswith(f"{pointer}/") for place in filled
    )


def _stand_in(data: Data, pointer: str, original: str, filled: dict[str, bool]) -> Data | None:
    """Return data with a stand-in for a value at fault within an entry, None if the entry has to go.

    Which entries are there decides which joints close loops: a typing error in a mass changes no tree.
    A quantity is taken as 1, a component of a place as 0; what cannot be that is left to its default.
    """
    parts = pointer_parts(pointer)
    around = next((place for place in filled if _is_of_stand_in(original, {place: True})), None)
    if len(parts) < 2 or (len(parts) < 3 and around is None):
        return None
    field = pointer_parts(around)[2] if around is not None and len(parts) < 3 else parts[2]
    if field in _IDENTITY or (around is not None and filled[around]):
        return None
    value, neutral = value_at(pointer, data), "0" if "at" in parts[2:] else "1"
    if around is None and isinstance(value, str) and value != neutral:
        filled[original] = False
        changed: Data = _with_value(data, parts, neutral)
        return changed
    filled[around or original] = True
    shorter: Data = _with_value(data, [*parts[:2], field], None)
    return shorter


def _with_value(data: Any, parts: list[str], value: str | None) -> Any:
    """Return data with a text at a place, or without what is there."""
    key, *rest = parts
    if isinstance(data, list):
        return [_with_value(each, rest, value) if str(k) == key and rest else value if str(k) == key else each
                for k, each in enumerate(data)]  # fmt: skip
    if not rest and value is None:
        return {name: each for name, each in data.items() if name != key}
    return {**data, key: _with_value(data[key], rest, value) if rest else value}


def _leave_out(
    data: Data, faults: list[PageProblem], places: dict[str, list[int]], filled: dict[str, bool]
) -> Data | None:
    """Return data without what is at fault, None if nothing of it can be left out."""
    unknown = {_symbol(fault) for fault in faults} - {""}
    parameters = data.get("parameters")
    if unknown:  # quantities without a value are drawn as if they had one
        given = parameters if isinstance(parameters, Mapping) else {}
        return {**data, "parameters": {**given, **dict.fromkeys(sorted(unknown), "")}}
    result = dict(data)
    dropped: dict[str, set[int]] = {}
    for fault in faults:
        parts = pointer_parts(fault["pointer"])
        if len(parts) > 1 and parts[0] in places and parts[1].isdecimal():
            changed = _stand_in(result, fault["pointer"], _original(fault["pointer"], places), filled)
            if changed is not None:
                result = changed
                continue
            dropped.setdefault(parts[0], set()).add(int(parts[1]))
        elif (
            len(parts) > 1
            and parts[0] in ("parameters", "initial")
            and isinstance(result.get(parts[0]), Mapping)
        ):
            result[parts[0]] = {key: value for key, value in result[parts[0]].items() if key != parts[1]}
        elif parts and parts[0] == "name":
            result["name"] = "untitled"
        elif parts and parts[0] in result:
            del result[parts[0]]
    for kind, indices in dropped.items():
        result[kind] = [entry for k, entry in enumerate(result[kind]) if k not in indices]
        places[kind] = [place for k, place in enumerate(places[kind]) if k not in indices]
    return result if result != data else None


def _symbol(fault: PageProblem) -> str:
    """Return the name of a quantity that a formula contains and nobody defined."""
    if fault["code"] != "names.unknown" or "[parameters]" not in fault["fix"]:
        return ""
    return str(fault["what"].partition("'")[2].partition("'")[0])
