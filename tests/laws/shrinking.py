"""From a model that fails to a small one that still does: delta debugging on what its file says.

Elements go first, in halves and ever smaller parts (Zeller & Hildebrandt 2002), then what is said of them, then
numbers become simpler. Every step is taken only if the model still fails, so the end fails too.
"""

from __future__ import annotations

import copy
import math
import re
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import symbody as sb
from symbody.formats.native import from_data, to_data
from symbody.model.model import KINDS

CORPUS = Path(__file__).parents[1] / "corpus"
Data = dict[str, Any]
Fails = Callable[[sb.Model], bool]
Where = tuple[str | int, ...]
# What a file needs, or what only says where something is.
_KEPT = (
    "name",
    "type",
    "between",
    "on",
    "reaction_on",
    "resolved_in",
    "coordinate",
    "coordinates",
    "coupled",
)
_NUMBER = re.compile(r"(?<![\w.])\d+\.?\d*(?:[eE][-+]?\d+)?(?![\w.])")
_DIGITS = (1, 2, 4)
_TURNS = {"0": 0.0, "pi/2": math.pi / 2, "pi": math.pi, "-pi/2": -math.pi / 2}
_CLOSE = 0.8  # an angle is tried as a quarter turn within this [rad]; farther away it is another mechanism


class Shrinker:
    """A model while it becomes smaller.

    Parameters
    ----------
    fails : function of a model
        Whether it still shows the failure; models that are none are not asked about.
    seconds : float
        Time after which it stays as it is.
    """

    def __init__(self, model: sb.Model, fails: Fails, seconds: float) -> None:
        self.data: Data = copy.deepcopy(to_data(model))
        self.fails = fails
        self.end = time.monotonic() + seconds
        self.tried = 0

    @property
    def is_over(self) -> bool:
        """Whether the time is up."""
        return time.monotonic() > self.end

    def attempt(self, data: Data) -> bool:
        """Take other data if they are a model that still fails."""
        if data == self.data or self.is_over:
            return False
        try:
            model = from_data(_without_unused(data))
        except sb.SymbodyError:
            return False
        self.tried += 1
        if not self.fails(model):
            return False
        self.data = copy.deepcopy(_without_unused(data))
        return True

    def shrink(self) -> sb.Model:
        """The smallest model that these steps lead to."""
        before: Data = {}
        while self.data != before and not self.is_over:
            before = copy.deepcopy(self.data)
            self._remove_elements()
            self._remove_entries()
            self._simplify_numbers()
        return from_data(self.data)

    def _remove_elements(self) -> None:
        names = [entry["name"] for kind in KINDS[::-1] for entry in self.data.get(kind, [])]
        size = len(names)
        while size and not self.is_over:
            for start in range(0, len(names), size):
                gone = set(names[start : start + size])
                self.attempt(_without_elements(self.data, gone, with_joints=True)) or self.attempt(
                    _without_elements(self.data, gone, with_joints=False)
                )
            names = [entry["name"] for kind in KINDS[::-1] for entry in self.data.get(kind, [])]
            size //= 2

    def _remove_entries(self) -> None:
        """Keys of elements, turns of frames, initial values, formulas of parameters."""
        for where in list(_entries(self.data))[::-1]:
            if _at(self.data, where) is not None:
                self.attempt(_changed(self.data, where, None))

    def _simplify_numbers(self) -> None:
        for digits in (2, 3, 6):  # all at once, which is quick and often enough
            rounded = copy.deepcopy(self.data)
            for where in _leaves(rounded):
                rounded = _changed(rounded, where, _shortened(str(_at(rounded, where)), digits))
            if self.attempt(rounded):
                break
        for where in list(_leaves(self.data)):
            for simpler in _simpler(_at(self.data, where), is_angle="rotate" in where):
                if self.attempt(_changed(self.data, where, simpler)):
                    break


def shrunk(model: sb.Model, fails: Fails, seconds: float = 60.0) -> sb.Model:
    """A small model that fails as the given one does, which must fail itself."""
    return Shrinker(model, fails, seconds).shrink()


def write_to_corpus(model: sb.Model, law: str, what: str, comment: str, folder: Path = CORPUS) -> Path:
    """Save a model as <law>_<what>.toml, with a comment at the top that says what failed."""
    folder.mkdir(exist_ok=True)
    path = folder / f"{_word(law)}_{_word(what)}.toml"
    sb.save_model(model, path)
    lines = "".join(f"# {line}\n" for line in comment.splitlines())
    path.write_text(lines + path.read_text(encoding="utf-8"), encoding="utf-8")
    return path


def _word(text: str) -> str:
    return re.sub(r"\W+", "_", text.lower()).strip("_")


def _without_elements(data: Data, names: set[str], with_joints: bool) -> Data:
    """Data without some elements; without a body, also without what hangs on it, or at least its loads."""
    gone = set(names)
    bodies = {entry["name"] for entry in data.get("body", [])} & gone
    for kind in KINDS:
        for entry in data.get(kind, []):
            if bodies & _bodies_of(entry):
                gone.add(entry["name"])
    if with_joints and bodies:  # bodies that nothing joins to ground any more
        gone |= {entry["name"] for entry in data.get("body", []) if entry["name"] in _loose(data, gone)}
        return _without_elements(data, gone, with_joints=False) if gone > names else _filtered(data, gone)
    return _filtered(data, gone)


