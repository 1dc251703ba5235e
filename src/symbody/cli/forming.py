"""The equations of a model file, as options of a command choose them."""

from __future__ import annotations

from pathlib import Path

from symbody.cli.options import TreeWord
from symbody.equations.equation_set import EquationSet
from symbody.equations.form import form_equations
from symbody.formats.model_files import load_model


def form_file(path: Path, tree: TreeWord | None, substitute: bool) -> EquationSet:
    """Return the equations of the model in a file.

    Raises
    ------
    SymbodyError
        If the file is no model, or its equations cannot be formed.
    """
    return form_equations(load_model(path), tree=None if tree is None else tree.value, substitute=substitute)
