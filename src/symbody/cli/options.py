"""What the commands have in common: their arguments and options."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

import typer


class TreeWord(StrEnum):
    """Which coordinates the equations are formed in."""

    JOINTS = "joints"
    ABSOLUTE = "absolute"


def option(*flags: str, text: str, metavar: str | None = None) -> Any:
    """Return an option with its help."""
    return typer.Option(*flags, help=text, metavar=metavar)


ModelFile = Annotated[Path, typer.Argument(metavar="MODEL.toml", help="The model file.")]
Pairs = list[str] | None
Settings = Annotated[
    Pairs,
    option("--set", "-p", metavar="NAME=VALUE", text="A parameter, input or initial value; repeatable."),
]
Inputs = Annotated[
    Pairs,
    option("--input", "-i", metavar="NAME=EXPRESSION", text="F='sin(t)', F=@run.csv[t,F]; repeatable."),
]
Initials = Annotated[
    Pairs, option("--initial", metavar="NAME=VALUE", text="Initial value of x or x_dot; repeatable.")
]
Tree = Annotated[
    TreeWord | None,
    typer.Option("--tree", help="Coordinates of the joints, or of free bodies; default: as in the model."),
]
Substitute = Annotated[
    bool,
    typer.Option("--substitute", help="Substitute gears, belts, racks and <mimic> in the equations."),
]
Force = Annotated[bool, option("--force", text="Overwrite existing files.")]
