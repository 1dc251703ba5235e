"""The kernel language: what it takes, what it refuses, and what the reader makes of it."""

from __future__ import annotations

import pytest

from symbody.codegen.kernels.reader import read_kernels, read_text
from symbody.codegen.kernels.source import KernelError
from symbody.codegen.kernels.tree import Type

HEAD = "from typing import Final\nfrom symbody.kernels.language import Reals, part\n"

# Text of a kernel file, line of the fault, and a word of the message.
REFUSALS = {
    "statement": ("def f(x: float) -> float:\n    del x\n    return 1.0\n", 4, "statement"),
    "power": ("def f(x: float) -> float:\n    return x ** 2.0\n", 4, "operator"),
    "integer division": ("def f(n: int) -> float:\n    return n / 2\n", 4, "integers are divided"),
    "floor division": ("def f(n: int) -> int:\n    return n // 2\n", 4, "operator"),
    "unknown function": ("def f(x: float) -> float:\n    return print(x)\n", 4, "print"),
    "unknown name": ("def f(x: float) -> float:\n    return y\n", 4, "y has no value"),
    "unknown type": ("def f(x: str) -> float:\n    return 1.0\n", 3, "type"),
    "no annotation": ("def f(x) -> float:\n    return 1.0\n", 3, "type"),
    "array result": ("def f(x: Reals) -> Reals:\n    return x\n", 3, "returns an array"),
    "two types": ("def f() -> float:\n    x = 1\n    x = 1.5\n    return x\n", 5, "assigned as int"),
    "parameter assigned": ("def f(x: float) -> float:\n    x = 1.0\n    return x\n", 4, "parameter"),
    "counter assigned": (
        "def f() -> None:\n    for k in range(3):\n        k = 1\n", 5, "counter",
    ),
    "bounds changed": (
        "def f() -> None:\n    n = 3\n    for k in range(n):\n        n = k\n", 5, "bounds",
    ),
    "other loop": ("def f(x: Reals) -> None:\n    for k in x:\n        x[0] = 1.0\n", 4, "range"),
    "number as condition": ("def f(n: int) -> None:\n    while n:\n        break\n", 4, "not a condition"),
    "float as index": ("def f(x: Reals) -> float:\n    return x[1.0]\n", 4, "float stands where int"),
    "entry of a number": ("def f(x: float) -> float:\n    return x[0]\n", 4, "only arrays"),
    "no result": ("def f(x: float) -> float:\n    if x > 0.0:\n        return x\n", 3, "without a result"),
    "result of none": ("def f(x: float) -> None:\n    return x\n", 4, "has no result"),
    "too few arguments": (
        "def g(x: float, y: float) -> float:\n    return x\ndef f() -> float:\n    return g(1.0)\n", 6, "2 arguments",
    ),
    "circle": (
        "def f(x: float) -> float:\n    return g(x)\ndef g(x: float) -> float:\n    return f(x)\n", 0, "circle",
    ),
    "other import": ("import math\n", 3, "only imports"),
    "other module": ("from math import pi\n", 3, "import nothing from math"),
    "constant of a name": ("A: Final = b\n", 3, "made of numbers"),
    "assignment to two": ("def f() -> int:\n    a = b = 1\n    return a\n", 4, "statement"),
    "comparison of arrays": ("def f(x: Reals) -> None:\n    while x < 1.0:\n        break\n", 4, "operands"),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSALS)
def test_what_is_outside_the_language_is_refused_with_its_line(case: str) -> None:
    text, line, word = REFUSALS[case]
    with pytest.raises(KernelError) as caught:
        read_text(HEAD + text, "kernels/case.py")
    (problem,) = caught.value.problems
    assert problem.where == f"kernels/case.py:{line}"
    assert word in problem.what
    assert problem.fix


def test_types_conversions_and_changes() -> None:
    text = (
        "SHARE: Final = 2.0**-2\n"
        "def fill(n: int, x: Reals) -> None:\n"
        "    for k in range(n):\n        x[k] = SHARE * k\n"
        "def f(n: int, x: Reals, y: Reals) -> float:\n"
        "    tail = part(x, n, 2)\n    fill(n, tail)\n    total = y[0] + 1\n    return total\n"
    )
    kernels = read_text(HEAD + text, "kernels/case.py")
    tree = kernels["f"]
    assert list(kernels) == ["fill", "f"]
    assert [(p.name, p.is_changed) for p in tree.parameters] == [("n", False), ("x", True), ("y", False)]
    assert dict(tree.variables) == {"tail": Type.ARRAY, "total": Type.REAL}
    assert tree.result == Type.REAL


def test_kernels_stand_behind_those_they_call() -> None:
    kernels = read_kernels("solve_saddle")
    places = {name: place for place, name in enumerate(kernels)}
    assert (
        places["tail_product"] < places["factor_rows"] < places["solve_saddle_cut"] < places["solve_saddle"]
    )
