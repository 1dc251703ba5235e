"""Problems as the page takes them: with a JSON pointer, the element, a line, and a safe repair."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from typing import Any, Final

from symbody.errors import Problem
from symbody.model.model import KINDS

PageProblem = dict[str, Any]

_POINTER: Final = re.compile(r"#((?:/[^,;]*)?)(?=,|;|$)")
_LINE: Final = re.compile(r":(\d+)(?=,|;|$)")
_SUGGESTION: Final = re.compile(r"did you mean '([^']+)'\?")
_UNKNOWN: Final = re.compile(r"there is no symbol '([^']+)'")
_CYCLE: Final = re.compile(r"the joints (.+) form a cycle")
_MISSPELLED: Final = re.compile(r"there is no [^']*'([^']+)'")
# Advice on files and Python, in the words of the page.
_ELSEWHERE: Final = (
    (re.compile(r" ?Or define it: \[parameters\].*$"), " Or make it a parameter."),
    (re.compile(r" ?Or define it: \[ground\.frames\].*$"), " Or add this frame to the ground."),
    (re.compile(r"unphysical=True (.*) \(unphysical = true in a file\)"), r"Unphysical, if ticked, \1"),
)


def page_problem(problem: Problem, data: Mapping[str, Any], severity: str = "error") -> PageProblem:
    """Return a problem as the page takes it.

    Parameters
    ----------
    data : mapping
        The model that the page edits; pointers lead into it.
    severity : "error", "warning" or "note"
    """
    pointer = _pointer(problem.where, data) or _last_of_cycle(problem, data)
    line = _LINE.search(problem.where)
    return {
        "severity": severity,
        "pointer": pointer,
        "element": element_name(pointer, data),
        "code": problem.code,
        "where": _words(problem.where),
        "what": problem.what,
        "why": problem.why,
        "fix": _cure(problem.fix),
        "line": int(line.group(1)) if line else None,
        "repair": _repair(problem, pointer, data),
    }


def page_problems(problems: Iterable[Problem], data: Mapping[str, Any]) -> list[PageProblem]:
    """Return several problems."""
    return [page_problem(problem, data) for problem in problems]


def page_notes(
    notes: Iterable[str], data: Mapping[str, Any], code: str = "builder.note"
) -> list[PageProblem]:
    """Return what is not a fault, but worth knowing."""
    return [page_problem(Problem(code, _label(note, data), note), data, "note") for note in notes]


def fault_problem(error: Exception) -> PageProblem:
    """Return what the page reads of an exception that nobody foresaw, without the insides of the server."""
    kind = type(error).__name__
    what = (
        "there is not enough memory for this" if isinstance(error, MemoryError) else f"an unexpected {kind}"
    )
    cure = "save the model, and report it with the model file"
    return page_problem(Problem("builder.fault", "", what, "this is a bug in symbody", cure), {})


def pointer_parts(pointer: str) -> list[str]:
    """Return the keys of a JSON pointer.

    >>> pointer_parts("/joint/2/axis")
    ['joint', '2', 'axis']
    """
    return [part.replace("~1", "/").replace("~0", "~") for part in pointer.split("/")[1:]]


def value_at(pointer: str, data: Any) -> Any:
    """Return what a pointer leads to, None if nothing."""
    for part in pointer_parts(pointer):
        if isinstance(data, list) and part.isdecimal() and int(part) < len(data):
            data = data[int(part)]
        elif isinstance(data, Mapping) and part in data:
            data = data[part]
        else:
            return None
    return data


def element_name(pointer: str, data: Mapping[str, Any]) -> str:
    """Return the name of the element that a pointer leads into, "" if into none."""
    parts = pointer_parts(pointer)
    if len(parts) < 2 or parts[0] not in KINDS:
        return ""
    entry = value_at(f"/{parts[0]}/{parts[1]}", data)
    name = entry.get("name") if isinstance(entry, Mapping) else None
    return name if isinstance(name, str) else ""


def _pointer(where: str, data: Mapping[str, Any]) -> str:
    match = _POINTER.search(where)
    return match.group(1) if match else label_pointer(where, data)


def label_pointer(where: str, data: Mapping[str, Any]) -> str:
    """Return the pointer to the element that words such as ``"joint elbow, axis"`` begin with, or ""."""
    for kind in KINDS:
        entries = data.get(kind)
        for k, entry in enumerate(entries if isinstance(entries, list) else []):
            name = entry.get("name") if isinstance(entry, Mapping) else None
            if isinstance(name, str) and f"{where}, ".startswith(f"{kind} {name}, "):
                return f"/{kind}/{k}"
    return ""


def _label(note: str, data: Mapping[str, Any]) -> str:
    """Return the element that a note begins with: ``"joint B is cut: ..."``."""
    for kind in KINDS:
        entries = data.get(kind)
        for entry in entries if isinstance(entries, list) else []:
            name = entry.get("name") if isinstance(entry, Mapping) else None
            if isinstance(name, str) and re.match(rf"{kind} {re.escape(name)}\b[ :,]", note):
                return f"{kind} {name}"
    return ""


def _cure(fix: str) -> str:
    """Return advice without what is of files and Python."""
    for pattern, words in _ELSEWHERE:
        fix = pattern.sub(words, fix)
    return fix


def _words(where: str) -> str:
    """Return a place without its pointers and lines."""
    parts = [_POINTER.sub("", part).strip(" ,") for part in where.split("; ")]
    return "; ".join(part for part in parts if part)


def _repair(problem: Problem, pointer: str, data: Mapping[str, Any]) -> dict[str, Any] | None:
    """Return a change that mends a problem without a decision of the user's, None if there is none."""
    if problem.code == "topology.cycle":
        return _cut_joint(problem, data)
    suggestion, misspelled = _SUGGESTION.search(problem.fix), _MISSPELLED.search(problem.what)
    value = value_at(pointer, data)
    if suggestion and misspelled and isinstance(value, str):
        changed = re.sub(rf"(?<!\w){re.escape(misspelled.group(1))}(?!\w)", suggestion.group(1), value)
        if changed != value:
            patch = {"op": "replace", "path": pointer, "value": changed}
            return {"label": f"write {suggestion.group(1)}", "patch": [patch]}
    unknown = _UNKNOWN.search(problem.what)
    if problem.code == "names.unknown" and unknown and "[parameters]" in problem.fix:
        return _new_parameter(unknown.group(1), data)
    if pointer.startswith("/initial/") and misspelled:  # its joint was deleted, or has other coordinates now
        patch = {"op": "remove", "path": pointer}
        return {"label": f"remove the initial value of {misspelled.group(1)}", "patch": [patch]}
    return None


def _new_parameter(name: str, data: Mapping[str, Any]) -> dict[str, Any]:
    patch: list[dict[str, Any]] = [{"op": "add", "path": f"/parameters/{name}", "value": "1"}]
    if not isinstance(data.get("parameters"), Mapping):
        patch = [{"op": "add", "path": "/parameters", "value": {name: "1"}}]
    return {"label": f"make {name} a parameter of value 1", "patch": patch}


def _last_of_cycle(problem: Problem, data: Mapping[str, Any]) -> str:
    """Return the pointer to the last joint of a cycle of a tree, "" if the problem is another."""
    match = _CYCLE.search(problem.what) if problem.code == "topology.cycle" else None
    return "" if match is None else label_pointer(f"joint {match.group(1).split(', ')[-1]}", data)


def _cut_joint(problem: Problem, data: Mapping[str, Any]) -> dict[str, Any] | None:
    """Return the change that takes the last joint of a cycle out of the trees."""
    pointer = _last_of_cycle(problem, data)
    if not pointer:
        return None
    name = element_name(pointer, data)
    patch = [{"op": "add", "path": f"{pointer}/tree", "value": False}]
    return {"label": f"make {name} a cotree joint", "patch": patch}