def _filtered(data: Data, gone: set[str]) -> Data:
    kept = {kind: [entry for entry in data.get(kind, []) if entry["name"] not in gone] for kind in KINDS}
    return {**data, **kept}


def _bodies_of(entry: Data) -> set[str]:
    places = [
        *entry.get("between", []),
        *(entry[word] for word in ("on", "reaction_on", "resolved_in") if word in entry),
    ]
    return {str(place).partition(".")[0] for place in places}


def _loose(data: Data, gone: set[str]) -> set[str]:
    joints = [entry for entry in data.get("joint", []) if entry["name"] not in gone]
    reached, size = {"ground"}, 0
    while len(reached) > size:
        size = len(reached)
        for entry in joints:
            if _bodies_of(entry) & reached:
                reached |= _bodies_of(entry)
    return {entry["name"] for entry in data.get("body", [])} - reached


def _without_unused(data: Data) -> Data:
    """Data without empty lists, frames nothing stands on, and parameters, initial values of nothing."""
    found = {key: value for key, value in data.items() if value not in ([], {})}
    elements = [entry for kind in KINDS for entry in found.get(kind, [])]
    places = {place for entry in elements for place in _places(entry)}
    if "ground" in found:
        frames = {k: v for k, v in found["ground"]["frames"].items() if f"ground.{k}" in places}
        found["ground"] = {"frames": frames}
    found["body"] = [
        {
            **entry,
            "frames": {k: v for k, v in entry.get("frames", {}).items() if f"{entry['name']}.{k}" in places},
        }
        for entry in found.get("body", [])
    ]
    words = set(re.findall(r"\w+", repr([v for k, v in found.items() if k not in ("parameters", "initial")])))
    words |= {w for text in found.get("initial", {}).values() for w in re.findall(r"\w+", str(text))}
    parameters = found.get("parameters", {})
    for _ in parameters:
        words |= {w for k, text in parameters.items() if k in words for w in re.findall(r"\w+", str(text))}
    found["parameters"] = {name: value for name, value in parameters.items() if name in words}
    try:
        known = {*from_data({**found, "initial": {}}).coordinates}
    except sb.SymbodyError:
        return found
    model = from_data({**found, "initial": {}})
    known |= {
        n
        for joint in (*model.joints, *model.free_joints)
        for n in (*joint.coordinates, *joint.quasi_speed_names)
    }
    known |= {f"{name}_dot" for name in known}
    found["initial"] = {name: value for name, value in found.get("initial", {}).items() if name in known}
    return {key: value for key, value in found.items() if value not in ([], {})}


def _places(entry: Data) -> list[str]:
    return [
        *entry.get("between", []),
        *(entry[w] for w in ("on", "reaction_on", "resolved_in") if w in entry),
    ]


def _entries(data: Data) -> Iterator[Where]:
    """Places of all that may be left out."""
    for kind in KINDS:
        for k, entry in enumerate(data.get(kind, [])):
            yield from ((kind, k, key) for key in entry if key not in _KEPT)
            for name, frame in entry.get("frames", {}).items():
                yield from ((kind, k, "frames", name, key) for key in frame)
                turns = frame.get("rotate", [])
                yield from ((kind, k, "frames", name, "rotate", n) for n in range(len(turns)))
    for name, frame in data.get("ground", {}).get("frames", {}).items():
        yield from (("ground", "frames", name, key) for key in frame)
    yield from (("initial", name) for name in data.get("initial", {}))


def _leaves(part: Any, where: Where = ()) -> Iterator[Where]:
    """Places of all texts that may be formulas."""
    if isinstance(part, str):
        yield where
    elif isinstance(part, dict):
        for key, value in part.items():
            if key not in _KEPT and not (not where and key in ("inputs",)):
                yield from _leaves(value, (*where, key))
    elif isinstance(part, list):
        for k, value in enumerate(part):
            yield from _leaves(value, (*where, k))


def _simpler(text: Any, is_angle: bool) -> Iterator[str]:
    """Texts that say less, the simplest first."""
    if not isinstance(text, str) or text in ("0", "1", "x", "y", "z"):
        return
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if is_angle and value == value:
        away = {
            word: abs((value - turn + math.pi) % (2 * math.pi) - math.pi) for word, turn in _TURNS.items()
        }
        yield from (word for word in _TURNS if away[word] < _CLOSE and word != text)
    yield from ("0", "1")
    for digits in _DIGITS:
        shorter = _shortened(text, digits)
        if len(shorter) < len(text):
            yield shorter


def _shortened(text: str, digits: int) -> str:
    """A text with all numbers in it rounded."""
    return _NUMBER.sub(lambda found: _rounded(found[0], digits), text)


def _rounded(number: str, digits: int) -> str:
    found = f"{float(number):.{digits}g}"
    return found if len(found) < len(number) else number


def _at(data: Data, where: Where) -> Any:
    part: Any = data
    for key in where:
        if isinstance(part, dict) and key in part:
            part = part[str(key)]
        elif isinstance(part, list) and isinstance(key, int) and key < len(part):
            part = part[key]
        else:
            return None
    return part


def _changed(data: Data, where: Where, value: str | None) -> Data:
    """Data with one place changed, or left out."""
    found = copy.deepcopy(data)
    part: Any = found
    for key in where[:-1]:
        part = part[key]
    if value is None:
        del part[where[-1]]
    else:
        part[where[-1]] = value
    return found
