"""Rewrite tables of elements and the schema of model files: ``python docs/list_elements.py``.

Both follow from what the elements declare: their fields, and the texts about their law.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

from symbody.formats import schema
from symbody.model import Drive
from symbody.model.declarations.declaration import Declared
from symbody.model.declarations.field import Field
from symbody.model.joint import Joint
from symbody.model.model import KINDS
from symbody.model.output_names import OUTPUT_KINDS, TITLES
from symbody.model.registry import element_types, type_word

DOCS = Path(__file__).parent
# Arguments that many elements share; the text beside the table tells about them.
SHARED = {
    "name", "start", "end", "coordinate", "coordinates", "tree", "force", "torque", "motion", "as_constraint",
    "armature", "friction",
}  # fmt: skip
ENDS = "limits"  # of joints; those of a block are its own
LONGEST = 72


def joints() -> str:
    """Return the table of joints."""
    rows = [
        (
            f"`{word}`",
            _arguments(kind),
            ", ".join(kind.letters),
            str(6 - _joint(kind).locked_directions),
            str(_joint(kind).locked_directions),
            f"`{kind.law}`",
        )
        for word, kind in element_types("joint").items()
        if issubclass(kind, Joint)
    ]
    rows.sort(key=lambda row: (row[3], row[0]))
    return _table(("type", "arguments", "coordinates", "n", "c", "law"), rows)


def constraints() -> str:
    """Return the table of constraints."""
    rows: list[tuple[str, ...]] = []
    for word, each in element_types("constraint").items():
        kind: Any = each
        unit = kind.multiplier_unit or "as written"
        rows.append((f"`{word}`", _arguments(kind), kind.rows, kind.holds, kind.multiplier, unit))
    return _table(("type", "arguments", "c", "holds", "a multiplier is", "unit"), rows)


def forces() -> str:
    """Return the table of force elements."""
    gravity = (
        "gravity",
        "m g in the centre of mass",
        "`gravity` is the acceleration of free fall, ground axes",
        "`potential_energy`",
    )
    drive = ("drive of a joint coordinate x: `force`, `torque`", *_texts(Drive))
    kinds = (each for kind in KINDS for each in element_types(kind).values())
    own = [each for each in kinds if hasattr(each, "sign")]  # a load; Bushing, of kind joint, stands last
    own.sort(key=lambda kind: kind.kind == "joint")
    loads = ((f"{_section(kind)}, `sb.{kind.__name__}`", *_texts(kind)) for kind in own)
    return _table(("element", "law", "sign", "outputs"), (gravity, drive, *loads))


def blocks() -> str:
    """Return the table of blocks."""
    rows = []
    for word, each in element_types("block").items():
        kind: Any = each
        rows.append((f"`{word}`, `sb.{kind.__name__}`", kind.equation, kind.states, _arguments(kind)))
    return _table(("type", "output y", "states", "arguments"), rows)


def outputs() -> str:
    """Return the table of outputs."""
    rows = [
        (f"`{kind.pattern}`", kind.meaning, kind.shape.replace(" x ", " × "), kind.unit)
        for title in TITLES
        for kind in OUTPUT_KINDS.values()
        if kind.title == title
    ]
    return _table(("output", "meaning", "shape", "unit"), rows)


def write(page: str, table: str) -> str:
    """Return the text of a page with its first table replaced."""
    text = (DOCS / page).read_text(encoding="utf-8")
    head, _, rest = text.partition("\n| ")
    below = rest.partition("\n\n")[2]
    return f"{head}\n{table}\n{below}"


def _joint(kind: type[Joint]) -> Joint:
    needed: dict[str, Any] = {name: 1 for name, field in kind.fields.items() if field.is_required}
    return kind(**{**needed, "name": "J", "start": "ground", "end": "B"})


def _texts(kind: Any) -> tuple[str, str, str]:
    shown = kind.outputs
    if not isinstance(shown, str):
        lists = ((word, names) for word, names in shown.items())
        shown = ", ".join(
            " ".join((f"`{word} S {names[0]}".rstrip() + "`", *(f"`{name}`" for name in names[1:])))
            for word, names in lists
        )
    return (kind.equation, kind.sign, shown)


def _section(kind: Any) -> str:
    word = type_word(kind)
    return f'`[[{kind.kind}]] type = "{word}"`' if word else f"`[[{kind.kind}]]`"


def _arguments(kind: type[Declared]) -> str:
    """Return the arguments of an element that others do not have, with their defaults and short sentences."""
    shared = SHARED | {ENDS} if issubclass(kind, Joint) else SHARED
    return "; ".join(_argument(name, field) for name, field in kind.fields.items() if name not in shared)


def _argument(name: str, field: Field[Any, Any]) -> str:
    given = field.is_required or field.default is None
    word = f"`{name}`" if given else f"`{name} = {json.dumps(field.default)}`"
    sentence = field.description.removesuffix(".")
    is_short = 0 < len(sentence) < LONGEST
    return f"{word}: {sentence[0].lower()}{sentence[1:]}" if is_short else word


def _table(head: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    return "\n".join(_lines(tuple(head), rows)) + "\n"


def _lines(head: tuple[str, ...], rows: Iterable[Iterable[str]]) -> Iterator[str]:
    yield f"| {' | '.join(head)} |"
    yield f"|{'---|' * len(head)}"
    for row in rows:
        yield f"| {' | '.join(row)} |"


PAGES = {"joints.md": joints, "constraints.md": constraints, "forces.md": forces, "signals.md": blocks,
         "outputs.md": outputs}  # fmt: skip

if __name__ == "__main__":
    for page, make in PAGES.items():
        (DOCS / page).write_text(write(page, make()), encoding="utf-8")
    Path(schema.__file__).with_name("schema.json").write_text(schema.schema_text(), encoding="utf-8")
