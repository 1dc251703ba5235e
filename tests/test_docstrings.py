"""Docstrings name what is there: fields, arguments and classes that somebody renamed are found here."""

from __future__ import annotations

import ast
import builtins
import re
from collections.abc import Iterator
from functools import cache, lru_cache
from pathlib import Path

SOURCE = Path(__file__).parents[1] / "src" / "symbody"
SECTION = re.compile(r"^(Attributes|Parameters|Returns)\n-+\n(.*?)(?=\n\n\S[^\n]*\n-+\n|\Z)", re.S | re.M)
# Proper names of other things than classes.
WORDS = {"LaTeX", "MathML", "SymPy"}
# A class with both sections, whose arguments are taken by `__new__` of a C type.
OTHER_ARGUMENTS = {"DirectCall"}


@cache
def texts() -> dict[str, str]:
    return {str(path.relative_to(SOURCE)): path.read_text(encoding="utf-8") for path in SOURCE.rglob("*.py")}


@cache
def defined_names() -> frozenset[str]:
    """Classes, aliases and imports of the whole package."""
    names = {*dir(builtins), *WORDS}
    for text in texts().values():
        tree = ast.parse(text)
        for node in ast.walk(tree):
            if isinstance(node, ast.ClassDef):
                names.add(node.name)
            elif isinstance(node, ast.Import | ast.ImportFrom):
                names |= {alias.asname or alias.name for alias in node.names}
        for statement in tree.body:
            names |= {target.id for target in _targets(statement) if isinstance(target, ast.Name)}
    return frozenset(names)


def _targets(node: ast.AST) -> list[ast.expr]:
    if isinstance(node, ast.Assign):
        several = [each.elts if isinstance(each, ast.Tuple) else [each] for each in node.targets]
        return [target for targets in several for target in targets]
    return [node.target] if isinstance(node, ast.AnnAssign) else []


def entries(node: ast.ClassDef | ast.FunctionDef) -> Iterator[tuple[str, list[str], str]]:
    """Section, names and type of each entry of a docstring."""
    for section in SECTION.finditer(ast.get_docstring(node) or ""):
        for line in section.group(2).split("\n"):
            if line and not line[0].isspace():
                head, _, kind = line.partition(" : ")
                yield section.group(1), [name.strip().lstrip("*") for name in head.split(",")], kind


@lru_cache(maxsize=1)
def members(node: ast.ClassDef) -> set[str]:
    """Fields, methods and attributes of a class."""
    names = {each.name for each in node.body if isinstance(each, ast.FunctionDef)}
    for inner in ast.walk(node):
        for target in _targets(inner):
            names |= {target.attr} if isinstance(target, ast.Attribute) else set()
    for inner in node.body:
        names |= {target.id for target in _targets(inner) if isinstance(target, ast.Name)}
    return names


def arguments(node: ast.ClassDef | ast.FunctionDef) -> set[str] | None:
    if isinstance(node, ast.ClassDef):
        made = [each for each in node.body if isinstance(each, ast.FunctionDef) and each.name == "__init__"]
        if not made or node.name in OTHER_ARGUMENTS:
            return None
        return arguments(made[0])
    given = node.args
    listed = [*given.posonlyargs, *given.args, *given.kwonlyargs, given.vararg, given.kwarg]
    return {each.arg for each in listed if each is not None}


def offences(file: str, tree: ast.Module) -> Iterator[str]:
    for node in ast.walk(tree):
        if not isinstance(node, ast.ClassDef | ast.FunctionDef):
            continue
        for section, names, kind in entries(node):
            place = f"{file}:{node.lineno} {node.name}"
            for word in re.findall(r"\b[A-Z][a-z]+\w*", kind):
                if word not in defined_names():
                    yield f"{place}: there is no {word}"
            there = members(node) if section == "Attributes" and isinstance(node, ast.ClassDef) else None
            there = arguments(node) if section == "Parameters" else there
            if there is not None:
                yield from (f"{place}: no {x}" for x in names if x.isidentifier() and x not in there)


def test_docstrings_name_what_is_there() -> None:
    assert [line for file, text in sorted(texts().items()) for line in offences(file, ast.parse(text))] == []


def test_a_stale_name_is_found() -> None:
    text = '''
class Load:
    """A load.

    Attributes
    ----------
    arm : Vector
    factor : Gone
    """

    position: Vector
    factor: Expr

    def scale(self, by: float) -> Load:
        """Scale it.

        Parameters
        ----------
        factor : float
        """
'''
    assert list(offences("load.py", ast.parse(text))) == [
        "load.py:2 Load: no arm", "load.py:2 Load: there is no Gone", "load.py:14 scale: no factor",
    ]  # fmt: skip
