"""Rewrite the table of docs/messages.md from the messages in the source: ``python docs/list_messages.py``.

A message is any call whose arguments hold a code such as ``"model.axis_letter"`` followed by where, what,
why and fix, or by names of these. Names are followed to what is assigned to them, or given at the first call
of the function whose arguments they are; parts that only a run knows show as an ellipsis.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Final, NamedTuple

ROOT = Path(__file__).parents[1]
CODE = re.compile(r"[a-z][a-z_]*\.[a-z][a-z0-9_]*")
# Calls with a code that are no messages, and those whose code is not followed by the place.
_OTHERS: Final = frozenset({
    "Demand", "FmuVariable", "Path", "_indicator", "FormulaSite", "RotationStep", "TranslationStep",
    "fill_page",
    "from_file", "read", "value", "values", "check_numbers", "formula_sites", "page_notes",
})  # fmt: skip
_WITHOUT_PLACE: Final = frozenset({"Domain", "Refusal"})
_WORDS: Final = ("where", "what", "why", "fix")
# Functions that write cures, where following them says less.
_KNOWN: Final = {"nearest": "did you mean …?", "quotation_cure": "", "frame_cure": ""}
_DEPTH: Final = 8
_WORDS_OF_A_RUN: Final = re.compile(r"\{[a-z]+\}")  # that `format` fills in


class Message(NamedTuple):
    """One place that reports a problem."""

    code: str
    what: str
    fix: str
    place: str


@cache
def all_messages() -> Sequence[Message]:
    """Return what is reported in all places of the source."""
    return [found for source in _sources() for call in source.calls for found in _message(call, source)]


def messages() -> dict[str, tuple[str, str]]:
    """Return for each code what the message says and how it is mended."""
    found: dict[str, tuple[str, str]] = {}
    for code, what, fix, _ in all_messages():
        old = found.get(code, ("", ""))
        found[code] = tuple(
            new if before.strip(" …") == "" and new else before
            for before, new in zip(old, (what, fix), strict=True)
        )
    return dict(sorted(found.items()))


def without_cure() -> list[str]:
    """Return the places whose message does not say what to do."""
    return [f"{place}: {code}" for code, _, fix, place in all_messages() if not fix]


class _Source:
    """One file, with what its names stand for."""

    def __init__(self, path: Path) -> None:
        self.path = path.relative_to(ROOT).as_posix()
        self.tree = ast.parse(path.read_text(encoding="utf-8"))
        self.functions: dict[str, ast.FunctionDef] = {}
        self.owner: dict[ast.AST, ast.FunctionDef] = {}
        self.calls: list[ast.Call] = []
        for node in ast.walk(self.tree):
            if isinstance(node, ast.FunctionDef):
                self.functions[node.name] = node
                self.owner |= {inner: node for inner in ast.walk(node) if inner is not node}
            elif isinstance(node, ast.Call):
                self.calls.append(node)

    def texts(self, node: ast.expr, depth: int = 0) -> str:
        """Return the text that an expression makes, "" if it is empty."""
        if depth > _DEPTH:
            return "…"
        if isinstance(node, ast.Constant):
            return _WORDS_OF_A_RUN.sub("…", node.value) if isinstance(node.value, str) else "…"
        if isinstance(node, ast.JoinedStr):
            return _WORDS_OF_A_RUN.sub("…", "".join(_template(part) for part in node.values))
        return self._composed(node, depth + 1)

    def _composed(self, node: ast.expr, depth: int) -> str:
        if isinstance(node, ast.IfExp):
            return self.texts(node.body, depth) or self.texts(node.orelse, depth)
        if isinstance(node, ast.BoolOp):
            return next(filter(None, (self.texts(each, depth) for each in node.values)), "")
        if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Add):
            return self.texts(node.left, depth) + self.texts(node.right, depth)
        if isinstance(node, ast.Name):
            return self._named(node, depth)
        if isinstance(node, ast.Call):
            return self._returned(node, depth)
        return "…"

    def _named(self, node: ast.Name, depth: int) -> str:
        """Return what a name stands for: a variable of its function, an argument, or a constant."""
        owner = self.owner.get(node)
        for scope in filter(None, (owner, self.tree)):
            values = [value for name, value in _assignments(scope) if name == node.id]
            found = [text for text in (self.texts(value, depth) for value in values) if text]
            if values:
                return next((text for text in found if text != "…"), found[0] if found else "")
        if owner is not None and node.id in _parameters(owner):
            return self._given(owner, node.id, depth)
        return "…"

    def _given(self, function: ast.FunctionDef, name: str, depth: int) -> str:
        """Return what is given for an argument by the calls in the file."""
        names = [each for each in _parameters(function) if each not in ("self", "cls")]
        texts = []
        for call in self.calls:
            if _called(call) == function.name:
                named = {word.arg: word.value for word in call.keywords}
                given = named.get(name) or dict(zip(names, call.args, strict=False)).get(name)
                texts.append("" if given is None else self.texts(given, depth))
        return next((text for text in texts if text and text != "…"), "…" if "…" in texts else "")

    def _returned(self, call: ast.Call, depth: int) -> str:
        name = _called(call)
        if name == "join":
            return "…"
        if name in _KNOWN:
            return _KNOWN[name]
        if name == "get" and len(call.args) == 2:
            return self.texts(call.args[1], depth)
        function = self.functions.get(name)
        if function is None and name in _homes():
            function = _homes()[name].functions[name]
        if function is None:
            return "…"
        returned = [each.value for each in ast.walk(function) if isinstance(each, ast.Return) and each.value]
        home = self if self.functions.get(name) is function else _homes()[name]
        texts = [text for text in (home.texts(value, depth) for value in returned) if text]
        return next((text for text in texts if text != "…"), "…" if texts else "")


def _assignments(scope: ast.FunctionDef | ast.Module) -> Iterator[tuple[str, ast.expr]]:
    """Yield names with the values that they are given, pairs of tuples one by one."""
    nodes = ast.walk(scope) if isinstance(scope, ast.FunctionDef) else iter(scope.body)
    for node in nodes:
        targets = node.targets if isinstance(node, ast.Assign) else []
        targets = [node.target] if isinstance(node, ast.AnnAssign | ast.AugAssign) else targets
        value = getattr(node, "value", None)
        for target in targets:
            if isinstance(target, ast.Name) and value is not None:
                yield target.id, value
            elif isinstance(target, ast.Tuple):
                values = value.elts if isinstance(value, ast.Tuple) else [value] * len(target.elts)
                pairs = zip(target.elts, values, strict=False)
                yield from ((name.id, each) for name, each in pairs if isinstance(name, ast.Name))


def _parameters(function: ast.FunctionDef) -> list[str]:
    given = function.args
    return [each.arg for each in (*given.posonlyargs, *given.args, *given.kwonlyargs)]


def _called(call: ast.Call) -> str:
    """Return the last word of what is called."""
    return getattr(call.func, "id", getattr(call.func, "attr", ""))


@cache
def _sources() -> Sequence[_Source]:
    # Names of values in machine code look like codes.
    paths = sorted(path for path in (ROOT / "src").rglob("*.py") if path.parent.name != "llvm")
    return [_Source(path) for path in paths]


@cache
def _homes() -> Mapping[str, _Source]:
    """Return the files of functions whose name no function of another file has."""
    found: dict[str, list[_Source]] = {}
    for source in _sources():
        for name in source.functions:
            found.setdefault(name, []).append(source)
    return {name: those[0] for name, those in found.items() if len(those) == 1}


def _message(call: ast.Call, source: _Source) -> Iterator[Message]:
    name = _called(call)
    places = [k for k, argument in enumerate(call.args) if _code(argument)]
    if not places or name in _OTHERS:
        return
    inner = _inner_problem(name)
    source, said = inner or (source, call)
    given = _given_words(said, 0 if inner else places[0], name)
    if "what" in given:
        texts = [source.texts(given[word]) if word in given else "" for word in ("what", "fix")]
        yield Message(_code(call.args[places[0]]), *texts, f"{source.path}:{call.lineno}")


def _given_words(call: ast.Call, place: int, name: str) -> dict[str, ast.expr]:
    """Return the arguments behind the code; ``*name`` stands for what, why and fix."""
    words = _WORDS[1:] if name in _WITHOUT_PLACE else _WORDS
    given = dict(zip(words, call.args[place + 1 :], strict=False))
    if isinstance(given.get("what"), ast.Starred):
        given["fix"] = given["what"] = given["what"].value
    return given | {word.arg: word.value for word in call.keywords if word.arg is not None}


def _inner_problem(name: str) -> tuple[_Source, ast.Call] | None:
    """Return the problem that a function makes which takes no more than the code."""
    home = _homes().get(name)
    if home is None or {"what", "fix"} & {*_parameters(home.functions[name])}:
        return None
    function = home.functions[name]
    inner = [call for call in home.calls if home.owner.get(call) is function and _called(call) == "Problem"]
    return (home, inner[0]) if inner else None


def _code(node: ast.expr) -> str:
    """Return the code that an expression is, "" if it is none."""
    text = _template(node) if isinstance(node, ast.Constant | ast.JoinedStr) else ""
    return text if CODE.fullmatch(text.replace("…", "x")) and not text.startswith("…") else ""


def _template(node: ast.expr) -> str:
    if isinstance(node, ast.Constant):
        return node.value if isinstance(node.value, str) else "…"
    if isinstance(node, ast.JoinedStr):
        return "".join(_template(part) for part in node.values)
    return "…"


def table() -> str:
    """Return the table as Markdown."""
    rows = [f"| `{code}` | {_cell(what)} | {_cell(fix)} |" for code, (what, fix) in messages().items()]
    return "\n".join(["| code | meaning | cure |", "| --- | --- | --- |", *rows]) + "\n"


def _cell(text: str) -> str:
    return " ".join(text.split()).replace("|", r"\|")


if __name__ == "__main__":
    page = ROOT / "docs" / "messages.md"
    head = page.read_text(encoding="utf-8").partition("| code |")[0]
    page.write_text(head + table(), encoding="utf-8")
