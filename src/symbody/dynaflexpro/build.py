"""`BuildEQs`, from a model or its file to the module with the equations, and `BuildModel`, the editor."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Sequence
from typing import Final

from symbody.dynaflexpro.exports import ModelEquations
from symbody.equations.form import form_equations
from symbody.errors import EnvironmentFault, Problem, UsageError, nearest
from symbody.formats.native import load_model
from symbody.graph.trees import TreeChoice
from symbody.model.joints import Free
from symbody.model.model import Model
from symbody.model.naming import GROUND

_FOREIGN: Final = (".dfp", ".mb")  # model and diagram
_HOW_TO_START: Final = (
    "describe the mechanism in a TOML file and call BuildEQs on it; 'symbody examples NAME --copy DIR' gives "
    "one to start from"
)

# Codes with which the editor ends when nothing went wrong: by itself, or by Ctrl-C.
_ENDED: Final = frozenset({0, 130})

# Option -> the values it may have.
_OPTIONS: Final = {"DynSimpType": ("None", "Simplify")}


def BuildEQs(
    model: Model | str | os.PathLike[str], options: Sequence[str] = (), *, tree: TreeChoice = None
) -> ModelEquations:
    """Return the equations of motion behind the names of DynaFlexPro.

    Parameters
    ----------
    model : Model or path
        The mechanism, or its model file. Bodies without a joint get Cardan angles x-y-z.
    options : sequence of str
        Option, value, option, value: ``["DynSimpType", "Simplify"]``. The equations always come in their
        short trigonometric form, so this changes nothing; `notes` says so.
    tree : Trees, "joints", "absolute" or None
        Which joints give the coordinates; see `form_equations`.

    Raises
    ------
    UsageError
        If an option is unknown, or the file is one of DynaFlexPro's.
    FormatError, ModelError, FormulationError
        If the model cannot be read, contradicts itself, or has no equations.
    """
    chosen = _parse_options(options)
    if not isinstance(model, Model):
        _refuse_foreign(model)
    described = model if isinstance(model, Model) else load_model(model)
    complete, notes = _with_free_joints(described)
    if chosen.get("DynSimpType") == "Simplify":
        notes = (*notes, "DynSimpType: the equations are always in their short trigonometric form")
    return ModelEquations(form_equations(complete, tree=tree), notes)


def BuildModel(path: str | os.PathLike[str] = "") -> None:
    """Open the diagram editor in the browser and wait until it is ended by Ctrl-C.

    It runs in a process of its own; ``symbody builder PATH`` does the same from the command line.

    Parameters
    ----------
    path : str
        Model file to begin with; without one the editor offers examples.

    Raises
    ------
    UsageError
        If the file is one of DynaFlexPro's.
    EnvironmentFault
        If the editor cannot run on this computer.
    """
    _refuse_foreign(path)
    given = [os.fspath(path)] if os.fspath(path) else []
    try:
        code = subprocess.run([sys.executable, "-m", "symbody", "builder", *given], check=False).returncode
    except KeyboardInterrupt:
        return
    if code not in _ENDED:
        raise EnvironmentFault(
            Problem("dynaflexpro.build_model", os.fspath(path), "the editor ended with an error",
                    "see the message above, on standard error",
                    "run symbody builder in a terminal to see it again")
        )  # fmt: skip


def _refuse_foreign(path: str | os.PathLike[str]) -> None:
    suffix = os.path.splitext(os.fspath(path))[1].lower()
    if suffix in _FOREIGN:
        raise UsageError(
            Problem("dynaflexpro.foreign_file", os.fspath(path), f"{suffix} files cannot be read",
                    "they belong to another program", _HOW_TO_START)
        )  # fmt: skip


def _parse_options(options: Sequence[str]) -> dict[str, str]:
    """Return the options as a mapping.

    Raises
    ------
    UsageError
        With every option that is unknown or has no value it may have.
    """
    words = [options] if isinstance(options, str) else list(options)
    pairs = [(words[k], words[k + 1] if k + 1 < len(words) else "") for k in range(0, len(words), 2)]
    problems = []
    for name, value in pairs:
        if name not in _OPTIONS:
            cure = nearest(name, _OPTIONS)
            problems.append(
                Problem("dynaflexpro.option", "options", f"there is no option {name!r}", "", cure)
            )
        elif value not in _OPTIONS[name]:
            problems.append(
                Problem("dynaflexpro.option_value", "options", f"{name} cannot be {value!r}",
                        "options come in pairs of name and value", nearest(value, _OPTIONS[name]))
            )  # fmt: skip
    if problems:
        raise UsageError(*problems)
    return dict(pairs)


def _with_free_joints(model: Model) -> tuple[Model, tuple[str, ...]]:
    """Return a model in which every body has a joint, and what was added.

    The coordinates of a body B are ``B_x, B_y, B_z`` and the Cardan angles ``B_alpha, B_beta, B_gamma``
    about x, y, z.
    """
    loose = _loose(model)
    if not loose:
        return model, ()
    joints = [_free(body) for body in loose]
    complete = Model(
        model.name,
        [*model.elements, *joints],
        gravity=model.gravity,
        parameters=model.parameters,
        inputs=model.inputs,
        initial=model.initial,
        ground=model.ground,
        ground_shapes=model.ground_shapes,
    )
    return complete, tuple(f"body {body} is free: six coordinates, Cardan angles x-y-z" for body in loose)


def _loose(model: Model) -> list[str]:
    """Return the bodies without a joint; the model itself refuses bodies joined to each other alone."""
    held = {end.body for joint in model.joints for end in (joint.start, joint.end)}
    return [body.name for body in model.bodies if body.name not in held]


def _free(body: str) -> Free:
    names = [f"{body}_{word}" for word in ("x", "y", "z", "alpha", "beta", "gamma")]
    return Free(f"{body}_free", GROUND, body, angles="123", coordinates=names)
