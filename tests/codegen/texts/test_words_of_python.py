"""Names of users beside the words of generated Python: whatever a symbol is called, the text stays right."""

from __future__ import annotations

import ast
import builtins
import keyword
import symtable
from collections.abc import Iterator

import numpy as np
import pytest

import symbody as sb

# Forces that use every word of the texts: a choice, connectives, functions, a table of two places.
FORCE = "if(x > 1 and x < 2 or not (x < 0), sqrt(abs(x)), sin(x)) + floor(x) + min(x, atan2(x, 1)) + sign(x)"


def mechanism(names: list[str], coordinate: str = "x") -> sb.EquationSet:
    """A mass on a spring whose force is a sum over parameters with these names."""
    force = " + ".join([FORCE.replace("x", coordinate) if coordinate != "x" else FORCE, *names])
    mass = sb.Body("Mass", mass=2)
    drive = sb.Drive(applied=force)
    slider = sb.Prismatic("slider", "ground", mass, axis="x", coordinate=coordinate, force=drive)
    values = {name: 1.0 + k / 8 for k, name in enumerate(names)}
    return sb.form_equations(sb.Model("words", [mass, slider], parameters=values))


def is_legal(name: str) -> bool:
    try:
        sb.Model("words", parameters={name: 1.0})
    except sb.SymbodyError:
        return False
    return True


def words_of(text: str) -> set[str]:
    """Names that stand in the code of a text, not in what it says."""
    nodes = list(ast.walk(ast.parse(text)))
    names = {node.id for node in nodes if isinstance(node, ast.Name)}
    return names | {node.attr for node in nodes if isinstance(node, ast.Attribute)}


def all_words(language: str) -> list[str]:
    texts = [
        sb.generate_code(mechanism(["k"]), outputs, language) for outputs in ("udot", ["xdot", "energy"])
    ]
    known = set().union(*map(words_of, texts)) | set(dir(builtins)) | {*keyword.kwlist, *keyword.softkwlist}
    known -= {"x", "x_dot", "x_ddot"}  # names of the mechanism itself
    return sorted(word for word in known if not word.startswith("_") and is_legal(word))


def parts(words: list[str], size: int = 40) -> Iterator[list[str]]:
    for start in range(0, len(words), size):
        yield words[start : start + size]


def test_generated_python_with_its_own_words_as_parameters() -> None:
    for words in parts(all_words("python")):
        eqs = mechanism(words)
        values = [float(str(eqs.model.parameters[name])) for name in words]
        scope: dict[str, object] = {}
        exec(sb.generate_code(eqs, "udot", "python"), scope)
        function = scope["f"]
        assert callable(function)
        expected = sb.compile(eqs, "udot", free=words)
        for x in (-0.5, 1.5, [[0.25], [1.25]]):  # points, and batches, which take another way
            q = x if isinstance(x, list) else [x]
            u = [[0.0]] * 2 if isinstance(x, list) else [0.0]
            found = np.asarray(function(0.0, np.array(q), np.array(u), (), np.array(values)))
            np.testing.assert_allclose(
                found, expected(0.0, q, u, (), values), rtol=1e-12 * len(words)
            )  # sums of as many terms, in another order


@pytest.mark.parametrize("language", ["python", "jax", "casadi"])
def test_no_name_of_a_user_hides_what_a_text_uses(language: str) -> None:
    """What a function of the text reads from outside is never a variable of a user inside."""
    for words in parts(all_words(language)):
        text = sb.generate_code(mechanism(words), "udot", language)
        inside: set[str] = set()
        outside: set[str] = set()
        for table in functions(symtable.symtable(text, "text", "exec")):
            inside |= {symbol.get_name() for symbol in table.get_symbols() if symbol.is_local()}
            outside |= {symbol.get_name() for symbol in table.get_symbols() if symbol.is_global()}
        assert not inside & outside & set(words), (language, inside & outside & set(words))


def functions(table: symtable.SymbolTable) -> Iterator[symtable.SymbolTable]:
    for child in table.get_children():
        yield child
        yield from functions(child)


@pytest.mark.parametrize("word", ["float", "np", "len", "Outputs", "print"])
def test_coordinates_called_like_words(word: str) -> None:
    eqs = mechanism([], coordinate=word)
    scope: dict[str, object] = {}
    exec(sb.generate_code(eqs, "udot", "python"), scope)
    function = scope["f"]
    assert callable(function)
    expected = sb.compile(eqs, "udot")(0.0, [0.25], [0.0])
    np.testing.assert_allclose(function(0.0, [0.25], [0.0]), expected, rtol=1e-14)
