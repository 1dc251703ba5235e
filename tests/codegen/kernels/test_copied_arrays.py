"""Languages whose arrays are values: a call inside an expression cannot change any."""

from __future__ import annotations

import pytest

from symbody.codegen.kernels.c_kernels import C
from symbody.codegen.kernels.dialect import Arrays, KernelDialect
from symbody.codegen.kernels.javascript_kernels import JAVASCRIPT
from symbody.codegen.kernels.matlab_kernels import MATLAB
from symbody.codegen.kernels.reader import read_text
from symbody.codegen.kernels.source import KernelError
from symbody.codegen.kernels.text_writer import kernel_text

CHANGES = (
    "from symbody.kernels.language import Reals, part\n"
    "def change(x: Reals) -> float:\n    x[0] = 1.0\n    return x[0]\n"
    "def read(x: Reals) -> float:\n    return x[0]\n"
)
INSIDE = {
    "operand": "def f(x: Reals) -> float:\n    y = 2.0 * change(x)\n    return y\n",
    "condition": "def f(x: Reals) -> float:\n    if change(x) < 0.0:\n        return 0.0\n    return 1.0\n",
    "loop": "def f(x: Reals) -> float:\n    while change(x) < 0.0:\n        break\n    return 1.0\n",
    "argument": "def f(x: Reals) -> float:\n    y = max(change(x), 0.0)\n    return y\n",
    "entry": "def f(x: Reals) -> None:\n    x[1] = change(x)\n",
    "part": "def f(x: Reals) -> float:\n    y = 1.0 - change(part(x, 1, 2))\n    return y\n",
}
ALONE = (
    "def f(x: Reals) -> float:\n    y = change(x)\n    change(x)\n    if read(x) < y:\n        return 2.0 * read(x)\n"
    "    return change(x)\n"
)


def written(text: str, dialect: KernelDialect) -> str:
    return kernel_text(read_text(CHANGES + text, "kernels/case.py"), dialect)


@pytest.mark.parametrize("case", INSIDE)
def test_changes_inside_an_expression_are_refused(case: str) -> None:
    assert MATLAB.arrays == Arrays.COPIES
    with pytest.raises(KernelError) as caught:
        written(INSIDE[case], MATLAB)
    (problem,) = caught.value.problems
    assert problem.code == "kernel.changes_in_expression" and problem.where == "kernel f"
    assert "change changes arrays" in problem.what and "value = change(...)" in problem.fix
    for dialect in (C, JAVASCRIPT):
        assert "symbody_change(" in written(INSIDE[case], dialect)


def test_calls_that_are_assigned_return_what_they_change() -> None:
    text = written(ALONE, MATLAB)
    assert "[y, x] = symbody_change(x);" in text and "2.0 * symbody_read(x)" in text
